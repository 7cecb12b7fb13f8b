"""Errors, interruption, display, threads: what is not a number."""

import importlib.util
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import swimmer
from swimmer import Scene

FEM = {"domain.kind": "ball", "domain.radius": 40, "model.kind": "fem"}


def test_a_defect_of_a_scene_is_a_value_error_with_its_place_and_remedy(tmp_path):
    file = tmp_path / "typo.toml"
    file.write_text('bodies = [{ name = "a", radius = 1, position = [0, 0, 0] }]\nfluids = 1\n')
    with pytest.raises(ValueError, match=r"typo\.toml:2: unknown key 'fluids'; .*fluid"):
        Scene.from_file(file)
    bodies = [dict(name=name, radius=1, position=[x, 0, 0]) for name, x in [("a", 0), ("b", 1)]]
    with pytest.raises(swimmer.SceneError, match="bodies 'a' and 'b' touch or overlap"):
        Scene.from_dict({"bodies": bodies})
    with pytest.raises(swimmer.SceneError, match="--set gait.cycle=2"):
        Scene.from_template("three-sphere", {"gait.cycle": 2})
    with pytest.raises(swimmer.SceneError, match="choose one of three-sphere, "):
        Scene.from_template("three-spheres")
    with pytest.raises(FileNotFoundError, match=r"cannot read .*missing\.toml"):
        Scene.from_file(tmp_path / "missing.toml")
    for bad in (float("nan"), None, object()):
        with pytest.raises((ValueError, TypeError)):
            Scene.from_dict({"fluid": {"viscosity": bad}})
    with pytest.raises(TypeError, match="Scene.from_file"):
        Scene("three-sphere")


def test_keys_with_dots_in_a_dictionary_are_read_and_not_ignored():
    body = dict(name="a", radius=1, position=[0, 0, 0], force=[6 * np.pi, 0, 0])
    speed = lambda keys: Scene.from_dict({"bodies": [body]} | keys).solve().velocity[0, 0]
    assert speed({"fluid": {"viscosity": 100}}) == pytest.approx(0.01)
    assert speed({"fluid.viscosity": 100}) == pytest.approx(0.01)
    assert speed({"fluid.viscosity": 100, "bodies.a.density": 2}) == pytest.approx(0.01)
    with pytest.raises(swimmer.SceneError, match="fluid.viscosity is given twice"):
        speed({"fluid": {"viscosity": 1}, "fluid.viscosity": 100})
    with pytest.raises(swimmer.SceneError, match="did you mean 'fluid.viscosity'"):
        speed({"fluid.viscositi": 100})
    with pytest.raises(swimmer.SceneError, match="quotation marks"):
        Scene.from_toml('"fluid.viscosity" = 100\nbodies = []')


def test_calls_that_do_not_fit_the_scene_say_what_does():
    scene = Scene.from_template("three-sphere")
    with pytest.raises(swimmer.SceneError, match="has no mesh; use model.kind"):
        scene.mesh()
    with pytest.raises(swimmer.SceneError, match="the shape has 1 values, and 2 links"):
        scene.connection([10])
    for bad in ([10, np.nan], [10, -1], [np.inf, 10]):
        with pytest.raises(swimmer.SceneError, match="no angle, amplitude or positive length"):
            scene.connection(bad)
    with pytest.raises(ValueError, match="could not convert"):
        scene.connection("ten")
    with pytest.raises(swimmer.SceneError, match="depends only on the shape"):
        Scene.from_template("settling").connection()
    with pytest.raises(swimmer.SceneError, match="gait"):
        Scene.from_dict({"bodies": [dict(name="a", radius=1, position=[0, 0, 0])]}).run()
    for points in (1.0, [[1, 2]], [1, 2, 3, 4]):
        with pytest.raises(swimmer.SceneError, match="length three"):
            scene.flow(points)


def test_bodies_that_collide_in_a_connection_are_an_error():
    with pytest.raises((swimmer.SolveError, swimmer.SceneError)):
        Scene.from_template("three-sphere").connection([1, 1])


