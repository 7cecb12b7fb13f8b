"""Numbers of the package against exact ones."""

import json

import numpy as np
import pytest

import swimmer
from swimmer import Scene

#: Net displacement of the three-sphere swimmer with arms of 10 and 6 radii in a ball of 40 radii
#: and in unbounded fluid, by collinear multipole expansions to rounding (docs/validation.md).
IN_BALL = 0.1604180159643671
UNBOUNDED = 0.1598053404


def ball(**keys):
    return {"name": "ball", "radius": 1, "position": [0, 0, 0], **keys}


def pair(model, distance, tolerance=1e-3):
    bodies = [ball(name=name, position=[x, 0, 0]) for name, x in [("a", 0), ("b", distance)]]
    return Scene.from_dict({"bodies": bodies, "model": {"kind": model, "tolerance": tolerance}})


@pytest.mark.parametrize(
    ("domain", "exact"),
    [({"kind": "unbounded"}, UNBOUNDED), ({"kind": "ball", "radius": 40}, IN_BALL)],
)
def test_the_default_stroke_has_the_exact_displacement_within_its_bar(domain, exact):
    scene = Scene.from_template("three-sphere")
    scene = scene.with_values({f"domain.{key}": value for key, value in domain.items()})
    run = scene.run(progress=False)
    assert abs(run.net - exact) <= run.net_error <= 1e-3 * exact
    assert run.errors.total == pytest.approx(sum(run.errors.by_source.values()))
    assert len(run.phases) == 4
    assert sum(p.displacement for p in run.phases) == pytest.approx(run.displacement)
    assert run.positions[-1] - run.positions[0] == pytest.approx(run.displacement)
    assert run.quaternions.shape == (len(run.times), 3, 4)
    assert run.quaternions[0] == pytest.approx(np.tile([0, 0, 0, 1], (3, 1)))
    assert run.curve_positions.shape == (len(run.curve_times), 3, 3)


def test_a_dragged_sphere_has_stokes_drag():
    solution = Scene.from_dict({"bodies": [ball(force=[6 * np.pi, 0, 0])]}).solve()
    assert solution.velocity == pytest.approx(np.array([[1, 0, 0]]), abs=1e-12)
    assert solution.force[0] == pytest.approx([6 * np.pi, 0, 0])
    assert solution.power == pytest.approx(6 * np.pi)


@pytest.mark.parametrize("kind", ["multipole", "axisymmetric"])
def test_a_squirmer_has_the_stresslet_of_its_second_mode(kind):
    """4 pi / 3 mu a^2 B2 (3 e e^T - 1) with the axis e: Ishikawa et al. (2006)."""
    slip = {"b1": 1, "b2": -0.7, "axis": [0, 0, 1]}
    scene = {"fluid": {"viscosity": 3}, "model": {"kind": kind}, "bodies": [ball(slip=slip)]}
    solution = Scene.from_dict(scene).solve()
    exact = 4 * np.pi * -0.7 * np.diag([-1, -1, 2])
    rounding = 1e-12 * np.linalg.norm(exact)
    assert solution.stresslet.shape == (1, 3, 3)
    assert solution.stresslet_error < 1e-4
    assert np.linalg.norm(solution.stresslet[0] - exact) <= solution.stresslet_error + rounding
    assert "largest stresslet" in repr(solution)


def test_bars_of_rotations_and_torques_contain_their_errors():
    scene = {"bodies": [ball(torque=[0, 0, 1])], "gait": {"phases": [{"duration": 2}]}}
    exact = 1 / (8 * np.pi)
    turned = {**scene, "domain": {"kind": "ball", "radius": 3}, "model": {"kind": "fem"}}
    solution = Scene.from_dict(turned).solve()
    # A torque over 8 pi (1 - 1/27) at the centre of a ball.
    error = abs(solution.angular_velocity[0, 2] - exact * (1 - 1 / 27))
    assert 0 < error <= solution.angular_velocity_error < 0.01 * exact
    assert solution.torque[0, 2] == pytest.approx(1)
    # The torque is given, and so has no error.
    assert solution.torque_error < 1e-10
    run = Scene.from_dict({**scene, "model": {"kind": "multipole"}}).run(progress=False)
    assert run.rotation == pytest.approx([0, 0, 2 * exact], abs=run.rotation_error + 1e-12)
    assert run.rotation_error <= 1e-3 * exact


def test_point_forces_have_no_stresslet():
    solution = pair("oseen", 10).solve()
    assert solution.stresslet is None and solution.stresslet_error is None


def test_resistance_and_mobility_of_one_sphere_are_those_of_stokes():
    scene = Scene.from_dict({"fluid": {"viscosity": 2}, "bodies": [ball(radius=3)]})
    resistance = scene.resistance()
    exact = 2 * np.diag([6 * np.pi * 3] * 3 + [8 * np.pi * 27] * 3)
    assert np.asarray(resistance) == pytest.approx(exact, abs=1e-9)
    assert np.asarray(scene.mobility()) == pytest.approx(np.linalg.inv(exact), abs=1e-12)


