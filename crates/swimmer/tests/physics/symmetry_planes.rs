//! Finite elements with symmetry planes: the solution equals that on the whole mesh, also along
//! strokes and after remeshing.

use nalgebra::DVector;
use swimmer::models::{
    BodySolution, Configuration, FemModel, Hydrodynamics, InstantaneousSolution,
};
use swimmer::{Method, Scene, start_resistance};
use testkit::{SceneText, chain, run, run_by, start_by, within};

/// Three spheres on a line, arms unequal, both changing.
fn collinear() -> SceneText {
    chain(&["a", "b", "c"], &[-4.0, 0.0, 5.0])
        .slide("ab", "a", "b")
        .slide("cb", "c", "b")
        .phases(&[("ab", 3.0), ("cb", 3.0), ("ab", 4.0), ("cb", 5.0)])
        .ball(20.0)
        .with("model.kind", "fem")
}

/// Three spheres on arms in the plane z = 0, one of them pulled in it.
fn planar() -> SceneText {
    SceneText::new()
        .point("j", [0; 3])
        .shape(
            "a",
            "radius = 1, force = [0, 3, 0], torque = [0, 0, 2]",
            [3, 1, 0],
        )
        .sphere("b", 1.0, [-3, 2, 0])
        .sphere("c", 1.0, [0, -4, 0])
        .slide("ja", "a", "j")
        .slide("jb", "b", "j")
        .slide("jc", "c", "j")
        .phases(&[("jb", 3.0)])
        .ball(20.0)
        .with("model.kind", "fem")
}

fn solve(scene: &Scene) -> (FemModel, InstantaneousSolution) {
    let mut model = FemModel::new(scene).unwrap();
    let instant = start_by(&mut model);
    (model, instant)
}

fn velocities(instant: &InstantaneousSolution) -> Vec<f64> {
    let vectors = instant
        .bodies
        .iter()
        .flat_map(|b| [b.velocity, b.angular_velocity]);
    vectors.flat_map(|v| [v.x, v.y, v.z]).collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, v| m.max(v.abs()))
}

/// Comparison with the reflected mesh read from a file, which has the same degrees of freedom and
/// their symmetry images.
#[test]
fn the_solution_is_that_on_the_reflected_mesh() {
    for (text, parts) in [(collinear(), 4.0), (planar(), 2.0)] {
        let text = text.with("fem.rtol", "1e-10");
        let own = text
            .clone()
            .set(&["fem.symmetry=auto", "fem.surface_size=0.5"])
            .scene();
        let (mut model, part) = solve(&own);
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("whole.msh");
        let (state, shape) = (&own.initial_state(), own.articulation().initial_shape());
        let mesh = model
            .mesh(Configuration::new(state, shape))
            .unwrap()
            .unwrap();
        mesh.write(&file).unwrap();
        let domain = format!("{{ kind = \"mesh\", file = {file:?}, walls = [\"outer\"] }}");
        let in_file = ["a", "b", "c"]
            .iter()
            .fold(text.with("domain", domain), |text, name| {
                text.with(&format!("bodies.{name}.surface"), name)
            });
        let (_, whole) = solve(&in_file.scene());
        let answers = [&part, &whole].map(|i| i.mesh_error.clone().unwrap());
        let (part, whole) = (part.uncorrected(), whole.uncorrected());
        let (u, v) = (velocities(&part), velocities(&whole));
        for (u, v) in u.iter().zip(&v) {
            within(
                u - v,
                1e-7 * largest(&velocities(&whole)),
                "residuals of 1e-10",
            );
        }
        let why = "residuals of 1e-10, which forces amplify by about 1e3";
        let size = whole
            .bodies
            .iter()
            .map(|b| b.force.norm())
            .fold(0.0, f64::max);
        for (own, all) in part.bodies.iter().zip(&whole.bodies) {
            within((own.force - all.force).norm(), 1e-6 * size, why);
            within((own.torque - all.torque).norm(), 1e-6 * size, why);
        }
        let size = whole
            .joint_loads
            .iter()
            .map(|load| load.force.norm())
            .fold(0.0, f64::max);
        for (own, all) in part.joint_loads.iter().zip(&whole.joint_loads) {
            within((own.force - all.force).norm(), 1e-6 * size, why);
            within((own.torque - all.torque).norm(), 1e-6 * size, why);
            within(own.drive - all.drive, 1e-6 * size, why);
        }
        // So are the corrections, up to the two percent that their iteration leaves; the file does
        // not tell that its wall is a ball, so that facets there are not corrected.
        let [own, all] = answers;
        let [of_velocity, of_force] = [|b: &BodySolution| b.velocity, |b: &BodySolution| b.force]
            .map(|of| {
                let difference = |(own, all)| (of(own) - of(all)).norm();
                let pairs = own.bodies.iter().zip(&all.bodies);
                let size = all.bodies.iter().fold(0.0_f64, |m, b| m.max(of(b).norm()));
                pairs.map(difference).fold(0.0, f64::max) / size.max(f64::MIN_POSITIVE)
            });
        assert!(
            of_velocity < 0.05 && of_force < 0.05,
            "{of_velocity} {of_force}"
        );
        let [a, b] = [&own, &all].map(|error| error.uncertainty.velocity);
        within(
            a - b,
            5e-2 * a.abs().max(b.abs()),
            "the iteration of the corrections",
        );
        let [a, b] = [&part, &whole].map(|i| i.checks.unwrap());
        within(a.dissipation - b.dissipation, 1e-7, "residuals of 1e-10");
        within(
            a.force_by_stress - b.force_by_stress,
            1e-5,
            "the same for forces",
        );
        // Degrees of freedom on the planes have no symmetry images.
        let saved = whole.dofs.total as f64 / part.dofs.total as f64;
        assert!(saved > 0.7 * parts && saved < parts, "{saved}");
    }
}

