//! Time stepping of bodies with mass and moment of inertia.

use std::f64::consts::PI;

use nalgebra::Vector3;
use swimmer::models::{InstantaneousSolution, SphereModel, SpheresModel};
use swimmer::{Method, SwimError};
use testkit::{SceneText, pair, three_spheres, within};

use crate::support::{Run, run_with};

/// The run of a scene with the model of spheres, which has a resistance matrix.
fn run_spheres(text: &SceneText, method: Method) -> Result<Run, SwimError> {
    let scene = text.scene();
    run_with(
        &scene,
        &mut SpheresModel::new(&scene, SphereModel::Rpy)?,
        method,
    )
}

/// A unit sphere with these keys and durations of phases.
fn sphere(keys: &str, durations: &[f64]) -> SceneText {
    let text = SceneText::new().shape("a", &format!("radius = 1, {keys}"), [0; 3]);
    let phase = |text: SceneText, duration: &f64| text.phase(&format!("duration = {duration:?}"));
    durations.iter().fold(text, phase)
}

/// A bent chain of bodies with a given mass and moment of inertia.
fn massive(mass: f64) -> SceneText {
    let bent = three_spheres()
        .tolerance(1e-9)
        .with("bodies.right.position", "[7, 6, 1]");
    (0..3).fold(bent, |text, body| {
        let mass = format!("{mass:e}");
        let text = text.with(&format!("bodies[{body}].mass"), &mass);
        text.with(&format!("bodies[{body}].inertia"), &mass)
    })
}

#[test]
fn light_bodies_move_like_massless_ones_and_heavy_ones_keep_their_momentum() {
    let follow = |text: &SceneText, method| run_spheres(text, method).unwrap();
    let exact = follow(&massive(1e-9), Method::Collocation);
    let error = |steps| {
        let run = follow(&massive(1e-9), Method::BackwardEuler { steps });
        (run.net(1) - exact.net(1)).norm()
    };
    within(
        error(20) / error(40) - 2.0,
        0.1,
        "first order, up to the next one",
    );
    // Equal masses that start at rest: R t / m is 1e-7, so their centre stays, up to the
    // first-order error of the rotation of the arms.
    let heavy = follow(&massive(1e9), Method::BackwardEuler { steps: 20 });
    let centre = |run: &Run| ((0..3).map(|body| run.net(body)).sum::<Vector3<f64>>() / 3.0).norm();
    let coarser = follow(&massive(1e9), Method::BackwardEuler { steps: 10 });
    assert!(centre(&heavy) < 0.02 && centre(&heavy) < 0.6 * centre(&coarser) + 1e-6);
    assert!(heavy.moves[0].iter().any(|step| step.norm() > 1.0));
}

#[test]
fn explicit_steps_with_inertia_are_refused_beyond_the_stability_limit() {
    // One sphere, J = 1: the shortest relaxation time is that of its rotation, 1/(8 pi); the limit
    // is twice that.
    let limit = 2.0 / (8.0 * PI);
    let pulled =
        |step: f64, more: &str| sphere(&format!("force = [1, 0, 0]{more}"), &[50.0 * step]);
    let massive = ", mass = 1, inertia = 1";
    let method = Method::ExplicitInertia { steps: 50 };
    let step = 0.99 * limit;
    let stable = run_spheres(&pulled(step, massive), method).unwrap();
    // v_k = F/R (1 - g^k) with g = 1 - R dt / m, and a step moves by dt v_k.
    let drag = 6.0 * PI;
    let g = 1.0 - drag * step;
    let sum = g * (1.0 - g.powi(50)) / (1.0 - g);
    within(
        stable.net(0).x - step * (50.0 - sum) / drag,
        1e-12,
        "rounding",
    );
    match run_spheres(&pulled(1.01 * limit, massive), method) {
        Err(error @ SwimError::Unstable { .. }) => {
            assert_eq!(error.exit_code(), 3);
            let text = error.to_string();
            assert!(text.contains("take at least 51 steps per phase"), "{text}");
        }
        other => panic!("{:?}", other.map(|run| run.net(0))),
    }
    // A body without mass follows the flow at once: no explicit step is short enough.
    let massless = pulled(limit, "");
    assert!(matches!(
        run_spheres(&massless, method),
        Err(SwimError::Scene(swimmer::SceneError::BadValue { .. }))
    ));
    // Implicit steps have its velocity F/R.
    let still = run_spheres(&massless, Method::BackwardEuler { steps: 5 }).unwrap();
    within(still.net(0).x - 50.0 * limit / drag, 1e-12, "rounding");
}

