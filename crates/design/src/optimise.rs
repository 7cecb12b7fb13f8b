//! The search for the best stroke: several starts, then more and more terms.

use models::ShapeGeometry;
use scene::OptimiseOptions;

use super::objective::{Objective, check_objective};
use super::search::StrokeProblem;
use super::starts::starts;
use super::stroke_path::{Series, StrokeCurve};
use super::totals::StrokeTotals;
use crate::error::{DesignError, DesignProgress, check_interruption};

/// Number of terms of the first series, in which all starts are compared.
pub(super) const FIRST_TERMS: usize = 4;

/// Predicted decrease of the cost at which a search ends, relative to the tolerance of refinement.
const SEARCH_SHARE: f64 = 0.01;

/// How a search is made.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SearchOptions {
    /// The shape at which strokes start; none, the default, for closed strokes anywhere.
    pub start: Option<Vec<f64>>,
    /// Largest number of terms; 64 by default.
    pub terms: usize,
    /// Change of the cost by twice as many terms at which the search ends; 2e-4 by default.
    pub tolerance: f64,
}

impl Default for SearchOptions {
    /// The defaults of the keys `optimise.terms` and `optimise.tolerance` of scenes.
    fn default() -> Self {
        let keys = OptimiseOptions::default();
        Self {
            start: None,
            terms: keys.terms as usize,
            tolerance: keys.tolerance,
        }
    }
}

setters!(SearchOptions {
    with_start(start: Option<Vec<f64>>),
    with_terms(terms: usize),
    with_tolerance(tolerance: f64),
});

/// The best stroke that was found.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Optimum {
    /// The curve of shapes.
    pub curve: StrokeCurve,
    /// Displacement, rotation, and energy times period.
    pub totals: StrokeTotals,
    /// Product of energy and period at constant power.
    pub period_energy_product: f64,
    /// The cost of the objective.
    pub cost: f64,
    /// Change of the cost by the last increase of the number of terms or corners.
    pub refinement_error: f64,
    /// Whether the limits are active.
    pub at_limits: bool,
    /// Number of starts that were tried.
    pub starts: usize,
    /// Number of iterations of all searches.
    pub iterations: usize,
}

/// Searches for the best stroke inside `limits`, one range per joint of the table.
///
/// # Errors
/// [`DesignError::NoStroke`] if no start leads to a stroke, [`DesignError::WrongDerivative`],
/// [`DesignError::Stopped`].
pub fn optimise(
    geometry: &ShapeGeometry,
    objective: &dyn Objective,
    limits: &[(f64, f64)],
    options: &SearchOptions,
    progress: &mut dyn DesignProgress,
) -> Result<Optimum, DesignError> {
    let series = Series::new(FIRST_TERMS.min(options.terms), options.start.as_deref());
    let starts = starts(geometry, objective, &series, limits);
    let mut problem = StrokeProblem::new(geometry, objective, series, limits);
    if let Some(first) = starts.iter().find_map(|start| problem.stroke(start)) {
        check_objective(objective, &first.totals)?;
    }
    progress.begins(&format!("searching from {} strokes", starts.len()));
    let found = problem.compared(&starts);
    let mut iterations = found.iter().map(|(_, minimum)| minimum.iterations).sum();
    // The first of equal ones, so that the result does not depend on the number of threads.
    let best = (found.into_iter()).reduce(|a, b| if b.1.cost < a.1.cost { b } else { a });
    let Some((mut coefficients, mut best)) = best else {
        return Err(DesignError::no_stroke(
            "no stroke inside the limits meets the objective; widen optimise.lower and \
             optimise.upper, or ask for less",
        ));
    };
    let mut terms = problem.series().terms();
    let mut refinement_error = f64::INFINITY;
    loop {
        let before = problem.series();
        let is_first = terms == before.terms();
        check_interruption(progress, || {
            format!("{} terms of the stroke", before.terms())
        })?;
        progress.begins(&format!("{terms} terms per joint"));
        let finer = before.with_terms(terms);
        let start = before.extended(&coefficients, &finer);
        problem = StrokeProblem::new(geometry, objective, finer, limits);
        let found = problem.solved_inside(&start, SEARCH_SHARE * options.tolerance);
        let (refined, minimum) = found.ok_or_else(|| {
            DesignError::no_stroke(format!(
                "the search with {terms} terms has no start inside the limits"
            ))
        })?;
        iterations += minimum.iterations;
        if !is_first {
            refinement_error = (minimum.cost - best.cost).abs();
        }
        (coefficients, best) = (refined, minimum);
        if refinement_error <= options.tolerance || terms == options.terms {
            break;
        }
        terms = (2 * terms).min(options.terms);
    }
    if best.violation > options.tolerance || best.decrease > options.tolerance {
        return Err(DesignError::no_stroke(format!(
            "the search ended after {iterations} iterations with a violation of {:.1e} of the \
             condition and a possible decrease of {:.1e}; change the limits, the displacement or \
             optimise.terms",
            best.violation, best.decrease
        )));
    }
    let stroke = problem
        .stroke(&coefficients)
        .ok_or_else(|| DesignError::no_stroke("the best stroke leaves the table"))?;
    Ok(Optimum {
        totals: stroke.totals,
        period_energy_product: stroke.length.powi(2),
        cost: best.cost,
        refinement_error,
        at_limits: best.at_bounds,
        starts: starts.len(),
        iterations,
        curve: StrokeCurve::Series {
            series: problem.series().clone(),
            coefficients,
        },
    })
}