def test_a_missed_tolerance_carries_the_result():
    """The models of quick scenes all meet their tolerance, so the exception is made here."""
    scene = Scene.from_template("three-sphere")
    raw = scene._scene.run(None, False, None) | {"tolerance_met": False}

    class Missed:
        name = "missed"

        def run(self, out, resume, report):
            error = swimmer.ToleranceMissed("increase model.tolerance")
            error.result = raw
            raise error

    object.__setattr__(scene, "_scene", Missed())
    with pytest.raises(swimmer.SolveError, match="increase model.tolerance") as caught:
        scene.run(progress=False)
    assert isinstance(caught.value, swimmer.ToleranceMissed)
    assert caught.value.run.net == raw["net"] and not caught.value.run.tolerance_met


def test_a_run_that_stops_at_contact_has_its_result():
    pulled = {
        "model": {"kind": "rpy"},
        "bodies": [
            {"name": "a", "radius": 0.1, "position": [0, 0, 0], "force": [1, 0, 0]},
            {"name": "b", "radius": 0.1, "position": [1, 0, 0], "fixed": True},
        ],
        "gait": {"phases": [{"duration": 4}]},
    }
    with pytest.raises(swimmer.RunStopped, match="'b' touch") as caught:
        Scene.from_dict(pulled).run(progress=False)
    assert caught.value.run.displacement[0, 0] == pytest.approx(0.8, abs=1e-3)


def test_a_panic_is_an_internal_error():
    with pytest.raises(swimmer.InternalError, match="a defect of the program: index out of"):
        swimmer._swimmer.panic_for_test("index out of bounds")


def test_results_cannot_be_changed():
    solution = Scene.from_template("three-sphere").solve()
    with pytest.raises(ValueError, match="read-only"):
        solution.velocity[0, 0] = 1.0
    with pytest.raises(AttributeError):
        solution.power = 1.0


def test_results_show_error_bars_and_escape_names():
    scene = Scene.from_template("three-sphere")
    run = scene.run(progress=False)
    assert "net displacement" in repr(run) and "+-" in repr(run) and "%)" in repr(run)
    assert run._repr_html_().startswith("<table><caption>Run</caption>")
    body = dict(name="<b>", radius=1, position=[0, 0, 0])
    html = Scene.from_dict({"bodies": [body]}).resistance()._repr_html_()
    assert "&lt;b&gt;" in html and "<b>" not in html
    for result in (scene, scene.solve(), scene.mobility(), scene.connection(), scene.metric()):
        assert repr(result).startswith(type(result).__name__)


def test_numpy_takes_matrices():
    resistance = Scene.from_template("three-sphere").resistance()
    assert np.linalg.eigvalsh(resistance).min() > 0
    assert np.asarray(resistance, dtype=np.float32).dtype == np.float32


def test_progress_is_reported_and_its_exceptions_end_the_run():
    scene = Scene.from_template("three-sphere", FEM)

    class Enough(Exception):
        pass

    seen = []

    def report(done, total, text):
        seen.append((done, total, text))
        raise Enough

    begin = time.monotonic()
    with pytest.raises(Enough):
        scene.run(progress=report)
    assert len(seen) == 1 and time.monotonic() - begin < 5


@pytest.mark.skipif(sys.platform == "win32", reason="sends a signal")
def test_ctrl_c_ends_a_long_call_within_a_second():
    """A run by finite elements of many cycles, which takes minutes."""
    scene = Scene.from_template("three-sphere", FEM | {"gait.cycles": 100})
    sent = []

    def interrupt():
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.5, interrupt)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        scene.run(progress=False)
    assert time.monotonic() - sent[0] < 1.0
    # Nothing is broken.
    assert Scene.from_template("three-sphere").solve().dofs > 0


def test_other_threads_run_during_a_call():
    ticks = []
    stop = threading.Event()

    def tick():
        while not stop.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.monotonic()
    Scene.from_template("chain", {"model.tolerance": 1e-8}).run(progress=False)
    end = time.monotonic()
    stop.set()
    thread.join()
    assert sum(begin < t < end for t in ticks) >= 2


