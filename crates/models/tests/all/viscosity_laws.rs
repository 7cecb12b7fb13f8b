//! Bodies on one axis in fluids whose viscosity depends on the shear rate.

use std::f64::consts::PI;

use models::{AxisymmetricModel, FemModel, Hydrodynamics, InstantaneousSolution};
use testkit::{SceneText, within};

use crate::scenes::{solve_at_start, three_spheres};

const CARREAU: [&str; 4] = [
    "fluid.law=\"carreau\"",
    "fluid.zero_shear_viscosity=1",
    "fluid.relaxation_time=1",
    "fluid.index=0.5",
];

const POWER_LAW: [&str; 4] = [
    "fluid.law=\"power-law\"",
    "fluid.consistency=1",
    "fluid.index=0.8",
    "fluid.regularisation=1e-9",
];

fn solve(text: &SceneText, accuracy: f64, rates: &[f64]) -> InstantaneousSolution {
    let model = AxisymmetricModel::new(&text.scene()).unwrap();
    solve_at_start(&mut model.with_accuracy(accuracy), rates)
}

fn sphere_in_ball(radius: f64, keys: &str) -> SceneText {
    let keys = format!("radius = {radius}, {keys}");
    SceneText::new()
        .ball(10.0 * radius)
        .shape("s", &keys, [0.0, 0.0, 0.0])
}

/// The speed and power of a squirmer in units of length and viscosity other than the scaled ones;
/// by a spectral program in a ball of 10 radii, at the shear number `λ B_1 / a = 1`.
#[test]
fn a_squirmer_in_a_fluid_of_carreau_has_the_speed_and_power_of_a_spectral_program() {
    let (radius, viscosity, b1) = (2.0, 3.0, 0.5);
    let slip = format!("slip = {{ b1 = {b1}, axis = [-1, 0, 0] }}");
    let text = sphere_in_ball(radius, &slip)
        .set(&CARREAU)
        .with("fluid.zero_shear_viscosity", viscosity)
        .with("fluid.relaxation_time", radius / b1);
    let found = solve(&text, 1e-5, &[]);
    let speed = -found.bodies[0].velocity.x / (2.0 / 3.0 * b1);
    let bar = found.error_estimate.total() / (2.0 / 3.0 * b1);
    assert!(bar < 2e-5, "{bar:e}");
    within(speed - 0.9327406407, bar, "the error bar");
    let unit = 16.0 / 3.0 * PI * viscosity * radius * b1 * b1;
    let power = found.power() / unit;
    let bar = found.power_error.total() / unit;
    within(
        power - 0.7524060,
        bar + 1e-7,
        "the error bar and the last digit",
    );
    assert!(found.bodies[0].force.norm() < 1e-9 * unit);
}

/// A sphere that a force drives: Newton's method finds the speed 1 that belongs to the force
/// `X 6 π K a^2 (U / a)^n 2^(1 - n)`, with `X` by a spectral program.
#[test]
fn a_sphere_that_a_force_drives_through_a_power_law_has_the_speed_of_a_spectral_program() {
    let force = 1.3995224 * 6.0 * PI * 2.0_f64.powf(0.2);
    let text = sphere_in_ball(1.0, &format!("force = [{force}, 0, 0]")).set(&POWER_LAW);
    let found = solve(&text, 1e-5, &[]);
    let bar = found.error_estimate.total();
    assert!(bar < 1e-4, "{bar:e}");
    within(
        found.bodies[0].velocity.x - 1.0,
        bar + 1e-7,
        "the error bar",
    );
}

