//! Finite elements with symmetry planes: the solution equals that on the whole mesh, also along
//! strokes and after remeshing.

use approx::assert_relative_eq;
use nalgebra::DVector;
use swimmer::choose;
use swimmer::models::{
    BodySolution, Configuration, FemModel, Hydrodynamics, InstantaneousSolution,
};
use swimmer::{Method, Scene, simulate, solve_start, start_resistance};

/// Three spheres on a line, arms unequal, the left one changing.
const COLLINEAR: &str = "
domain = { kind = \"ball\", radius = 20 }
model.kind = \"fem\"
bodies = [
  { name = \"a\", radius = 1, position = [-4, 0, 0] },
  { name = \"b\", radius = 1, position = [0, 0, 0] },
  { name = \"c\", radius = 1, position = [5, 0, 0] },
]
links = [{ name = \"ab\", body = \"a\", to = \"b\" }, { name = \"cb\", body = \"c\", to = \"b\" }]
gait.phases = [
  { link = \"ab\", length = 3, duration = 1 },
  { link = \"cb\", length = 3, duration = 1 },
  { link = \"ab\", length = 4, duration = 1 },
  { link = \"cb\", length = 5, duration = 1 },
]
";

/// Three spheres on arms in the plane z = 0, one of them pulled in it.
const PLANAR: &str = "
domain = { kind = \"ball\", radius = 20 }
model.kind = \"fem\"
bodies = [
  { name = \"j\", shape = \"point\", position = [0, 0, 0] },
  { name = \"a\", radius = 1, position = [3, 1, 0], force = [0, 3, 0], torque = [0, 0, 2] },
  { name = \"b\", radius = 1, position = [-3, 2, 0] },
  { name = \"c\", radius = 1, position = [0, -4, 0] },
]
links = [
  { name = \"ja\", body = \"a\", to = \"j\" },
  { name = \"jb\", body = \"b\", to = \"j\" },
  { name = \"jc\", body = \"c\", to = \"j\" },
]
gait.phases = [{ link = \"jb\", length = 3, duration = 1 }]
";

fn scene(text: &str, settings: &[&str]) -> Scene {
    let text = format!("{}\n{text}", settings.join("\n"));
    Scene::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn solve(scene: &Scene) -> (FemModel, InstantaneousSolution) {
    let mut model = FemModel::new(scene).unwrap();
    let instant = solve_start(scene, &mut model).unwrap();
    (model, instant)
}

fn velocities(instant: &InstantaneousSolution) -> Vec<f64> {
    let all = instant.bodies.iter();
    all.flat_map(|b| {
        b.velocity
            .iter()
            .chain(b.angular_velocity.iter())
            .copied()
            .collect::<Vec<_>>()
    })
    .collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, v| m.max(v.abs()))
}

/// Comparison with the reflected mesh read from a file, which has the same degrees of freedom and
/// their symmetry images.
#[test]
fn the_solution_is_that_on_the_reflected_mesh() {
    for (text, parts) in [(COLLINEAR, 4.0), (PLANAR, 2.0)] {
        let settings = [
            "fem.symmetry = \"auto\"",
            "fem.surface_size = 0.5",
            "fem.rtol = 1e-10",
        ];
        let own = scene(text, &settings);
        let (mut model, part) = solve(&own);
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("whole.msh");
        let mesh = model
            .mesh(Configuration {
                state: &own.initial_state(),
                shape: own.articulation().initial_shape(),
            })
            .unwrap()
            .unwrap();
        mesh.write(&file).unwrap();
        let domain =
            format!("domain = {{ kind = \"mesh\", file = {file:?}, walls = [\"outer\"] }}");
        let mut text = text.replace("domain = { kind = \"ball\", radius = 20 }", &domain);
        for name in ["a", "b", "c"] {
            let body = format!("name = \"{name}\", radius = 1");
            text = text.replace(&body, &format!("{body}, surface = \"{name}\""));
        }
        let (_, whole) = solve(&scene(&text, &settings[2..]));
        let answers = [&part, &whole].map(|i| i.mesh_error.clone().unwrap());
        let (part, whole) = (part.uncorrected(), whole.uncorrected());
        let (u, v) = (velocities(&part), velocities(&whole));
        for (u, v) in u.iter().zip(&v) {
            assert!(
                (u - v).abs() <= 1e-7 * largest(&velocities(&whole)),
                "{u} for {v}"
            );
        }
        for (own, all) in part.bodies.iter().zip(&whole.bodies) {
            let size = whole
                .bodies
                .iter()
                .map(|b| b.force.norm())
                .fold(0.0, f64::max);
            assert!((own.force - all.force).norm() <= 1e-6 * size);
            assert!((own.torque - all.torque).norm() <= 1e-6 * size);
        }
        for (own, all) in part.joint_forces.iter().zip(&whole.joint_forces) {
            let size = whole
                .joint_forces
                .iter()
                .map(|f| f.norm())
                .fold(0.0, f64::max);
            assert!((own - all).norm() <= 1e-6 * size, "{own} for {all}");
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
        assert_relative_eq!(
            own.uncertainty.velocity,
            all.uncertainty.velocity,
            max_relative = 5e-2
        );
        let checks = [&part, &whole].map(|i| i.checks.unwrap());
        assert_relative_eq!(checks[0].dissipation, checks[1].dissipation, epsilon = 1e-7);
        assert_relative_eq!(
            checks[0].force_by_stress,
            checks[1].force_by_stress,
            epsilon = 1e-5
        );
        // Degrees of freedom on the planes have no symmetry images.
        let saved = f64::from(whole.dofs.total as u32) / f64::from(part.dofs.total as u32);
        assert!(saved > 0.7 * parts && saved < parts, "{saved}");
    }
}

/// The meshes with and without planes differ but are equally fine: the solutions agree within their
/// error bars.
#[test]
fn solutions_with_and_without_planes_agree_within_their_error_bars() {
    for text in [COLLINEAR, PLANAR] {
        let [(_, part), (_, whole)] = ["auto", "off"].map(|symmetry| {
            let symmetry = format!("fem.symmetry = \"{symmetry}\"");
            solve(&scene(text, &["fem.surface_size = 0.55", &symmetry]))
        });
        let bar = part.error_estimate.total() + whole.error_estimate.total();
        for (own, all) in part.bodies.iter().zip(&whole.bodies) {
            let apart = (own.velocity - all.velocity).norm();
            assert!(apart <= 1.4 * bar, "{apart:e} with bars of {bar:e}");
        }
    }
}

/// Phase spans with moved and new meshes and their checkpoints: the bodies stay on the planes.
#[test]
fn a_stroke_stays_on_its_symmetry_planes() {
    let settings = [
        "fem.surface_size = 0.6",
        "fem.estimates = \"off\"",
        "fem.symmetry = \"auto\"",
    ];
    let own = scene(COLLINEAR, &settings);
    let mut model = FemModel::new(&own).unwrap();
    let outcome = simulate(&own, &mut model, Method::Collocation, &mut ()).unwrap();
    let history = model.history().unwrap();
    let mut again = FemModel::new(&own).unwrap();
    again.restore(&history).unwrap();
    assert_eq!(again.history().unwrap(), history);
    for sample in &outcome.samples {
        for pose in &sample.poses {
            assert!(pose.translation.vector.yz().norm() < 1e-12);
        }
    }
    let exact = scene(&COLLINEAR.replace("\"fem\"", "\"multipole\""), &[]);
    let mut multipole = choose(&exact).unwrap().model;
    let exact = simulate(&exact, multipole.as_mut(), Method::Collocation, &mut ()).unwrap();
    let [own, exact] = [&outcome, &exact].map(|outcome| outcome.net());
    println!("{own} for {exact}");
    assert!((own - exact).abs() < 0.03 * exact, "{own} for {exact}");
}

/// Two squirmers that turn each other in the plane z = 0 of a ball, where the rotations of their
/// axes are rounded.
#[test]
fn squirmers_turn_in_their_symmetry_plane() {
    let text = "
        domain = { kind = \"ball\", radius = 8 }
        model.kind = \"fem\"
        fem = { surface_size = 0.7, estimates = \"off\" }
        gait.phases = [{ duration = 1 }]
        bodies = [
          { name = \"a\", radius = 1, position = [-2, 0.5, 0], slip = { b1 = 1, b2 = 2, axis = [0.6, 0.8, 0] } },
          { name = \"b\", radius = 0.8, position = [1, -0.7, 0], slip = { b1 = 1.5, b2 = -2, axis = [-1, 0.2, 0] } },
        ]";
    let own = scene(text, &[]);
    assert_eq!(own.fem_symmetry_planes(), [false, false, true]);
    let mut model = FemModel::new(&own).unwrap();
    let outcome = simulate(&own, &mut model, Method::Collocation, &mut ()).unwrap();
    let expansions = scene(&text.replace("\"fem\"", "\"multipole\""), &[]);
    let mut model = choose(&expansions).unwrap().model;
    let exact = simulate(&expansions, model.as_mut(), Method::Collocation, &mut ()).unwrap();
    let ends = [&outcome, &exact].map(|outcome| outcome.samples.last().unwrap().poses.clone());
    for (own, exact) in ends[0].iter().zip(&ends[1]) {
        let moved = (own.translation.vector - exact.translation.vector).norm();
        let turned = own.rotation.angle_to(&exact.rotation);
        // Without estimates the answers are uncorrected.
        assert!(moved < 0.02 && turned < 0.005, "{moved} {turned}");
        assert!(own.translation.vector.z.abs() < 1e-12);
        assert!(exact.rotation.angle() > 0.01, "{}", exact.rotation.angle());
    }
}

#[test]
fn the_flow_and_the_resistance_are_those_of_the_whole_fluid() {
    let scene = scene(
        COLLINEAR,
        &["fem.symmetry = \"auto\"", "fem.surface_size = 0.7"],
    );
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
            assert!(slip.norm() < 1e-12);
        }
    }
    let resistance = start_resistance(&scene, &mut model).unwrap();
    assert_eq!(resistance.shape(), (18, 18));
    let forces: f64 = (0..3)
        .map(|body| {
            let row = resistance.row(6 * body);
            (0..3)
                .map(|other| row[6 * other] * instant.bodies[other].velocity.x)
                .sum::<f64>()
        })
        .sum();
    // The total force on the swimmer is zero, up to the accuracy of the corrections of resistance
    // and velocities: two percent of a correction of three percent.
    assert!(forces.abs() < 1e-3 * resistance[(0, 0)]);
}

/// The pressure preconditioner for narrow gaps, on a part of the fluid and on the whole.
#[test]
fn a_narrow_gap_with_symmetry_planes_has_the_resistance_of_the_whole() {
    let pair = "
        domain = { kind = \"ball\", radius = 10 }
        model.kind = \"fem\"
        fem = { surface_size = 0.7, rtol = 1e-9, estimates = \"off\" }
        bodies = [
          { name = \"a\", radius = 1, position = [-1.1, 0, 0], force = [2, 0, 0] },
          { name = \"b\", radius = 1, position = [1.1, 0, 0], force = [-1, 0, 0] },
        ]";
    let scene = scene(pair, &[]);
    assert_eq!(scene.fem_symmetry_planes(), [false, true, true]);
    let (mut model, instant) = solve(&scene);
    let resistance = start_resistance(&scene, &mut model).unwrap();
    let forces = &resistance * DVector::from_vec(velocities(&instant));
    // Seven solves with true residuals of 1e-9, which forces amplify by about 1e3.
    for (row, force) in [2.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0].into_iter().enumerate() {
        assert!((forces[row] - force).abs() < 1e-6 * 2.0, "{row}: {forces}");
    }
}

#[test]
fn symmetry_planes_are_found_and_used_where_supported() {
    let planes = |text: &str, settings: &[&str]| scene(text, settings).fem_symmetry_planes();
    assert_eq!(planes(COLLINEAR, &[]), [false, true, true]);
    assert_eq!(planes(PLANAR, &[]), [false, false, true]);
    for without in [
        "fem.symmetry = \"off\"",
        "fem.solver = \"direct\"",
        "fem.mesh_motion = \"elastic\"",
        "fem.geometry = \"straight\"",
    ] {
        assert_eq!(planes(COLLINEAR, &[without]), [false; 3], "{without}");
    }
    let across = COLLINEAR.replace(
        "[5, 0, 0] }",
        "[5, 0, 0], slip = { b1 = 1, axis = [0, 0, 1] } }",
    );
    assert_eq!(planes(&across, &[]), [false, true, false]);
    let shear = "background = { kind = \"shear\", gradient = [[0, 1, 0], [0, 0, 0], [0, 0, 0]] }";
    assert_eq!(planes(COLLINEAR, &[shear]), [false, false, true]);
    // A force, a torque and a position that break the symmetry.
    for (from, to, left) in [
        ("torque = [0, 0, 2]", "torque = [0, 1, 0]", [false; 3]),
        ("force = [0, 3, 0]", "force = [0, 3, 1]", [false; 3]),
        (
            "position = [0, -4, 0]",
            "position = [0, -4, 0.5]",
            [false; 3],
        ),
    ] {
        assert_eq!(planes(&PLANAR.replace(from, to), &[]), left);
    }
}