def test_the_mobility_of_an_oseen_pair_is_the_oseen_tensor():
    mobility = pair("oseen", 10).mobility()
    along, across = 1 / (4 * np.pi * 10), 1 / (8 * np.pi * 10)
    block = mobility.block("a", "b")[:3, :3]
    assert block == pytest.approx(np.diag([along, across, across]), rel=1e-12, abs=1e-15)


def test_error_bars_of_a_resistance_contain_the_exact_one():
    """Two spheres at a distance of 2.5 radii: orders 40 and more change nothing."""
    coarse, fine = (
        pair("multipole", 2.5, tolerance).resistance()
        for tolerance in (1e-2, 1e-10)
    )
    assert coarse.error is not None and coarse.error.max() > 1e-6
    assert np.all(np.abs(coarse.matrix - fine.matrix) <= coarse.error + 1e-8)
    mobility = pair("oseen", 2.5).mobility()
    exact = np.linalg.inv(fine.matrix)
    assert np.all(np.abs(mobility.matrix - exact) <= 2 * mobility.error)


def test_connection_and_metric_agree_with_a_solution():
    """Without inertia the velocities and the power are linear and quadratic in the rates."""
    scene = Scene.from_template("three-sphere")
    solution = scene.solve()
    rates = np.array([-4.0, 0.0])
    connection, metric = scene.connection(), scene.metric()
    assert connection.links == scene.links
    assert connection.origin == "left"
    assert (np.asarray(connection) @ rates)[:3] == pytest.approx(solution.velocity[0], rel=1e-6)
    assert rates @ np.asarray(metric) @ rates == pytest.approx(solution.power, rel=1e-6)
    assert np.asarray(metric) == pytest.approx(np.asarray(metric).T)
    assert np.all(connection.error >= 0) and np.all(metric.error >= 0)
    # Mirror symmetry: the last body by one arm is minus the first by the other.
    first, last = scene.connection([8, 7]).matrix[0], 1 + scene.connection([7, 8]).matrix[0]
    assert last == pytest.approx(-first[::-1], abs=1e-9)


def test_the_connection_integrates_to_the_stroke():
    """The displacement of the frame is the line integral of the connection along the gait."""
    scene = Scene.from_template("three-sphere", {"model.tolerance": 1e-8})
    nodes, weights = np.polynomial.legendre.leggauss(12)
    closing = 8 - 2 * nodes
    sides = [
        (lambda x: [x, 10], 0, -2),
        (lambda x: [6, x], 1, -2),
        (lambda x: [16 - x, 6], 0, 2),
        (lambda x: [10, 16 - x], 1, 2),
    ]
    net = sum(
        rate * weight * scene.connection(shape(x)).matrix[0, arm]
        for shape, arm, rate in sides
        for x, weight in zip(closing, weights)
    )
    assert net == pytest.approx(UNBOUNDED, abs=1e-7)


def test_a_run_has_the_efficiency_of_its_summary(tmp_path):
    run = Scene.from_template("three-sphere").run(tmp_path, progress=False)
    summary = json.loads((tmp_path / "summary.json").read_text())["efficiency"]
    assert (run.efficiency, run.efficiency_error) == (summary["value"], summary["error"])
    assert "Lighthill efficiency" in repr(run)
    # A sphere that is pulled does not swim.
    pulled = Scene.from_dict(
        {"bodies": [ball(force=[1, 0, 0])], "gait": {"phases": [{"duration": 1}]}}
    ).run(progress=False)
    assert pulled.efficiency is None and "efficiency" not in repr(pulled)


def test_a_scene_without_waves_has_no_best_one():
    with pytest.raises(swimmer.SceneError, match="no wave may vary"):
        Scene.from_template("three-sphere").best_wave(progress=False)


def test_results_are_the_same_bits_in_a_second_call():
    scene = Scene.from_template("planar")
    first, second = scene.run(progress=False), scene.run(progress=False)
    assert np.array_equal(first.displacement, second.displacement)
    assert np.array_equal(scene.solve().velocity, scene.solve().velocity)


def test_a_folder_gets_the_files_of_swim_run(tmp_path):
    scene = Scene.from_template("three-sphere")
    run = scene.run(tmp_path, progress=False)
    assert {"summary.json", "trajectory.csv"} <= {path.name for path in tmp_path.iterdir()}
    again = scene.run(tmp_path, resume=True, progress=False)
    assert np.array_equal(run.displacement, again.displacement)
    with pytest.raises(swimmer.SceneError, match="resume needs the folder"):
        scene.run(resume=True)