/// The meshes with and without planes differ but are equally fine: the solutions agree within their
/// error bars.
#[test]
fn solutions_with_and_without_planes_agree_within_their_error_bars() {
    for text in [collinear(), planar()] {
        let [(_, part), (_, whole)] = ["auto", "off"].map(|symmetry| {
            solve(
                &text
                    .clone()
                    .elements(0.55)
                    .with("fem.symmetry", symmetry)
                    .scene(),
            )
        });
        let bar = part.error_estimate.total() + whole.error_estimate.total();
        for (own, all) in part.bodies.iter().zip(&whole.bodies) {
            let apart = (own.velocity - all.velocity).norm();
            within(
                apart,
                1.4 * bar,
                "bars of single solutions are 0.7 to 1.4 of the errors",
            );
        }
    }
}

/// Phase spans with moved and new meshes and their checkpoints: the bodies stay on the planes.
#[test]
fn a_stroke_stays_on_its_symmetry_planes() {
    let text = collinear();
    let settings = [
        "fem.surface_size=0.6",
        "fem.estimates=off",
        "fem.symmetry=auto",
    ];
    let own = text.clone().set(&settings).scene();
    let mut model = FemModel::new(&own).unwrap();
    let outcome = run_by(&mut model, Method::Collocation);
    let history = model.history().unwrap();
    let mut again = FemModel::new(&own).unwrap();
    again.restore(&history).unwrap();
    assert_eq!(again.history().unwrap(), history);
    for sample in &outcome.samples {
        for pose in &sample.poses {
            within(pose.translation.vector.yz().norm(), 1e-12, "rounding");
        }
    }
    let exact = run(&text.with("model.kind", "multipole").scene()).net();
    within(
        outcome.net() - exact,
        0.03 * exact,
        "without estimates the answers are uncorrected",
    );
}

/// Two squirmers that turn each other in the plane z = 0 of a ball, where the rotations of their
/// axes are rounded.
#[test]
#[ignore = "slow: 4 s"]
fn squirmers_turn_in_their_symmetry_plane() {
    let text = SceneText::new()
        .shape(
            "a",
            "radius = 1, slip = { b1 = 1, b2 = 2, axis = [0.6, 0.8, 0] }",
            [-2.0, 0.5, 0.0],
        )
        .shape(
            "b",
            "radius = 0.8, slip = { b1 = 1.5, b2 = -2, axis = [-1, 0.2, 0] }",
            [1.0, -0.7, 0.0],
        )
        .phase("duration = 1")
        .ball(8.0)
        .elements(0.7)
        .with("fem.estimates", "off");
    let own = text.scene();
    assert_eq!(own.fem_symmetry_planes(), [false, false, true]);
    let outcome = run_by(&mut FemModel::new(&own).unwrap(), Method::Collocation);
    let exact = run(&text.with("model.kind", "multipole").scene());
    let ends = [&outcome, &exact].map(|outcome| outcome.samples.last().unwrap().poses.clone());
    for (own, exact) in ends[0].iter().zip(&ends[1]) {
        let moved = (own.translation.vector - exact.translation.vector).norm();
        let turned = own.rotation.angle_to(&exact.rotation);
        within(moved, 0.02, "without estimates the answers are uncorrected");
        within(turned, 0.005, "the same for rotations");
        within(own.translation.vector.z, 1e-12, "rounding");
        assert!(exact.rotation.angle() > 0.01, "{}", exact.rotation.angle());
    }
}