/// The edges of the default mesh are too long for these two: no order had an error below 1.1e-7 and
/// 2.3e-8. The drags, over `6 π`, are those of `axisymmetric::steady_state` on two finer meshes.
#[test]
#[ignore = "slow: 30 s"]
fn bug_scenes_in_the_meridian_plane_missed_the_tolerance_1e_8() {
    let carreau = [("relaxation_time", 10.0), ("index", 0.3)];
    let power_law = [("index", 0.5)];
    for (law, changed, drag) in [
        (CARREAU, &carreau[..], 0.4103983289),
        (POWER_LAW, &power_law[..], 2.1212244289),
    ] {
        let mut text = sphere_in_ball(1.0, "velocity = [1, 0, 0]").set(&law);
        for (key, value) in changed {
            text = text.with(&format!("fluid.{key}"), *value);
        }
        let found = solve(&text, 1e-8, &[]);
        let force = found.bodies[0].force.x / (6.0 * PI);
        // Half a unit of the last digit of both drags is below 2e-10.
        within(force / drag - 1.0, 1e-9, "a tenth of the tolerance");
        let bar = found.force_error.total() / (6.0 * PI * drag);
        // Twice the effect of the regularisation is 1.8e-8 for the power law.
        within(bar, 3e-8, "the bar says something");
    }
}

/// Velocities in a power law are homogeneous of degree one in the rates, forces of the degree of
/// the index; in a fluid of Carreau neither is.
#[test]
fn rates_scale_velocities_in_power_laws_only() {
    let text = three_spheres().ball(30.0);
    let rates = |factor: f64| [-4.0 * factor, 1.0 * factor];
    let speed = |laws: &[&str], factor: f64| {
        let found = solve(&text.clone().set(laws), 1e-4, &rates(factor));
        (found.bodies[0].velocity.x, found.bodies[0].force.x)
    };
    let [(slow, weak), (fast, strong)] = [1.0, 8.0].map(|factor| speed(&POWER_LAW, factor));
    // the flows are the same up to Newton's method and the regularisation
    within(fast / slow - 8.0, 1e-6, "homogeneous of degree one");
    within(
        strong / weak - 8.0_f64.powf(0.8),
        1e-6,
        "homogeneous of the index",
    );
    let [(slow, _), (fast, _)] = [0.2, 1.6].map(|factor| speed(&CARREAU, factor));
    assert!((fast / slow - 8.0).abs() > 1e-2, "{}", fast / slow);
}

/// A law without an effect: the model is that of a Newtonian fluid.
#[test]
fn a_law_with_relaxation_time_zero_is_newtonian() {
    let text = three_spheres().ball(30.0);
    let newtonian = solve(&text, 1e-6, &[-4.0, 1.0]);
    let law = text.set(&CARREAU).with("fluid.relaxation_time", 0);
    let found = solve(&law, 1e-6, &[-4.0, 1.0]);
    let bar = found.error_estimate.total() + newtonian.error_estimate.total();
    for (a, b) in found.bodies.iter().zip(&newtonian.bodies) {
        within((a.velocity - b.velocity).norm(), bar, "both error bars");
    }
    let bar = found.force_error.total() + newtonian.force_error.total();
    for (a, b) in found.joint_loads.iter().zip(&newtonian.joint_loads) {
        within((a.force - b.force).norm(), bar, "both error bars");
    }
}

/// Velocities of three spheres at the shear numbers 0.1 and 0.2: their first order, by Richardson's
/// extrapolation, is that of the reciprocal theorem with multipoles.
#[test]
#[ignore = "slow: 40 s"]
fn three_spheres_have_the_first_order_of_the_reciprocal_theorem() {
    let text = three_spheres().ball(40.0);
    let speed = |time: f64| {
        let law = text
            .clone()
            .set(&CARREAU)
            .with("fluid.relaxation_time", time);
        solve(&law, 1e-8, &[-1.0, 0.0]).bodies[1].velocity.x
    };
    let at_rest = speed(0.0);
    within(
        at_rest.abs() - 0.3428979021,
        1e-7,
        "the accuracy, relative to the rate 1",
    );
    let [one, two] = [0.1, 0.2].map(|time| (speed(time) - at_rest) / (-0.25 * time * time));
    let first = (4.0 * one - two) / 3.0;
    // 1e-8 over the factor 2.5e-3, and the next term, of the fourth order of 0.2
    within(
        first.abs() - 0.022343595,
        4e-5,
        "accuracy and extrapolation",
    );
    assert!(first * at_rest > 0.0);
}