def test_threads_share_a_scene():
    scene = Scene.from_template("three-sphere")
    expected = scene.connection([9, 8]).matrix
    found = []

    def compute():
        found.extend(scene.connection([9, 8]).matrix for _ in range(20))

    threads = [threading.Thread(target=compute) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 80
    assert all(np.array_equal(matrix, expected) for matrix in found)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="forks")
def test_a_forked_process_refuses_instead_of_waiting_for_ever():
    Scene.from_template("three-sphere").solve()
    code = (
        "import os, sys, swimmer\n"
        "scene = swimmer.Scene.from_template('three-sphere')\n"
        "scene.solve()\n"
        "child = os.fork()\n"
        "if child == 0:\n"
        "    try:\n"
        "        scene.solve()\n"
        "    except swimmer.SceneError as error:\n"
        "        os._exit(7 if 'spawn' in str(error) else 1)\n"
        "    os._exit(1)\n"
        "sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))\n"
    )
    result = subprocess.run([sys.executable, "-W", "ignore", "-c", code], timeout=60)
    assert result.returncode == 7


def net_of(cycles):
    return Scene.from_template("three-sphere", {"gait.cycles": cycles}).run(progress=False).net


def test_spawned_processes_compute():
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert pool.apply(net_of, (1,)) == net_of(1)


def test_missing_packages_are_named(monkeypatch):
    mesh = swimmer.Mesh(*[None] * 11)
    for package, convert in [("meshio", mesh.to_meshio), ("pyvista", mesh.to_pyvista)]:
        monkeypatch.setitem(sys.modules, package, None)
        with pytest.raises(ImportError, match=f"pip install {package}"):
            convert()


@pytest.mark.skipif(importlib.util.find_spec("gymnasium") is None, reason="needs gymnasium")
def test_the_environment_passes_the_checks_of_gymnasium():
    from gymnasium.utils.env_checker import check_env

    scene = Scene.from_template("three-sphere", {"learn.contracted": 6})
    check_env(swimmer.Swimmer(scene, progress=False), skip_render_check=True)


DRAGGED = {
    "bodies": [dict(name="a", radius=1, position=[0, 0, 0], force=[6 * np.pi, 0, 0])],
    "gait": {"phases": [{"duration": 1}]},
}


def test_a_sweep_has_a_row_for_each_point_and_reasons_for_failures(tmp_path):
    scene = Scene.from_dict(DRAGGED)
    vary = {"fluid.viscosity": [1, 2, -1], "bodies.a.radius": "0.5:1:2"}
    found = scene.sweep(vary, jobs=2, out=tmp_path, progress=False)
    assert found.keys == ("fluid.viscosity", "bodies.a.radius")
    assert found.values[1] == (1.0, 1.0)
    assert found.status[:4] == ("met",) * 4
    assert all("fluid.viscosity" in status for status in found.status[4:])
    np.testing.assert_allclose(found.displacement[:4, 0], [2, 1, 1, 0.5], rtol=1e-9)
    assert np.isnan(found.displacement[4:]).all()
    again = scene.sweep(vary, out=tmp_path, resume=True, progress=False)
    assert again.seconds.tolist()[:4] == found.seconds.tolist()[:4]
    points = scene.sweep({"bodies.a.radius": "1:2"}, random=3, seed=5, progress=False)
    assert all(1 <= radius <= 2 for (radius,) in points.values)
    with pytest.raises(swimmer.SceneError, match="has no count"):
        scene.sweep({"bodies.a.radius": "1:2"}, progress=False)


