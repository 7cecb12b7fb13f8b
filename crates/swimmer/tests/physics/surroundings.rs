//! Swimmers near obstacles, walls and other swimmers.

use std::f64::consts::PI;

use nalgebra::Vector3;
use swimmer::choose;
use swimmer::models::InstantaneousSolution;
use swimmer::{Method, Outcome, Scene, simulate, solve_start};

fn start(text: &str) -> InstantaneousSolution {
    let scene = Scene::parse(text).unwrap();
    let mut model = choose(&scene).unwrap().model;
    solve_start(&scene, model.as_mut()).unwrap()
}

fn run(text: &str) -> Outcome {
    let scene = Scene::parse(text).unwrap();
    let mut model = choose(&scene).unwrap().model;
    simulate(&scene, model.as_mut(), Method::Collocation, &mut ()).unwrap()
}

/// A sphere pulled by a force beside a fixed one, centres three radii apart along x.
fn beside_an_obstacle(domain: &str, model: &str, force: &str) -> String {
    format!(
        "domain = {domain}\nmodel = {{ kind = \"{model}\", tolerance = 1e-6 }}\n\
         [[bodies]]\nname = \"pulled\"\nradius = 1\nposition = [-1.5, 0, 0]\nforce = {force}\n\
         [[bodies]]\nname = \"obstacle\"\nradius = 1\nposition = [1.5, 0, 0]\nfixed = true\n"
    )
}

#[test]
fn an_obstacle_slows_a_sphere_by_the_exact_amount() {
    // Two equal spheres at a distance of three radii, bispherical series: XA11, XA12, YA11 over 6
    // pi, YC11 over 8 pi, and the coupling.
    let (xa11, xa12) = (1.3684796020864693, -0.6701750418364307);
    let (ya11, yc11, coupling) = (1.0921017532628983, 1.0179857150673868, 0.713097351810985);
    let unbounded = "{ kind = \"unbounded\" }";
    let along = start(&beside_an_obstacle(unbounded, "multipole", "[1, 0, 0]"));
    let exact = 1.0 / (6.0 * PI * xa11);
    assert!((along.bodies[0].velocity.x / exact - 1.0).abs() < 1e-8);
    assert_eq!(along.bodies[1].velocity, Vector3::zeros());
    assert_eq!(along.bodies[1].angular_velocity, Vector3::zeros());
    // Force of the obstacle on the fluid.
    assert!((along.bodies[1].force.x - xa12 / xa11).abs() < 1e-8);
    let across = start(&beside_an_obstacle(unbounded, "multipole", "[0, 0, 1]"));
    let exact = 1.0 / (6.0 * PI * ya11 - coupling * coupling / (8.0 * PI * yc11));
    assert!((across.bodies[0].velocity.z / exact - 1.0).abs() < 1e-8);
}

#[test]
fn obstacles_by_finite_elements_agree_with_multipoles() {
    let ball = "{ kind = \"ball\", radius = 6 }";
    let exact = start(&beside_an_obstacle(ball, "multipole", "[1, 0, 1]"));
    for formulation in ["p-tilde", "lagrange", "direct-row"] {
        let scene = beside_an_obstacle(ball, "fem", "[1, 0, 1]")
            + &format!("[fem]\nformulation = \"{formulation}\"\nsurface_size = 0.5\n");
        let found = start(&scene);
        let off = (found.bodies[0].velocity - exact.bodies[0].velocity).norm();
        let speed = exact.bodies[0].velocity.norm();
        // Elements of half a radius have an error of 4e-3 in the drag of one sphere.
        assert!(off < 1e-2 * speed, "{formulation}: {off:e}");
        assert!(
            // On a mesh as coarse as this, the estimate is accurate to a factor of two.
            off < 2.0 * found.error_estimate.total(),
            "{formulation}: {off:e} {:?}",
            found.error_estimate
        );
        assert!(found.bodies[1].velocity.norm() < 1e-7 * speed);
        let off = (found.bodies[1].force - exact.bodies[1].force).norm();
        assert!(off < 1e-2, "{formulation}: {off:e}");
    }
}

#[test]
fn invalid_obstacles_are_refused() {
    let good = beside_an_obstacle("{ kind = \"unbounded\" }", "multipole", "[1, 0, 0]");
    for (from, to, message) in [
        ("fixed = true", "fixed = 1", "must be true or false"),
        (
            "fixed = true",
            "fixed = true\nforce = [0, 1, 0]",
            "holds the body against any load",
        ),
        (
            "fixed = true",
            "fixed = true\n[[links]]\nname = \"arm\"\nbody = \"pulled\"\nto = \"obstacle\"",
            "an obstacle has no links",
        ),
        (
            "force = [1, 0, 0]",
            "fixed = true",
            "are all fixed, so nothing moves",
        ),
    ] {
        let error = Scene::parse(&good.replace(from, to)).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
        assert!(matches!(error, swimmer::SceneError::BadValue { .. }));
    }
}

/// The bodies and joints of a three-sphere swimmer along x, and the four phases of its stroke.
fn swimmer(name: &str, at: [f64; 3]) -> (String, String) {
    let body = |part: &str, x: f64| {
        format!(
            "[[bodies]]\nname = \"{name}-{part}\"\nradius = 1\nposition = [{:?}, {:?}, {:?}]\n",
            at[0] + x,
            at[1],
            at[2]
        )
    };
    let joint = |part: &str| {
        format!(
            "[[links]]\nname = \"{name}-{part}\"\nbody = \"{name}-{part}\"\nto = \"{name}-centre\"\n"
        )
    };
    let bodies = body("left", -10.0) + &body("centre", 0.0) + &body("right", 10.0);
    let joints = joint("left") + &joint("right");
    let phases = [("left", 6), ("right", 6), ("left", 10), ("right", 10)]
        .map(|(part, length)| {
            format!("[[gait.phases]]\nlink = \"{name}-{part}\"\nlength = {length}\n")
        })
        .concat();
    (bodies + &joints, phases)
}

