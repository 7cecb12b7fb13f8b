//! Element sizes that meet a target for the error of the net displacement.

use models::FemModel;
use scene::{GeometryKind, Scene};

use super::choice::choose;
use crate::error::SwimError;
use crate::integrate::Method;
use crate::observer::Observer;
use crate::simulate::simulate;

/// Assumed order of convergence of the error bar on curved elements; 3.8 to 4.4 were observed.
const CURVED_ORDER: f64 = 4.0;
/// Assumed order of convergence of the error bar on straight elements; 1.8 was observed.
const STRAIGHT_ORDER: f64 = 1.7;

/// Fraction of the target at which the extrapolation aims, because the error bars of different
/// meshes scatter by a factor of about a half around the assumed power law.
const AIM: f64 = 0.6;

/// Smallest ratio of the extrapolated sizes to those of the last trial.
const MIN_RATIO: f64 = 0.5;

/// Largest number of trial strokes: each costs eight times as much as the one before, the last one
/// as much as the stroke itself.
const MAX_TRIALS: usize = 6;

/// A trial stroke on a coarse mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Trial {
    /// Factor on the element sizes, as the scene key `fem.size_factor`.
    pub size_factor: f64,
    /// Estimated discretisation error of the net displacement, divided by the net displacement.
    pub relative_error: f64,
}

/// Callbacks during the trial strokes.
pub trait TrialObserver: Observer {
    /// Called after every trial stroke.
    fn tried(&mut self, trial: &Trial) {
        let _ = trial;
    }
}

/// An observer that does nothing.
impl TrialObserver for () {}

/// The `fem.size_factor` with which the estimated discretisation error of the net displacement
/// meets `fem.target`, determined by trial strokes on coarse meshes.
///
/// None without a target, with given sizes, or for a model without estimates.
///
/// Cost: the trial strokes have at most an eighth of the degrees of freedom of the final one, and
/// each an eighth of the next.
///
/// # Errors
/// Those of [`simulate`].
pub fn size_factor_for_target(
    scene: &Scene,
    observer: &mut dyn TrialObserver,
) -> Result<Option<f64>, SwimError> {
    let (Some(target), None) = (scene.fem().target, scene.fem().size_factor) else {
        return Ok(None);
    };
    let order = match scene.fem().geometry {
        GeometryKind::Curved => CURVED_ORDER,
        GeometryKind::Straight => STRAIGHT_ORDER,
    };
    let mut size_factor = FemModel::COARSEST_SIZE_FACTOR;
    for _ in 0..MAX_TRIALS {
        let coarse = scene.with_size_factor(Some(size_factor))?;
        let mut model = choose(&coarse)?.model;
        if !model.error_estimates().given(true) {
            return Ok(None);
        }
        let outcome = simulate(&coarse, model.as_mut(), Method::Collocation, observer)?;
        let (Some(error), true) = (outcome.error_estimate.mesh, outcome.net() > 0.0) else {
            return Ok(None);
        };
        let relative_error = error / outcome.net();
        observer.tried(&Trial {
            size_factor,
            relative_error,
        });
        if relative_error <= target {
            return Ok(Some(size_factor));
        }
        let next = size_factor * (AIM * target / relative_error).powf(1.0 / order);
        if next >= MIN_RATIO * size_factor {
            return Ok(Some(next));
        }
        size_factor *= MIN_RATIO;
    }
    Ok(Some(size_factor))
}