/// Velocities and forces of all steps of a run, in order.
fn steps(run: &Run) -> impl Iterator<Item = &InstantaneousSolution> {
    run.spans
        .iter()
        .flat_map(|span| span.solutions.iter().map(|solution| &solution.solution))
}

#[test]
fn masses_times_accelerations_are_the_forces_of_the_fluid_and_of_the_joints() {
    // A joint on the line of two spheres transmits a force along it and no torque.
    let (mass, count) = (3.0, 10);
    let text = ["a", "b"].iter().fold(pair(0.0, 4.0), |text, body| {
        let text = text.with(&format!("bodies.{body}.mass"), mass);
        text.with(&format!("bodies.{body}.inertia"), 1)
    });
    let text = text.phases(&[("arm", 5.0)]);
    let run = run_spheres(&text, Method::BackwardEuler { steps: count }).unwrap();
    let mut before = [Vector3::zeros(); 2];
    let mut largest = 0.0_f64;
    for step in steps(&run) {
        // The force of the joint acts on its body, the opposite one on the other end.
        for (body, sign) in [(0, -1.0), (1, 1.0)] {
            let after = step.bodies[body].velocity;
            let inertia = mass * (after - before[body]) * count as f64;
            let forces = sign * step.joint_loads[0].force - step.bodies[body].force;
            within(
                (inertia - forces).norm(),
                1e-11,
                "rounding of forces of about ten",
            );
            largest = largest.max(inertia.norm());
            before[body] = after;
        }
    }
    within(
        largest - 15.0,
        1e-9,
        "the arm starts with a jerk: m v N = 3 x 1/2 x 10",
    );
}

#[test]
fn forces_and_torques_of_a_sphere_with_inertia_are_those_of_stokes() {
    let text = sphere(
        "force = [1, 0, 0], torque = [0, 2, 0], mass = 1, inertia = 2",
        &[1.0],
    );
    let run = run_spheres(&text, Method::BackwardEuler { steps: 50 }).unwrap();
    for step in steps(&run) {
        let body = &step.bodies[0];
        within(
            (body.force - 6.0 * PI * body.velocity).norm(),
            1e-13,
            "rounding",
        );
        within(
            (body.torque - 8.0 * PI * body.angular_velocity).norm(),
            1e-13,
            "rounding",
        );
    }
    let last = &steps(&run).last().unwrap().bodies[0];
    let why = "after twelve relaxation times or more the load is the drag";
    within(last.force.x - 1.0, 1e-4, why);
    within(last.torque.y - 2.0, 1e-3, why);
}

#[test]
fn explicit_and_implicit_steps_with_inertia_have_the_same_limit() {
    // Relaxation times of a few units of time: steps of 1/20 are stable.
    let text = massive(30.0);
    let difference = |steps: usize| {
        let [one, other] = [
            Method::ExplicitInertia { steps },
            Method::BackwardEuler { steps },
        ]
        .map(|method| run_spheres(&text, method).unwrap());
        (0..3)
            .map(|body| (one.net(body) - other.net(body)).norm())
            .fold(0.0, f64::max)
    };
    let (coarse, fine) = (difference(20), difference(40));
    within(coarse / fine - 2.0, 0.2, "first order, up to the next one");
    assert!(fine < 0.1, "{fine}");
}

/// Velocities are part of the state: a phase span starts with those at the end of the phase span
/// before.
#[test]
fn bodies_keep_their_velocities_between_spans() {
    let in_spans = |durations: &[f64], steps: usize, explicit: bool| {
        let text = sphere("force = [1, 0, 0], mass = 20, inertia = 20", durations);
        let method = match explicit {
            true => Method::ExplicitInertia { steps },
            false => Method::BackwardEuler { steps },
        };
        run_spheres(&text, method).unwrap()
    };
    for explicit in [false, true] {
        let whole = in_spans(&[1.0], 20, explicit);
        let halves = in_spans(&[0.5, 0.5], 10, explicit);
        within((whole.net(0) - halves.net(0)).norm(), 1e-14, "rounding");
    }
}