def test_a_sweep_varies_the_length_of_a_link_and_other_calls_name_the_keys_that_exist():
    scene = Scene.from_template("three-sphere").with_values({"model.kind": "rpy"})
    found = scene.sweep({"links.left-arm.length": [6, 10]}, progress=False)
    assert found.status[0].startswith("failed: links.left-arm.length=6: bodies 'left'")
    alone = scene.run(progress=False)
    np.testing.assert_allclose(found.displacement[1], np.mean(alone.displacement, axis=0), atol=1e-9)
    with pytest.raises(swimmer.SceneError, match="gait.phases.0.length, gait.phases.2.length"):
        scene.with_values({"links.left-arm.length": 8})


def test_bug_lists_without_rows_had_no_columns():
    path = Scene.from_template("three-sphere").run(progress=False).at([])
    assert path.lengths.shape == path.rates.shape == (0, 2)
    assert path.positions.shape == (0, 3, 3)


def test_trajectories_have_velocities_and_forces_and_become_frames():
    run = Scene.from_dict(DRAGGED).run(progress=False)
    assert run.solved.any() and not run.solved[[0, -1]].any()
    np.testing.assert_allclose(run.forces[:, 0, 0], 6 * np.pi, rtol=1e-9)
    np.testing.assert_allclose(run.velocities[:, 0, 0], 1, rtol=1e-9)
    uniform = Scene.from_dict(DRAGGED | {"output.samples": 4}).run(progress=False)
    np.testing.assert_allclose(uniform.times, [0, 0.25, 0.5, 0.75, 1], rtol=1e-12)
    np.testing.assert_allclose(uniform.positions[:, 0, 0], uniform.times, rtol=1e-9)
    assert not uniform.solved.any() and np.isfinite(uniform.torques).all()
    if importlib.util.find_spec("pandas") is None:
        with pytest.raises(ImportError, match="pip install pandas"):
            run.to_dataframe()
        return
    frame = run.to_dataframe()
    assert len(frame) == len(run.times)
    assert {"time", "solved", "a.x", "a.qw", "a.vx", "a.wz", "a.fx", "a.tz"} <= set(frame.columns)


def test_a_scene_is_pickled_as_its_text():
    import pickle

    scene = Scene.from_template("three-sphere", {"bodies.left.radius": 0.5})
    again = pickle.loads(pickle.dumps(scene))
    assert again.to_toml() == scene.to_toml()
    assert again.name == scene.name


def test_sensitivities_of_a_dragged_sphere_are_those_of_stokes():
    [found] = [
        entry
        for entry in Scene.from_dict(DRAGGED).sensitivities(progress=False)
        if "radius" in entry.name
    ]
    assert found.derivative == pytest.approx(-1, abs=max(found.error, 1e-9))


def test_a_run_has_positions_solutions_and_flow_at_any_time():
    run = Scene.from_template("three-sphere").run(progress=False)
    path = run.at(run.times)
    np.testing.assert_allclose(path.positions, run.positions, atol=1e-12)
    np.testing.assert_allclose(path.lengths, run.lengths, atol=1e-12)
    # The left arm closes from ten to six in a unit of time.
    assert path.rates[0].tolist() == [-4.0, 0.0]
    time = 0.4
    solution = run.solve(time)
    assert solution.velocity[1, 0] - solution.velocity[0, 0] == pytest.approx(-4, rel=1e-9)
    assert abs(solution.force.sum()) < 1e-9 * abs(solution.force).max()
    step = 1e-4
    moved = np.diff(run.at([time - step, time + step]).positions, axis=0)[0] / (2 * step)
    # The path is integrated to a thousandth.
    np.testing.assert_allclose(solution.velocity, moved, atol=1e-2 * abs(moved).max())
    above = run.at(time).positions[0] + [0, 0, 1]
    flow = run.flow(time, above)
    np.testing.assert_allclose(flow.velocity, solution.velocity, atol=1e-2)
    far = run.flow(time, np.full((2, 3, 3), 1e3))
    assert far.velocity.shape == (2, 3, 3) and abs(far.velocity).max() < 1e-3
    assert repr(path).startswith("Trajectory")