const MULTIPOLE: &str = "model = { kind = \"multipole\", tolerance = 1e-4 }\n";

/// Exact net displacement of the stroke alone in unbounded fluid.
const ALONE: f64 = 0.1598053404;

#[test]
fn two_distant_swimmers_swim_as_if_alone() {
    let (one, strokes) = swimmer("one", [0.0; 3]);
    let (two, other) = swimmer("two", [0.0, 300.0, 0.0]);
    let outcome = run(&format!(
        "domain.kind = \"unbounded\"\n{MULTIPOLE}{one}{two}{strokes}{other}"
    ));
    // The flow of a swimmer decays with the square of the distance, its mean over a stroke with the
    // cube.
    for body in 0..6 {
        let off = (outcome.displacement[body] - Vector3::x() * ALONE).norm();
        assert!(off < 1e-3 * ALONE, "{body}: {off:e}");
    }
}

#[test]
fn two_swimmers_side_by_side_are_each_free_of_force_and_torque() {
    let (one, strokes) = swimmer("one", [0.0; 3]);
    let (two, _) = swimmer("two", [2.0, 4.0, 0.0]);
    let scene = format!("domain.kind = \"unbounded\"\n{MULTIPOLE}{one}{two}{strokes}");
    let instant = start(&scene);
    let bodies = Scene::parse(&scene).unwrap().bodies().to_vec();
    for swimmer in [0..3, 3..6] {
        let force: Vector3<f64> = swimmer.clone().map(|b| instant.bodies[b].force).sum();
        let torque: Vector3<f64> = swimmer
            .map(|b| bodies[b].position.cross(&instant.bodies[b].force) + instant.bodies[b].torque)
            .sum();
        assert!(
            force.norm() < 1e-10 && torque.norm() < 1e-9,
            "{force} {torque}"
        );
    }
    // The swimmer that does not change its shape is advected.
    let carried = instant.bodies[3].velocity.norm();
    assert!(carried > 1e-3 && carried < 0.5, "{carried}");
    let outcome = run(&scene);
    let off = (outcome.displacement[1].x - ALONE).abs() / ALONE;
    assert!(off > 1e-2, "{off:e}");
    assert!(outcome.displacement.iter().all(|d| d.z.abs() < 1e-9));
}

/// The swimmer at a height above the wall z = 0.
fn above_a_wall(height: f64, model: &str) -> Outcome {
    let (bodies, strokes) = swimmer("one", [0.0, 0.0, height]);
    run(&format!(
        "domain.kind = \"wall\"\nmodel = {{ kind = \"{model}\", tolerance = 1e-4 }}\n{bodies}{strokes}"
    ))
}

#[test]
fn a_distant_wall_has_no_effect_and_a_near_one_rotates_the_swimmer() {
    let far = above_a_wall(300.0, "multipole");
    let off = (far.displacement[1] - Vector3::x() * ALONE).norm();
    assert!(off < 1e-3 * ALONE, "{off:e}");
    let near = above_a_wall(3.0, "multipole");
    // By symmetry there is no motion along y and no rotation about x and z.
    assert!(near.displacement.iter().all(|d| d.y.abs() < 1e-9));
    assert!(near.rotation.x.abs() < 1e-9 && near.rotation.z.abs() < 1e-9);
    assert!(near.rotation.y.abs() > 1e-5, "{}", near.rotation);
    // The difference exceeds the tolerance of 1e-4.
    assert!((near.displacement[1].x / ALONE - 1.0).abs() > 1e-3);
    // The Rotne-Prager-Yamakawa model with Blake's images is independent of the expansions and
    // accurate to the first neglected reflection.
    let rpy = above_a_wall(6.0, "rpy");
    let multipole = above_a_wall(6.0, "multipole");
    let off = (rpy.displacement[1] - multipole.displacement[1]).norm();
    assert!(off < 0.2 * multipole.displacement[1].norm(), "{off:e}");
    assert!(off < rpy.error_estimate.total());
}

#[test]
fn a_reciprocal_stroke_has_no_net_displacement_near_walls_and_obstacles() {
    // One arm that opens and closes through the same shapes.
    let scallop = "[[bodies]]\nname = \"a\"\nradius = 1\nposition = [0, 0, 3]\n\
         [[bodies]]\nname = \"b\"\nradius = 0.5\nposition = [4, 0, 4]\n\
         [[links]]\nname = \"arm\"\nbody = \"b\"\nto = \"a\"\n";
    let phases = "[[gait.phases]]\nlink = \"arm\"\nlength = 6\n\
         [[gait.phases]]\nlink = \"arm\"\nlength = 4.1231056256176606\n";
    let obstacle =
        "[[bodies]]\nname = \"rock\"\nradius = 1\nposition = [-2, 1.5, 2]\nfixed = true\n";
    for domain in ["unbounded", "wall"] {
        let outcome = run(&format!(
            "domain.kind = \"{domain}\"\nmodel = {{ kind = \"multipole\", tolerance = 1e-2 }}\n{scallop}{obstacle}{phases}"
        ));
        let longest = outcome.spans[0].displacement[1].norm();
        assert!(longest > 0.3);
        // The integrator is symmetric, so only the errors of the phase spans remain.
        let net = outcome
            .displacement
            .iter()
            .fold(0.0_f64, |m, d| m.max(d.norm()));
        assert!(net < 1e-4 * longest, "{domain}: {net:e}");
        assert_eq!(outcome.displacement[2], Vector3::zeros());
    }
}
