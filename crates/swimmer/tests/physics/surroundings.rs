//! Swimmers near obstacles, walls and other swimmers.

use std::f64::consts::PI;

use nalgebra::Vector3;
use swimmer::Outcome;
use testkit::exact::STROKE;
use testkit::{SceneText, chain, run, start, within};

/// A sphere pulled by a force beside a fixed one, centres three radii apart along x.
fn beside_an_obstacle(model: &str, force: &str) -> SceneText {
    chain(&["pulled", "obstacle"], &[-1.5, 1.5])
        .with("bodies.pulled.force", force)
        .with("bodies.obstacle.fixed", true)
        .model(model, 1e-6)
}

/// Why multipoles are more accurate than their tolerance of 1e-6.
const CONVERGED: &str = "the next multipoles decrease by the square of the distance in radii";

#[test]
fn an_obstacle_slows_a_sphere_by_the_exact_amount() {
    // Two equal spheres at a distance of three radii, bispherical series: XA11, XA12, YA11 over 6
    // pi, YC11 over 8 pi, and the coupling.
    let (xa11, xa12) = (1.3684796020864693, -0.6701750418364307);
    let (ya11, yc11, coupling) = (1.0921017532628983, 1.0179857150673868, 0.713097351810985);
    let along = start(&beside_an_obstacle("multipole", "[1, 0, 0]").scene());
    let exact = 1.0 / (6.0 * PI * xa11);
    within(along.bodies[0].velocity.x / exact - 1.0, 1e-8, CONVERGED);
    assert_eq!(along.bodies[1].velocity, Vector3::zeros());
    assert_eq!(along.bodies[1].angular_velocity, Vector3::zeros());
    // Force of the obstacle on the fluid.
    within(along.bodies[1].force.x - xa12 / xa11, 1e-8, CONVERGED);
    let across = start(&beside_an_obstacle("multipole", "[0, 0, 1]").scene());
    let exact = 1.0 / (6.0 * PI * ya11 - coupling * coupling / (8.0 * PI * yc11));
    within(across.bodies[0].velocity.z / exact - 1.0, 1e-8, CONVERGED);
}

#[test]
fn obstacles_by_finite_elements_agree_with_multipoles() {
    let scene = |model: &str| beside_an_obstacle(model, "[1, 0, 1]").ball(6.0);
    let exact = start(&scene("multipole").scene());
    let speed = exact.bodies[0].velocity.norm();
    for formulation in ["p-tilde", "lagrange", "direct-row"] {
        let text = scene("fem").with("fem.formulation", formulation);
        let found = start(&text.with("fem.surface_size", 0.5).scene());
        let off = (found.bodies[0].velocity - exact.bodies[0].velocity).norm();
        within(
            off,
            1e-2 * speed,
            "half a radius has an error of 4e-3 in the drag of one sphere",
        );
        let why = format!("on so coarse a mesh bars are right to a factor of two: {formulation}");
        within(off, 2.0 * found.error_estimate.total(), why);
        within(
            found.bodies[1].velocity.norm(),
            1e-7 * speed,
            "the residual of the solver",
        );
        let off = (found.bodies[1].force - exact.bodies[1].force).norm();
        within(
            off,
            1e-2,
            format!("as the velocity, relative to one: {formulation}"),
        );
    }
}

#[test]
fn invalid_obstacles_are_refused() {
    let good = beside_an_obstacle("multipole", "[1, 0, 0]");
    for (text, message) in [
        (
            good.clone().with("bodies.obstacle.fixed", 1),
            "must be true or false",
        ),
        (
            good.clone().with("bodies.obstacle.force", "[0, 1, 0]"),
            "holds the body against any load",
        ),
        (
            good.set(&["bodies.pulled.force=[0, 0, 0]", "bodies.pulled.fixed=true"]),
            "are all fixed, so nothing moves",
        ),
    ] {
        let error = text.try_scene().unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
        assert!(matches!(error, swimmer::SceneError::BadValue { .. }));
    }
}

/// Adds a three-sphere swimmer along x.
fn swimmer(text: SceneText, name: &str, [x, y, z]: [f64; 3]) -> SceneText {
    let [left, centre, right] = ["left", "centre", "right"].map(|part| format!("{name}-{part}"));
    text.sphere(&left, 1.0, [x - 10.0, y, z])
        .sphere(&centre, 1.0, [x, y, z])
        .sphere(&right, 1.0, [x + 10.0, y, z])
        .slide(&left, &left, &centre)
        .slide(&right, &right, &centre)
}

/// Adds the four phases of its stroke.
fn stroke(text: SceneText, name: &str) -> SceneText {
    let [left, right] = ["left", "right"].map(|part| format!("{name}-{part}"));
    text.phases(&[(&left, 6.0), (&right, 6.0), (&left, 10.0), (&right, 10.0)])
}