def test_times_outside_a_run_and_flows_that_have_a_memory_are_refused():
    run = Scene.from_template("three-sphere").run(progress=False)
    for time in (-0.1, 4.1, float("nan")):
        with pytest.raises(swimmer.SceneError, match="known from 0 to 4"):
            run.solve(time)
        with pytest.raises(swimmer.SceneError, match="known from 0 to 4"):
            run.at([1, time])
    with pytest.raises(ValueError, match="times are a number or a list"):
        run.at([[1, 2]])
    noisy = Scene.from_template("brownian-swimmer").run(progress=False)
    assert np.isfinite(noisy.at(noisy.times[:2]).positions).all()
    with pytest.raises(swimmer.SceneError, match="thermal noise"):
        noisy.solve(noisy.times[1])


def test_runs_are_pickled_with_their_motion():
    import pickle

    run = Scene.from_template("three-sphere").run(progress=False)
    again = pickle.loads(pickle.dumps(run))
    assert again.net == run.net
    for time in (0.3, 2.0, 3.9):
        assert np.array_equal(again.at(time).positions, run.at(time).positions)
    assert np.array_equal(again.solve(0.3).force, run.solve(0.3).force)


def test_a_map_has_the_connection_and_its_curvature_over_shapes(tmp_path):
    scene = Scene.from_template("three-sphere")
    found = scene.map(tmp_path, progress=False)
    assert (tmp_path / "table.json").exists()
    assert found.links == scene.links and found.ranges.tolist() == [[6, 10], [6, 10]]
    shapes = found.grid(5)
    assert shapes.shape == (5, 5, 2) and found.metric(shapes).shape == (5, 5, 2, 2)
    exact = scene.connection(shapes[1, 3])
    bar = found.interpolation_error + found.model_error + exact.error.max()
    assert abs(found.connection(shapes[1, 3]) - exact.matrix).max() <= bar
    # The displacement of the gait, around the square of shapes, is the integral of the curvature
    # (Gauss quadrature; on one axis frames do not turn).
    nodes, weights = np.polynomial.legendre.leggauss(12)
    first, second = np.meshgrid(8 + 2 * nodes, 8 + 2 * nodes, indexing="ij")
    heights = found.curvature(np.stack([first, second], axis=-1))[..., 0]
    area = 4 * (heights * weights[:, None] * weights).sum()
    run = scene.run(progress=False)
    assert abs(abs(area) - run.net) <= run.net_error + 64 * bar
    assert abs(np.linalg.norm(found.gait_displacement) - run.net) <= run.net_error + 16 * bar
    assert found.stroke.shape[1] == 2 and "table" in repr(found)
    with pytest.raises((swimmer.SceneError, swimmer.SolveError), match="outside"):
        found.connection([5, 8])
    with pytest.raises(ValueError, match="one value for each of left-arm, right-arm"):
        found.curvature([6, 7, 8])
    with pytest.raises(IndexError, match="there are 2"):
        found.curvature(first=0, second=2)


def test_learning_finds_the_cycle_of_najafi_and_golestanian():
    scene = Scene.from_template("three-sphere", {"learn.contracted": 6})
    found = scene.learn(progress=False)
    assert found.is_optimal and found.policy == found.best_policy and len(found.policy) == 4
    assert abs(found.per_cycle - 0.1598053404) <= 4 * found.reward_error
    assert found.values.shape == (4, 2) and len(found.curve) > 10
    assert set(found.actions) == set(scene.links) and "best possible" in repr(found)


def test_a_steady_state_has_a_reynolds_number():
    ball = dict(name="a", radius=1, position=[0, 0, 0], force=[20, 0, 0])
    keys = {"bodies": [ball], "domain": {"kind": "ball", "radius": 5}, "fluid.density": 0.1}
    scene = Scene.from_dict(keys)
    steady, creeping = scene.solve(steady=True), scene.solve()
    assert 0 < steady.reynolds < 1 and creeping.reynolds is None
    speeds = [solution.velocity[0, 0] for solution in (steady, creeping)]
    assert speeds[0] == pytest.approx(speeds[1], rel=0.05)
