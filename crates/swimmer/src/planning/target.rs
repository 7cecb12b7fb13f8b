//! Element sizes with which the net displacement meets `fem.target`.

use models::FemModel;
use scene::{GeometryKind, Scene};

use super::choose;
use crate::error::SwimError;
use crate::integrate::Method;
use crate::observer::{MissedTarget, Observer};
use crate::outcome::Outcome;
use crate::simulate::simulate;

/// Relative error bar of the net displacement on curved elements of default size: the median of ten
/// random strokes, which had 1.3e-4 to 7.1e-4 (`docs/figures/random_cases.py`).
const CURVED_BAR: f64 = 3e-4;
/// The largest of these ten.
pub(super) const LARGEST_CURVED_BAR: f64 = 7.1e-4;
/// The same on straight elements: that of the default stroke and of one random stroke.
const STRAIGHT_BAR: f64 = 1e-2;

/// Assumed order of convergence of the error bar on curved elements; 3.8 to 4.4 were observed.
const CURVED_ORDER: f64 = 4.0;
/// Assumed order of convergence of the error bar on straight elements; 1.8 was observed.
const STRAIGHT_ORDER: f64 = 1.7;

/// Fraction of the target at which the sizes aim, because the error bars of different meshes
/// scatter by a factor of about a half around the assumed power law.
const AIM_SHARE: f64 = 0.6;

/// Smallest ratio of successive size factors; a stroke with half the sizes costs about eight times
/// as much.
const MIN_RATIO: f64 = 0.5;

/// Largest number of strokes with finer sizes.
const MAX_REFINEMENTS: usize = 4;

/// The search for the factor on the element sizes (`fem.size_factor`) with which the error bar of
/// the net displacement meets `fem.target`.
///
/// The first factor follows from the error bars that are usual at default sizes. The stroke is
/// simulated with it; if its own error bar exceeds the target, the next factor is extrapolated from
/// that bar with the order of convergence.
///
/// ```
/// use swimmer::{Scene, SizeSearch};
/// let scene = Scene::parse(
///     r#"
///     domain = { kind = "ball", radius = 40 }
///     model.kind = "fem"
///     fem.target = 4.8e-3
///     bodies = [{ name = "ball", radius = 1, position = [0, 0, 0], force = [1, 0, 0] }]
///     gait.phases = [{ duration = 1 }]
///     "#,
/// )?;
/// let search = SizeSearch::new(&scene)?.ok_or("no search")?;
/// // 0.6 of the target is (7/4)^4 times the usual error bar, up to 2 %.
/// assert!((search.size_factor() - 1.75).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SizeSearch {
    target: f64,
    order: f64,
    size_factor: f64,
    refinements: usize,
}

impl SizeSearch {
    /// The search for a scene, with its first factor.
    ///
    /// None without a target, with a given factor, or for a model without estimates of its
    /// discretisation error.
    ///
    /// # Errors
    /// Those of [`choose`].
    pub fn new(scene: &Scene) -> Result<Option<Self>, SwimError> {
        let (Some(target), None) = (scene.fem().target, scene.fem().size_factor) else {
            return Ok(None);
        };
        let (bar, order) = match scene.fem().geometry {
            GeometryKind::Curved => (CURVED_BAR, CURVED_ORDER),
            GeometryKind::Straight => (STRAIGHT_BAR, STRAIGHT_ORDER),
        };
        let size_factor = (AIM_SHARE * target / bar).powf(1.0 / order);
        let search = Self {
            target,
            order,
            size_factor: size_factor.min(FemModel::COARSEST_SIZE_FACTOR),
            refinements: 0,
        };
        let model = choose(&search.apply(scene)?)?.model;
        let estimates = model.capabilities().error_estimates;
        Ok(estimates.given(true).then_some(search))
    }

    /// The factor for the next stroke.
    pub fn size_factor(&self) -> f64 {
        self.size_factor
    }

    /// Continues with another factor, that of an interrupted run.
    pub(crate) fn continue_with(&mut self, size_factor: f64) {
        self.size_factor = size_factor;
    }

    /// The scene with the factor for the next stroke.
    ///
    /// # Errors
    /// A scene that the factor makes invalid.
    pub fn apply(&self, scene: &Scene) -> Result<Scene, SwimError> {
        Ok(scene.with_size_factor(Some(self.size_factor))?)
    }

    /// Chooses a smaller factor if the outcome of the stroke with the present one misses the
    /// target.
    ///
    /// None if it meets the target, has no error estimate, or if four smaller factors have been
    /// tried.
    pub fn refine(&mut self, outcome: &Outcome) -> Option<MissedTarget> {
        let relative_error = outcome.error_estimate.mesh? / outcome.reference_displacement();
        if !(relative_error > self.target && relative_error.is_finite())
            || self.refinements == MAX_REFINEMENTS
        {
            return None;
        }
        let missed = MissedTarget {
            size_factor: self.size_factor,
            relative_error,
        };
        let ratio = (AIM_SHARE * self.target / relative_error).powf(1.0 / self.order);
        self.size_factor *= ratio.max(MIN_RATIO);
        self.refinements += 1;
        Some(missed)
    }
}

/// Simulates the gait of a scene with element sizes that meet its `fem.target`.
///
/// Returns the scene with the factor on the element sizes, and the outcome. Without a target the
/// gait is simulated once. The observer sees every stroke.
///
/// Cost: most strokes meet the target with the first factor; another one costs up to eight times as
/// much as the one before.
///
/// # Errors
/// Those of [`simulate`] and [`choose`].
pub fn simulate_to_target(
    scene: &Scene,
    method: Method,
    observer: &mut dyn Observer,
) -> Result<(Scene, Outcome), SwimError> {
    let mut search = SizeSearch::new(scene)?;
    loop {
        let sized = match &search {
            Some(search) => search.apply(scene)?,
            None => scene.clone(),
        };
        let mut model = choose(&sized)?.model;
        let outcome = simulate(&sized, model.as_mut(), method, observer)?;
        if search
            .as_mut()
            .and_then(|search| search.refine(&outcome))
            .is_none()
        {
            return Ok((sized, outcome));
        }
    }
}