def test_the_best_stroke_beats_the_gait():
    """Searched in a table; its displacement agrees with a run by the model."""
    scene = Scene.from_template("three-sphere", {"optimise.tolerance": 1e-3})
    texts = []
    best = scene.optimise(progress=lambda done, total, text: texts.append(text))
    assert abs(best.displacement - best.run_displacement) <= (
        best.displacement_error + best.run_errors.total + 1e-3 * best.displacement
    )
    again = Scene.from_toml(best.toml).run(progress=False)
    assert again.net == pytest.approx(best.run_displacement, rel=1e-3)
    assert best.lengths[0] == pytest.approx(best.lengths[-1])
    gait = scene.run(progress=False)
    product = gait.work * gait.times[-1]
    assert best.period_energy_product / best.displacement**2 < product / gait.net**2


def test_rewards_of_the_environment_are_displacements():
    env = swimmer.Swimmer(
        Scene.from_template("three-sphere", {"learn.contracted": 6}), steps=4, progress=False
    )
    assert env.reset(seed=3) == (0, {})
    steps = [env.step(action) for action in (0, 1, 0, 1)]
    assert [step[0] for step in steps] == [1, 3, 2, 0]
    assert abs(sum(step[1] for step in steps) - UNBOUNDED) <= 4 * env.reward_error
    assert [step[2:4] for step in steps] == [(False, False)] * 3 + [(False, True)]
    with pytest.raises(ValueError, match="there are 2 joints"):
        env.step(2)


def test_the_flow_of_a_dragged_sphere_is_that_of_stokes():
    """u = (a / 4r) [(3 + a^2/r^2) U + (3 - 3 a^2/r^2) (U . n) n], at points of a grid."""
    scene = Scene.from_dict({"bodies": [ball(force=[6 * np.pi, 0, 0])]})
    points = np.random.default_rng(1).uniform(-2, 2, (5, 20, 3))
    flow = scene.flow(points)
    r = np.linalg.norm(points, axis=-1, keepdims=True)
    n, u = points / r, np.array([1.0, 0, 0])
    exact = ((3 + r**-2) * u + (3 - 3 * r**-2) * n[..., :1] * n) / (4 * r)
    inside = r[..., 0] < 1
    assert inside.any() and np.array_equal(flow.is_fluid, ~inside)
    assert flow.velocity[~inside] == pytest.approx(exact[~inside], abs=1e-3)


def test_a_flow_by_finite_elements_is_interpolated_at_points():
    """A sphere in a ball of 4 radii: at nodes the interpolated flow is that of the nodes."""
    scene = Scene.from_dict(
        {
            "domain": {"kind": "ball", "radius": 4},
            "bodies": [ball(force=[1, 0, 0])],
            "model": {"kind": "fem"},
            "fem": {"surface_size": 0.7},
        }
    )
    flow = scene.flow()
    nodes = slice(0, None, 7)
    there = scene.flow(flow.mesh.points[nodes])
    assert there.is_fluid.all()
    size = np.abs(flow.velocity).max()
    assert np.abs(there.velocity - flow.velocity[nodes]).max() < 1e-6 * size
    vertices = slice(0, flow.mesh.n_vertices, 5)
    there = scene.flow(flow.mesh.points[vertices])
    assert there.pressure == pytest.approx(flow.pressure[vertices], rel=1e-6, abs=1e-6)
    assert not scene.flow([[0, 0, 0], [5, 0, 0]]).is_fluid.any()
    mesh = scene.mesh()
    assert np.array_equal(mesh.cells, flow.mesh.cells)
    assert {"ball"} < set(mesh.tags) and mesh.facets.max() < len(mesh.points)
    # The volume of the fluid, by the divergence theorem on straight faces.
    a, b, c = (mesh.points[mesh.facets[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
    assert volume == pytest.approx(4 / 3 * np.pi * (4**3 - 1), rel=0.1)


def test_each_swimmer_of_several_has_its_results():
    assert Scene.from_template("three-sphere").run(progress=False).swimmers == ()
    values = {
        "domain.kind": "unbounded",
        "model.kind": "rpy",
        "copies": [{"of": "centre", "positions": [[0, 100, 0]], "orientations": [[0, 0, np.pi]]}],
    }
    run = Scene.from_template("three-sphere").with_values(values).run(progress=False)
    first, second = run.swimmers
    assert (first.name, second.name) == ("left", "left-2")
    # The copy is turned by half a turn about z: the whole is symmetric under this rotation.
    turned = first.displacement * [-1, -1, 1]
    assert np.linalg.norm(second.displacement - turned) < first.error + second.error
    assert first.work + second.work == pytest.approx(run.work, rel=1e-12)
    # Both do the same work.
    assert abs(first.work - second.work) < first.work_errors.total + second.work_errors.total
    assert first.rotation_errors.total > 0
    assert run.mean_flow is None
    assert "swimmer" in repr(first)
