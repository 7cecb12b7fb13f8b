//! The periodic state of a gait with passive joints, by shooting.
//!
//! From any start, the values of springs tend to a periodic function of time: over one cycle they
//! change by the residual `r(z) = P(z) - z`, with the values `P(z)` after a cycle from `z`. Its zero
//! is found by Broyden's method (Kelley 1995, Iterative Methods for Linear and Nonlinear Equations,
//! chapter 7), which starts with `dr/dz = -1`: the first steps are cycles one after the other, and
//! later ones extrapolate their limit.

use models::Hydrodynamics;
use nalgebra::{DMatrix, DVector};
use rigid::State;
use scene::{Scene, legs};

use crate::error::SwimError;
use crate::integrate::{Integrator, LegSolution, Method};
use crate::outcome::{mean_of_moving, positions};

/// Part of the tolerance of the net displacement to which the state is periodic.
const SHARE: f64 = 0.1;

/// Largest number of cycles. Each joint takes about two, and a few more because springs are not
/// linear in the distances.
const MAX_CYCLES: usize = 40;

/// The periodic state of the gait of a scene, and the number of solves that it took.
///
/// Bodies start at their places in the scene; only the values of passive joints differ.
///
/// # Errors
/// [`SwimError::NotPeriodic`] if the search does not converge; errors of the model and the
/// integration.
pub fn periodic_state(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    method: Method,
    observe: &mut dyn FnMut(&LegSolution, &dyn Hydrodynamics) -> Result<(), SwimError>,
) -> Result<(State, usize), SwimError> {
    let set = scene.articulation();
    let mut state = scene.initial_state();
    let joints = state.joints.len();
    let links: Vec<usize> = set.passive_links().map(|(link, _)| link).collect();
    let mut solves = 0;
    let mut inverse = -DMatrix::<f64>::identity(joints, joints);
    let mut last: Option<(DVector<f64>, DVector<f64>)> = None;
    let mut mismatch = f64::INFINITY;
    for _ in 0..MAX_CYCLES {
        let (after, net) = cycle(scene, model, method, &state, &mut solves, observe)?;
        let values = DVector::from_column_slice(&state.joints);
        let residual = DVector::from_vec(after.joints) - &values;
        let sizes = links.iter().zip(residual.iter());
        mismatch = sizes
            .map(|(&link, &change)| set.arm_displacement(link, change))
            .fold(0.0, f64::max);
        if mismatch <= SHARE * scene.model().tolerance * net {
            return Ok((state, solves));
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
        let step = -&inverse * &residual;
        state.joints = (&values + step).as_slice().to_vec();
        last = Some((values, residual));
    }
    Err(SwimError::NotPeriodic {
        cycles: MAX_CYCLES,
        mismatch,
    })
}

/// The state after one cycle, and the net displacement of the bodies.
fn cycle(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    method: Method,
    start: &State,
    solves: &mut usize,
    observe: &mut dyn FnMut(&LegSolution, &dyn Hydrodynamics) -> Result<(), SwimError>,
) -> Result<(State, f64), SwimError> {
    let set = scene.articulation();
    let lengths = set.initial_lengths();
    let mut state = start.clone();
    let mut integrator = Integrator::new(scene, model, method);
    for leg in legs(scene.gait(), lengths)?.take(scene.gait().phases.len()) {
        let result = integrator.leg(&leg, &state, observe)?;
        *solves += result.solves;
        state = result.end;
    }
    let before = positions(set, start, lengths)?;
    let after = positions(set, &state, lengths)?;
    let displacement: Vec<_> = after.iter().zip(&before).map(|(a, b)| a - b).collect();
    Ok((state, mean_of_moving(&displacement).norm()))
}
