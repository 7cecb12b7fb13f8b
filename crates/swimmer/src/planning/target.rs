//! Element sizes for an asked error of the net displacement.

use crate::SwimError;
use crate::integrate::Method;
use crate::observer::Observer;
use crate::planning::choose;
use crate::simulate::simulate;
use models::FemModel;
use scene::{GeometryKind, Scene};

/// The error is taken to fall with this power of the sizes: the observed order is 3.7 (curved) and 1.8 (straight elements).
const CURVED_ORDER: f64 = 3.5;
const STRAIGHT_ORDER: f64 = 1.7;

/// Part of the allowed error that is aimed at: bars of two meshes scatter by a half about the law.
const AIM: f64 = 0.6;

/// Sizes are not guessed beyond this part of those that the guess is based on.
const FARTHEST: f64 = 0.5;

/// Coarse strokes at most: each is eight times as dear as the one before, and the last one costs what the stroke itself does.
const MOST_STROKES: usize = 6;

/// A stroke that was followed on a coarse mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// Factor on the element sizes, `fem.size_factor`.
    pub size_factor: f64,
    /// Error bar by the mesh over the net displacement.
    pub relative_error: f64,
}

/// What may be done while coarse strokes are tried.
pub trait TrialObserver: Observer {
    /// Sees every stroke that was tried.
    fn tried(&mut self, trial: &Trial) {
        let _ = trial;
    }
}

/// An observer that does nothing.
impl TrialObserver for () {}

/// The `fem.size_factor` with which the error bar of the net displacement by the mesh meets `fem.target`, from strokes on
/// coarse meshes.
///
/// None if nothing is to choose: no target, sizes that are given, or a model without estimates. The observer sees each stroke.
/// Cost: the strokes have at most an eighth of the unknowns of the one that they are for, each an eighth of the next.
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
    for _ in 0..MOST_STROKES {
        let coarse = scene.with_size_factor(Some(size_factor))?;
        let mut model = choose(&coarse)?.model;
        if !model.error_estimates().given(true) {
            return Ok(None);
        }
        let outcome = simulate(&coarse, model.as_mut(), Method::Collocation, observer)?;
        let (Some(bar), true) = (outcome.error_estimate.mesh, outcome.net() > 0.0) else {
            return Ok(None);
        };
        let relative_error = bar / outcome.net();
        observer.tried(&Trial {
            size_factor,
            relative_error,
        });
        if relative_error <= target {
            return Ok(Some(size_factor));
        }
        let next = size_factor * (AIM * target / relative_error).powf(1.0 / order);
        if next >= FARTHEST * size_factor {
            return Ok(Some(next));
        }
        size_factor *= FARTHEST;
    }
    Ok(Some(size_factor))
}
