//! The first-order effect of neglected inertia: exact values, units, jumps of rates, refusals.

use models::{FemModel, Hydrodynamics, InertialChange, PathPoint};
use nalgebra::Vector3;
use scene::Scene;
use testkit::{SceneText, contains, within};

use crate::scenes::{solve_at_start, three_spheres};

/// The effect at the start of a scene.
fn change(model: &mut FemModel, rates: &[f64], accelerations: &[f64]) -> InertialChange {
    let scene = model.scene().clone();
    let state = scene.initial_state();
    let point = PathPoint {
        configuration: testkit::at(&state, scene.articulation().initial_shape()),
        rates,
        accelerations,
    };
    model.neglected_inertia().unwrap().change(&point).unwrap()
}

/// Three spheres in the middle of a ball of 20 radii, with these densities.
fn in_ball(density: f64, of_bodies: f64) -> SceneText {
    let densities = ["left", "centre", "right"]
        .into_iter()
        .map(|name| format!("bodies.{name}.density={of_bodies:?}"));
    let text = three_spheres()
        .ball(20.0)
        .with("fluid.density", format!("{density:?}"));
    densities.fold(text, |text, setting| text.set(&[&setting]))
}

/// Velocities of the centre sphere of three unit spheres at -10, 0 and 10 in a fixed ball of radius
/// 20, while the left arm closes at the constant rate 1: of Stokes flow, and its changes per
/// density of the fluid by the unsteady and the convective acceleration, and per density of the
/// bodies. Reciprocal theorem with multipole expansions, two resolutions equal to 1e-11; the
/// viscosity is 1.
const STOKES: f64 = -0.3440093469;
const CHANGES: [f64; 3] = [-0.02629507985, 0.001485913904, -0.000532333222];

#[test]
fn three_spheres_in_a_ball_by_the_reciprocal_theorem() {
    let mut model = FemModel::new(&in_ball(1.0, 1.0).scene()).unwrap();
    // An arm that opens on the right has the mirrored flow of one that closes on the left.
    for (rates, side, outer) in [([-1.0, 0.0], 1.0, 0), ([0.0, 1.0], -1.0, 2)] {
        let solution = solve_at_start(&mut model, &rates);
        within(
            solution.bodies[1].velocity.x - STOKES,
            solution.error_estimate.total(),
            "the error bar",
        );
        // The effect is linear in each of three flows, whose strength far from the bodies has the
        // relative error of their forces; near them the error is of higher order.
        let [computed, corrected] =
            [&solution.uncorrected(), &solution].map(|solution| solution.bodies[outer].force.x);
        let bound = 3.0 * (computed / corrected - 1.0).abs();
        within(bound, 0.01, "the bound says something");
        let change = change(&mut model, &rates, &[0.0; 2]);
        for ((cause, found), exact) in change.causes().into_iter().zip(CHANGES) {
            for body in &found.bodies {
                within(
                    body.velocity.x - side * exact,
                    bound * exact.abs(),
                    format!("{cause}: three times the error of the forces"),
                );
            }
            // The forces of a free swimmer sum to minus the rate of its momentum, which is that of
            // the bodies alone.
            let sum: Vector3<f64> = found.bodies.iter().map(|body| body.force).sum();
            assert_eq!(cause == "bodies", sum.norm() > 1e-3, "{cause}: {sum}");
        }
    }
}

#[test]
fn effects_of_inertia_have_the_units_of_the_scene() {
    let of = |scene: &Scene, rates: &[f64]| {
        let total = |change: InertialChange| change.causes().map(|(_, r)| r.bodies[1].velocity.x);
        let mut model = FemModel::new(scene).unwrap();
        total(change(&mut model, rates, &[0.3 * rates[0] * rates[0], 0.0]))
    };
    let coarse = |text: SceneText| text.with("fem.size_factor", "2.0").scene();
    let scaled = of(&coarse(in_ball(1.0, 1.0)), &[-1.0, 0.0]);
    let (radius, viscosity, density, of_bodies, rate) = (2.0, 3.0, 5.0, 0.7, 7.0);
    let mut text = SceneText::new();
    for (name, x) in [("left", -10.0), ("centre", 0.0), ("right", 10.0)] {
        let keys = format!("radius = {radius:?}, density = {of_bodies:?}");
        text = text.shape(name, &keys, [radius * x, 0.0, 0.0]);
    }
    let text = (text.slide("left-arm", "left", "centre"))
        .slide("right-arm", "right", "centre")
        .ball(20.0 * radius)
        .with(
            "fluid",
            format!("{{ viscosity = {viscosity:?}, density = {density:?} }}"),
        );
    // Accelerations of 0.3 w^2 / radius.
    let acceleration = |rate: f64| 0.3 * rate * rate / radius;
    let scene = coarse(text);
    let mut model = FemModel::new(&scene).unwrap();
    let found = change(&mut model, &[-rate, 0.0], &[acceleration(rate), 0.0]);
    for (k, (cause, response)) in found.causes().into_iter().enumerate() {
        let density = if cause == "bodies" {
            of_bodies
        } else {
            density
        };
        // velocities are ρ L w^2 / μ in scaled units
        let expected = scaled[k] * density * radius * rate * rate / viscosity;
        within(
            response.bodies[1].velocity.x - expected,
            1e-6 * expected.abs(),
            "rounding, in the tolerance of the same iterations",
        );
    }
}

