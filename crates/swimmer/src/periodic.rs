//! The periodic state of a gait with passive joints or masses, by shooting.
//!
//! From any start, the values of springs and the velocities of bodies with mass tend to periodic
//! functions of time: over one cycle they change by the residual `r(z) = P(z) - z`, with the values
//! `P(z)` after a cycle from `z`. Its zero is found by Broyden's method (Kelley 1995, Iterative
//! Methods for Linear and Nonlinear Equations, chapter 7), which starts with `dr/dz = -1`: the
//! first steps are cycles one after the other, and later ones extrapolate their limit.

use models::Hydrodynamics;
use nalgebra::{DMatrix, DVector};
use rigid::State;
use scene::{Scene, spans};

use crate::error::SwimError;
use crate::integrate::{Integrator, Method, relaxation_time};
use crate::observer::{Progress, check_interruption};
use crate::outcome::{Interim, mean_of_moving, positions};
use crate::periodic_flow::periodic_flow;

/// Part of the tolerance of the net displacement to which the state is periodic.
const TOLERANCE_SHARE: f64 = 0.1;

/// Largest number of cycles. Each joint takes about two, and a few more because springs are not
/// linear in the distances.
const MAX_CYCLES: usize = 40;

/// The state before the first phase span of the gait of a scene: periodic if the scene says so,
/// else that of the pose of the scene.
///
/// A fluid with inertia has been moved by cycles before ([`Outcome::periodic_start`]), and so have
/// the bodies.
///
/// [`Outcome::periodic_start`]: crate::Outcome::periodic_start
///
/// # Errors
/// Those of [`periodic_state`] and [`Interim::start`]; [`SwimError::NotPeriodicFlow`] and a gait
/// that is not closed for a fluid with inertia.
pub fn start_of_gait(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    method: Method,
    progress: &mut dyn Progress,
) -> Result<Interim, SwimError> {
    match (scene.starts_periodic(), method) {
        (true, Method::Unsteady) => periodic_flow(scene, model, progress),
        (true, _) => periodic_state(scene, model, method, progress),
        (false, _) => Interim::start(scene),
    }
}

/// The periodic state of the gait of a scene, before its first phase span.
///
/// Bodies start at their places in the scene; only the values of passive joints and the velocities
/// of bodies with mass differ. The solves of the search are counted.
///
/// # Errors
/// [`SwimError::NotPeriodic`] if the search does not converge; errors of the model and the
/// integration.
pub fn periodic_state(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    method: Method,
    progress: &mut dyn Progress,
) -> Result<Interim, SwimError> {
    let set = scene.articulation();
    let passive: Vec<usize> = set.passive_drives().map(|(joint, _)| joint).collect();
    let bodies = match scene.has_masses() && method.has_inertia() {
        true => scene.bodies().len(),
        false => 0,
    };
    let period = scene.gait().cycle_duration();
    let memory = relaxation_time(scene).min(period);
    let mut state = scene.initial_state();
    let mut velocities = vec![0.0; 6 * bodies];
    let size = passive.len() + velocities.len();
    let coordinates = |joints: &[f64], velocities: &[f64]| {
        DVector::from_iterator(size, joints.iter().chain(velocities).copied())
    };
    let mut solves = 0;
    let mut inverse = -DMatrix::<f64>::identity(size, size);
    let mut last: Option<(DVector<f64>, DVector<f64>)> = None;
    let mut mismatch = f64::INFINITY;
    for number in 1..=MAX_CYCLES {
        let start = Start {
            state: &state,
            velocities: &velocities,
        };
        let end = cycle(scene, model, method, &start, &mut solves, progress)?;
        let values = coordinates(&state.joints, &velocities);
        let residual = coordinates(&end.state.joints, &end.velocities) - &values;
        let of_joints = passive.iter().zip(residual.iter());
        let of_joints = of_joints.map(|(&joint, &change)| set.arm_displacement(joint, change));
        let of_body = |body: usize| residual.fixed_rows::<3>(passive.len() + 6 * body).norm();
        let of_bodies = (0..bodies).map(|body| memory * of_body(body));
        mismatch = of_joints.chain(of_bodies).fold(0.0, f64::max);
        let allowed = TOLERANCE_SHARE * scene.model().tolerance * end.net;
        progress.searched_cycle(number, mismatch, allowed);
        if mismatch <= allowed {
            let mut interim = Interim::from_state(scene, state)?;
            interim.outcome.velocities = velocities;
            interim.outcome.solves = solves;
            return Ok(interim);
        }
        if let Some((before, residual_before)) = &last {
            // "Good" Broyden update of the inverse, by the formula of Sherman and Morrison.
            let (step, change) = (&values - before, &residual - residual_before);
            let product = &inverse * change;
            let scale = step.dot(&product);
            if scale.abs() > f64::EPSILON * step.norm() * product.norm() {
                let row = inverse.tr_mul(&step).transpose() / scale;
                inverse += (step - product) * row;
            }
        }
        let next = &values - &inverse * &residual;
        let (joints, others) = next.as_slice().split_at(passive.len());
        state.joints = joints.to_vec();
        velocities = others.to_vec();
        last = Some((values, residual));
    }
    Err(SwimError::NotPeriodic {
        cycles: MAX_CYCLES,
        mismatch,
    })
}

struct Start<'a> {
    state: &'a State,
    velocities: &'a [f64],
}

struct End {
    state: State,
    velocities: Vec<f64>,
    /// Net displacement of the bodies.
    net: f64,
}

/// One cycle.
fn cycle(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    method: Method,
    start: &Start,
    solves: &mut usize,
    progress: &dyn Progress,
) -> Result<End, SwimError> {
    let set = scene.articulation();
    let shape = set.initial_shape();
    let mut state = start.state.clone();
    let mut velocities = start.velocities.to_vec();
    let all = scene.gait().phases.len() * scene.gait().cycles as usize;
    let mut integrator = Integrator::new(scene, model, method).with_velocities(&velocities);
    for span in spans(scene.gait(), shape)?.take(scene.gait().phases.len()) {
        let result = integrator.span(&span, &state, &mut |_, _| {
            check_interruption(progress, 0, all)
        })?;
        *solves += result.solves;
        state = result.end;
        velocities = result.velocities;
    }
    let before = positions(set, start.state, shape)?;
    let after = positions(set, &state, shape)?;
    let displacement: Vec<_> = after.iter().zip(&before).map(|(a, b)| a - b).collect();
    Ok(End {
        state,
        velocities,
        net: mean_of_moving(&displacement).norm(),
    })
}
