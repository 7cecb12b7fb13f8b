//! First-order effects of neglected terms: exact values, units, jumps of rates, refusals.

use models::{
    AxisymmetricModel, FemModel, FirstOrderChange, Hydrodynamics, NeglectedTerm, PathPoint,
};
use nalgebra::Vector3;
use scene::Scene;
use testkit::{SceneText, contains, within};

use crate::scenes::{solve_at_start, three_spheres};

/// The effect of inertia at the start of a scene.
fn change(model: &mut FemModel, rates: &[f64], accelerations: &[f64]) -> FirstOrderChange {
    change_by(NeglectedTerm::Inertia, model, rates, accelerations)
}

/// The effect of a term at the start of a scene.
fn change_by(
    term: NeglectedTerm,
    model: &mut dyn Hydrodynamics,
    rates: &[f64],
    accelerations: &[f64],
) -> FirstOrderChange {
    let scene = model.scene().clone();
    let state = scene.initial_state();
    let point = PathPoint {
        configuration: testkit::at(&state, scene.articulation().initial_shape()),
        rates,
        accelerations,
    };
    model.neglected(term).unwrap().change(term, &point).unwrap()
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
        for ((cause, found), exact) in change.parts.iter().zip(CHANGES) {
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
            assert_eq!(*cause == "bodies", sum.norm() > 1e-3, "{cause}: {sum}");
        }
    }
}

#[test]
fn effects_of_inertia_have_the_units_of_the_scene() {
    let of = |scene: &Scene, rates: &[f64]| {
        let total = |change: FirstOrderChange| -> Vec<f64> {
            change
                .parts
                .iter()
                .map(|(_, r)| r.bodies[1].velocity.x)
                .collect()
        };
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
    for (k, (cause, response)) in found.parts.iter().enumerate() {
        let density = if *cause == "bodies" {
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
    let jump = model.neglected(NeglectedTerm::Inertia).unwrap();
    let jump = jump.jump(configuration, &rates, &after).unwrap();
    let velocity = |change: &FirstOrderChange| -> Vec<f64> {
        change
            .parts
            .iter()
            .map(|(_, r)| r.bodies[1].velocity.x)
            .collect()
    };
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
    let parts = change
        .parts
        .iter()
        .map(|(_, response)| response.bodies[0].velocity);
    let found: Vector3<f64> = parts.sum();
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
        change.part("bodies").unwrap().bodies[0].velocity.norm(),
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
        let term = NeglectedTerm::Inertia;
        let refused = (model.neglected(term).unwrap().change(term, &point)).unwrap_err();
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

/// The three spheres in a ball of 40 radii whose fluid neglects a law of Carreau.
fn carreau_in_ball(time: f64) -> SceneText {
    let law = format!(
        "{{ law = \"carreau\", zero_shear_viscosity = 1, relaxation_time = {time:?}, index = 0.5, \
         rheology = \"newtonian\" }}"
    );
    three_spheres().ball(40.0).with("fluid", law)
}

/// Change of the velocity of the centre sphere at -10, 0, 10 in a ball of 40 radii while the left
/// arm closes at the rate 1, in units of `(n - 1) / 2 λ^2` (reciprocal theorem with multipole
/// expansions over the whole fluid, two resolutions equal to the last digit).
const CARREAU_SLOPE: f64 = -0.022343595;

#[test]
fn a_law_of_carreau_changes_three_spheres_as_by_the_reciprocal_theorem() {
    let (time, term) = (1e-2, NeglectedTerm::Rheology);
    let exact = -0.25 * time * time * CARREAU_SLOPE;
    let scene = carreau_in_ball(time).scene();
    let mut plane = AxisymmetricModel::new(&scene).unwrap();
    let in_plane = change_by(term, &mut plane, &[-1.0, 0.0], &[0.0; 2]);
    // λ^2 times three quarters of the squared shear rates, of about one, is left of the viscosity.
    for (name, bound) in [("viscosity", 2e-3), ("second_order", 1e-3)] {
        let found = in_plane.part(name).unwrap().bodies[1].velocity.x;
        within(
            found - exact,
            bound * exact.abs(),
            format!("{name}: tolerance of the change"),
        );
    }
    let mut space = FemModel::new(&scene).unwrap();
    let solution = solve_at_start(&mut space, &[-1.0, 0.0]);
    let in_space = change_by(term, &mut space, &[-1.0, 0.0], &[0.0; 2]);
    // The effect is an integral of products of gradients, which are of half the order of the
    // forces.
    let [computed, corrected] =
        [&solution.uncorrected(), &solution].map(|solution| solution.bodies[0].force.x);
    let bound = (computed / corrected - 1.0).abs().sqrt();
    within(bound, 0.05, "the bound says something");
    for (name, response) in &in_space.parts {
        let found = response.bodies[1].velocity.x;
        within(
            found - exact,
            bound * exact.abs(),
            format!("{name}: error of gradients"),
        );
        let sum: Vector3<f64> = response.bodies.iter().map(|body| body.force).sum();
        let largest = (response.bodies.iter()).fold(0.0_f64, |m, body| m.max(body.force.norm()));
        within(
            sum.norm(),
            1e-3 * largest,
            "no total force: residuals of 1e-4",
        );
    }
}

/// Velocities are `λ^2 w^3 / L^2` times numbers, in units of the scene.
#[test]
fn effects_of_a_law_have_the_units_of_the_scene() {
    let term = NeglectedTerm::Rheology;
    let of = |scene: &Scene, rate: f64| {
        let mut model = AxisymmetricModel::new(scene).unwrap();
        change_by(term, &mut model, &[-rate, 0.0], &[0.0; 2])
    };
    let scaled = of(&carreau_in_ball(0.3).scene(), 1.0);
    let (radius, viscosity, rate) = (2.0, 3.0, 4.0);
    let mut text = SceneText::new();
    for (name, x) in [("left", -10.0), ("centre", 0.0), ("right", 10.0)] {
        text = text.sphere(name, radius, [radius * x, 0.0, 0.0]);
    }
    let law = format!(
        "{{ law = \"carreau\", zero_shear_viscosity = {viscosity:?}, relaxation_time = 0.15, \
         index = 0.5, rheology = \"auto\" }}"
    );
    // The shear rate is twice as large, and the relaxation time half as long.
    let text = (text.slide("left-arm", "left", "centre"))
        .slide("right-arm", "right", "centre")
        .ball(40.0 * radius)
        .with("fluid", law);
    let found = of(&text.scene(), rate);
    for ((name, scaled), (_, found)) in scaled.parts.iter().zip(&found.parts) {
        let expected = rate * scaled.bodies[1].velocity.x;
        within(
            found.bodies[1].velocity.x - expected,
            1e-9 * expected.abs(),
            format!("{name}: rounding"),
        );
        let expected = rate * viscosity * radius * scaled.bodies[1].force.x;
        let difference = found.bodies[1].force.x - expected;
        within(
            difference,
            1e-8 * expected.abs(),
            format!("{name}: rounding of forces"),
        );
    }
}