#[test]
fn a_jump_of_the_rates_is_an_acceleration_for_a_short_time() {
    let scene = in_ball(1.0, 3.0).with("fem.size_factor", "2.0").scene();
    let mut model = FemModel::new(&scene).unwrap();
    let (rates, acceleration) = ([-1.0, 0.4], [0.5, 2.0]);
    let [accelerated, steady] = [acceleration, [0.0; 2]].map(|a| change(&mut model, &rates, &a));
    let state = scene.initial_state();
    let configuration = testkit::at(&state, scene.articulation().initial_shape());
    let after = [0, 1].map(|joint| rates[joint] + acceleration[joint]);
    let jump = model.neglected_inertia().unwrap();
    let jump = jump.jump(configuration, &rates, &after).unwrap();
    let velocity = |change: &InertialChange| change.causes().map(|(_, r)| r.bodies[1].velocity.x);
    let [accelerated, steady, jump] = [&accelerated, &steady, &jump].map(velocity);
    assert_eq!(jump[1], 0.0);
    for k in [0, 2] {
        within(
            accelerated[k] - steady[k] - jump[k],
            3e-4 * (accelerated[k].abs() + jump[k].abs()),
            "residuals of 1e-4 of three solutions",
        );
        assert!(jump[k].abs() > 0.1 * steady[k].abs());
    }
}

/// `dU/dRe = -3/20 β U` of a squirmer with `β = B_2 / B_1` (Wang & Ardekani 2012, Khair & Chisholm
/// 2014), less the effect of the ball that is meshed.
///
/// In a ball of radius `b` that moves along, a spectral solution has the slopes -0.096738165,
/// -0.144377717 and -0.149427098 for b = 10, 100 and 1000: 0.570 / b, to 2 % above b = 60, is
/// missing.
#[test]
fn a_squirmer_in_unbounded_fluid_in_its_moving_frame() {
    let beta = 2.0;
    let slip = format!(
        "slip = {{ b1 = 1.5, b2 = {:?}, axis = [0, 3, 4] }}",
        1.5 * beta
    );
    let text = SceneText::new().shape("s", &format!("radius = 1.0, {slip}"), [0; 3]);
    let text = text.with("fluid.density", 1.0).with("fem.size_factor", 0.7);
    let mut model = FemModel::new(&text.scene()).unwrap();
    let solution = solve_at_start(&mut model, &[]);
    let change = change(&mut model, &[], &[]);
    let axis = Vector3::new(0.0, 0.6, 0.8);
    let expected = beta * (-0.15 + 0.570 / 60.0);
    let found = change.total().bodies[0].velocity;
    // The effect is quadratic in the flow of the slip, as the power is.
    let bound = (solution.uncorrected_power() / solution.power() - 1.0).abs();
    within(bound, 0.02, "the bound says something");
    within(
        (found - axis * expected).norm(),
        bound * expected.abs(),
        "the relative error of the power",
    );
    // It moves steadily but for a spin by the mesh, which turns the velocity: the acceleration
    // times mass over drag.
    let spin = solution.uncorrected().bodies[0].angular_velocity.norm();
    within(
        change.bodies.bodies[0].velocity.norm(),
        1.1 * spin * 2.0 / 9.0,
        "4π/3 over 6π, with a tenth for the mesh error of the drag",
    );
}

#[test]
fn effects_of_inertia_that_are_not_of_first_order_are_refused() {
    let sphere = |keys: &str| SceneText::new().shape("s", &format!("radius = 1, {keys}"), [0; 3]);
    let refusal = |text: SceneText| {
        let scene = text
            .with("fluid.density", 1.0)
            .with("fem.size_factor", "2.0")
            .scene();
        let state = scene.initial_state();
        let mut model = FemModel::new(&scene).unwrap();
        let point = PathPoint {
            configuration: testkit::at(&state, &[]),
            rates: &[],
            accelerations: &[],
        };
        let refused = model
            .neglected_inertia()
            .unwrap()
            .change(&point)
            .unwrap_err();
        assert!(refused.is_bad_input());
        refused.to_string()
    };
    let dragged = refusal(sphere("force = [1, 0, 0]"));
    contains(
        "a total force",
        &dragged,
        &["unbounded", "sqrt(S)", "Oseen"],
    );
    let massive = refusal(sphere("mass = 2").ball(5.0));
    contains("masses", &massive, &["not neglected", "densities"]);
    let wind = "background = { kind = \"uniform\", velocity = [1, 0, 0] }";
    let wind = sphere("slip = { b1 = 1 }").set(&[wind]);
    contains("a background flow", &refusal(wind), &["background flow"]);
}