#[test]
fn rotation_and_unbounded_power_laws_are_refused() {
    let text = sphere_in_ball(1.0, "torque = [1, 0, 0]").set(&CARREAU);
    let refused = AxisymmetricModel::new(&text.scene())
        .err()
        .unwrap()
        .to_string();
    testkit::contains(
        "rotation",
        &refused,
        &["fluid.law", "rotation about the axis"],
    );
    let text = SceneText::new()
        .shape("s", "radius = 1, force = [1, 0, 0]", [0.0, 0.0, 0.0])
        .set(&POWER_LAW);
    let mut model = AxisymmetricModel::new(&text.scene()).unwrap();
    let state = text.scene().initial_state();
    let refused = model
        .solve_one(testkit::at(&state, &[]), &[])
        .err()
        .unwrap()
        .to_string();
    testkit::contains("unbounded", &refused, &["unbounded fluid", "ball"]);
}

/// A load below the yield stress moves nothing: the speed is one of the regularisation alone, which
/// is in the bar.
#[test]
#[ignore = "slow: 1 min"]
fn a_load_below_the_yield_stress_moves_a_body_by_no_more_than_the_bar() {
    let text = SceneText::new()
        .ball(5.0)
        .shape("s", "radius = 1, force = [1, 0, 0]", [0.0; 3])
        .with(
            "fluid",
            "{ law = \"herschel-bulkley\", consistency = 1, index = 0.5, yield_stress = 3, \
             regularisation = 1e-3 }",
        );
    let mut model = AxisymmetricModel::new(&text.scene())
        .unwrap()
        .with_accuracy(1e-3);
    let state = text.scene().initial_state();
    match model.solve_one(testkit::at(&state, &[]), &[]) {
        Ok(found) => {
            let speed = found.bodies[0].velocity.x;
            within(
                speed,
                found.error_estimate.total(),
                "speed below the yield stress",
            );
        }
        Err(error) => {
            let message = error.to_string();
            assert!(
                !error.is_bad_input() && message.contains("fluid."),
                "{message}"
            );
        }
    }
}

/// A power law has a viscosity of 1e3 at rest with this regularisation: the solver refused it.
#[test]
fn bug_a_power_law_at_rest_was_refused_in_space() {
    let scene = sphere_in_ball(1.0, "force = [0, 0, 0]")
        .set(&POWER_LAW)
        .scene();
    let mut model = FemModel::new(&scene).unwrap();
    let state = scene.initial_state();
    let found = model.solve_one(testkit::at(&state, &[]), &[]).unwrap();
    assert_eq!(found.bodies[0].velocity.norm(), 0.0);
}

/// The first speed was too large by more than `(1 - n)^(-1 / n)`: the next one was negative, and so
/// on.
#[test]
fn bug_balances_of_steep_power_laws_reversed_the_motion() {
    let scene = sphere_in_ball(1.0, "force = [1, 0, 0]")
        .set(&POWER_LAW)
        .set(&["fluid.index=0.3", "fluid.consistency=0.05"])
        .scene();
    let state = scene.initial_state();
    let mut model = AxisymmetricModel::new(&scene).unwrap().with_accuracy(1e-2);
    let found = model.solve_one(testkit::at(&state, &[]), &[]).unwrap();
    assert!(found.bodies[0].velocity.x > 0.0);
    assert!((found.bodies[0].force.x - 1.0).abs() < 1e-9);
}

/// At the index 0.1 the force was off by 3.7 bars.
#[test]
fn bug_bars_of_steep_power_laws_in_space_were_too_small() {
    let scene = sphere_in_ball(1.0, "force = [1, 0, 0]")
        .set(&POWER_LAW)
        .set(&["fluid.index=0.1"])
        .scene();
    let mut model = FemModel::new(&scene).unwrap();
    let state = scene.initial_state();
    let refused = model
        .solve_one(testkit::at(&state, &[]), &[])
        .err()
        .unwrap()
        .to_string();
    testkit::contains("steep", &refused, &["fluid.index", "0.3", "axisymmetric"]);
}