/// Swimmers with these centres; all of `strokes` move one after the other.
fn swimmers(places: &[(&str, [f64; 3])], strokes: &[&str]) -> SceneText {
    let text = places.iter().fold(SceneText::new(), |text, (name, at)| {
        swimmer(text, name, *at)
    });
    strokes
        .iter()
        .fold(text, |text, name| stroke(text, name))
        .model("multipole", 1e-4)
}

#[test]
fn two_distant_swimmers_swim_as_if_alone() {
    let places = [("one", [0.0; 3]), ("two", [0.0, 300.0, 0.0])];
    let outcome = run(&swimmers(&places, &["one", "two"]).scene());
    // The flow of a swimmer decays with the square of the distance, its mean over a stroke with the
    // cube.
    for body in 0..6 {
        let off = (outcome.displacement[body] - Vector3::x() * STROKE.value).norm();
        within(
            off,
            1e-3 * STROKE.value,
            format!("ten tolerances, body {body}"),
        );
    }
}

#[test]
fn two_swimmers_side_by_side_are_each_free_of_force_and_torque() {
    let scene = swimmers(&[("one", [0.0; 3]), ("two", [2.0, 4.0, 0.0])], &["one"]).scene();
    let instant = start(&scene);
    for swimmer in [0..3, 3..6] {
        let force: Vector3<f64> = swimmer.clone().map(|b| instant.bodies[b].force).sum();
        let torque = swimmer.map(|b| {
            let (position, body) = (scene.bodies()[b].position, instant.bodies[b]);
            position.cross(&body.force) + body.torque
        });
        within(force.norm(), 1e-10, "rounding of forces of about 50");
        within(
            torque.sum::<Vector3<f64>>().norm(),
            1e-9,
            "the same with arms of ten",
        );
    }
    // The swimmer that does not change its shape is advected.
    let carried = instant.bodies[3].velocity.norm();
    assert!(carried > 1e-3 && carried < 0.5, "{carried}");
    let outcome = run(&scene);
    let off = (outcome.displacement[1].x - STROKE.value).abs() / STROKE.value;
    assert!(off > 1e-2, "{off:e}");
    assert!(outcome.displacement.iter().all(|d| d.z.abs() < 1e-9));
}

/// The swimmer at a height above the wall z = 0.
fn above_a_wall(height: f64, model: &str) -> Outcome {
    let text = swimmers(&[("one", [0.0, 0.0, height])], &["one"]).model(model, 1e-4);
    run(&text.with("domain.kind", "wall").scene())
}

#[test]
fn a_distant_wall_has_no_effect_and_a_near_one_rotates_the_swimmer() {
    let far = above_a_wall(300.0, "multipole");
    let off = (far.displacement[1] - Vector3::x() * STROKE.value).norm();
    within(off, 1e-3 * STROKE.value, "ten tolerances");
    let near = above_a_wall(3.0, "multipole");
    // By symmetry there is no motion along y and no rotation about x and z.
    assert!(near.displacement.iter().all(|d| d.y.abs() < 1e-9));
    assert!(near.rotation.x.abs() < 1e-9 && near.rotation.z.abs() < 1e-9);
    assert!(near.rotation.y.abs() > 1e-5, "{}", near.rotation);
    // The difference exceeds the tolerance of 1e-4.
    assert!((near.displacement[1].x / STROKE.value - 1.0).abs() > 1e-3);
    // The Rotne-Prager-Yamakawa model with Blake's images is independent of the expansions and
    // accurate to the first neglected reflection.
    let rpy = above_a_wall(6.0, "rpy");
    let multipole = above_a_wall(6.0, "multipole");
    let off = (rpy.displacement[1] - multipole.displacement[1]).norm();
    within(
        off,
        0.2 * multipole.displacement[1].norm(),
        "the first neglected reflection",
    );
    within(off, rpy.error_estimate.total(), "the error bar");
}

#[test]
#[ignore = "slow: 10 s"]
fn a_reciprocal_stroke_has_no_net_displacement_near_walls_and_obstacles() {
    // One arm that opens and closes through the same shapes.
    let text = SceneText::new()
        .sphere("a", 1.0, [0, 0, 3])
        .sphere("b", 0.5, [4, 0, 4])
        .shape("rock", "radius = 1, fixed = true", [-2.0, 1.5, 2.0])
        .slide("arm", "b", "a")
        .phases(&[("arm", 6.0), ("arm", 4.123105625617661)])
        .model("multipole", 1e-2);
    for domain in ["unbounded", "wall"] {
        let outcome = run(&text.clone().with("domain.kind", domain).scene());
        let longest = outcome.spans[0].displacement[1].norm();
        assert!(longest > 0.3);
        let net = (outcome.displacement.iter()).fold(0.0_f64, |m, d| m.max(d.norm()));
        let why = "the integrator is symmetric, so only the errors of the phase spans remain";
        within(net, 1e-4 * longest, format!("{why}: {domain}"));
        assert_eq!(outcome.displacement[2], Vector3::zeros());
    }
}