#[test]
#[ignore = "slow: 5 s"]
fn the_flow_and_the_resistance_are_those_of_the_whole_fluid() {
    let scene = collinear()
        .elements(0.7)
        .with("fem.symmetry", "auto")
        .scene();
    let (mut model, instant) = solve(&scene);
    let flow = instant.flow.as_ref().unwrap().field().unwrap();
    assert_eq!(flow.velocity.len(), flow.mesh.n_points());
    assert_eq!(flow.pressure.len(), flow.mesh.n_vertices());
    assert_eq!(flow.mesh.symmetry_planes(), [false; 3]);
    assert!(flow.mesh.bounding_box()[0].z < -19.0);
    // No slip on each body.
    for (tag, body) in [("a", 0), ("b", 1), ("c", 2)] {
        for node in flow.mesh.nodes_on(flow.mesh.tag(tag).unwrap()) {
            let slip = flow.velocity[node as usize] - instant.bodies[body].velocity;
            within(slip.norm(), 1e-12, "no slip to rounding");
        }
    }
    let resistance = start_resistance(&scene, &mut model).unwrap();
    assert_eq!(resistance.shape(), (18, 18));
    let forces = (0..3).flat_map(|body| (0..3).map(move |other| (body, other)));
    let forces = forces
        .map(|(body, other)| resistance[(6 * body, 6 * other)] * instant.bodies[other].velocity.x);
    // The total force on the swimmer is zero.
    let why = "corrections of three percent are accurate to two percent of them";
    within(forces.sum::<f64>(), 1e-3 * resistance[(0, 0)], why);
}

/// The pressure preconditioner for narrow gaps, on a part of the fluid and on the whole.
#[test]
fn a_narrow_gap_with_symmetry_planes_has_the_resistance_of_the_whole() {
    let text = chain(&["a", "b"], &[-1.1, 1.1]).ball(10.0).elements(0.7);
    let forces = ["bodies.a.force=[2, 0, 0]", "bodies.b.force=[-1, 0, 0]"];
    let scene = text
        .set(&["fem.rtol=1e-9", "fem.estimates=off"])
        .set(&forces)
        .scene();
    assert_eq!(scene.fem_symmetry_planes(), [false, true, true]);
    let (mut model, instant) = solve(&scene);
    let resistance = start_resistance(&scene, &mut model).unwrap();
    let forces = &resistance * DVector::from_vec(velocities(&instant));
    for (row, force) in [2.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0].into_iter().enumerate() {
        let why = format!("seven residuals of 1e-9, which forces amplify by about 1e3: row {row}");
        within(forces[row] - force, 1e-6 * 2.0, why);
    }
}

#[test]
fn symmetry_planes_are_found_and_used_where_supported() {
    let planes =
        |text: SceneText, setting: &str| text.set(&[setting]).scene().fem_symmetry_planes();
    let none = [false; 3];
    let normal_to_gradient =
        "background={ kind = \"shear\", gradient = [[0, 1, 0], [0, 0, 0], [0, 0, 0]] }";
    for (setting, left) in [
        ("gait.cycles=1", [false, true, true]),
        ("fem.symmetry=off", none),
        ("fem.solver=direct", none),
        ("fem.mesh_motion=elastic", none),
        ("fem.geometry=straight", none),
        (
            "bodies.c.slip={ b1 = 1, axis = [0, 0, 1] }",
            [false, true, false],
        ),
        (normal_to_gradient, [false, false, true]),
    ] {
        assert_eq!(planes(collinear(), setting), left, "{setting}");
    }
    // A force, a torque and a position that break the symmetry.
    for (setting, left) in [
        ("gait.cycles=1", [false, false, true]),
        ("bodies.a.torque=[0, 1, 0]", none),
        ("bodies.a.force=[0, 3, 1]", none),
        ("bodies.c.position=[0, -4, 0.5]", none),
    ] {
        assert_eq!(planes(planar(), setting), left, "{setting}");
    }
}
