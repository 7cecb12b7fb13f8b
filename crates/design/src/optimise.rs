//! The search for the best stroke: several starts, then more and more terms.

use models::ShapeGeometry;
use rayon::prelude::*;

use super::interior_point::Minimum;
use super::objective::Objective;
use super::search::StrokeProblem;
use super::starts::starts;
use super::stroke_path::{Series, StrokeCurve};
use super::totals::StrokeTotals;
use crate::error::{DesignError, DesignProgress, check_interruption};

/// Number of terms of the first series, in which all starts are compared.
pub(super) const FIRST_TERMS: usize = 4;

/// Predicted decrease of the cost at which a search ends, relative to the tolerance of refinement.
const SEARCH: f64 = 0.01;

/// Predicted decrease at which the starts are compared.
const COMPARE: f64 = 1e-3;

/// Number of iterations in which the starts are compared; those to a good stroke take about 30.
const COMPARE_ITERATIONS: usize = 60;

/// Largest number of iterations of a refined search, which takes 10 to 150.
const MAX_ITERATIONS: usize = 400;

/// Number of times between the quadrature points at which limits are checked.
const CHECKS_PER_TERM: usize = 200;

/// How a search is made.
#[derive(Clone, Debug)]
pub struct SearchOptions {
    /// The shape at which strokes start; none for closed strokes anywhere.
    pub start: Option<Vec<f64>>,
    /// Largest number of terms.
    pub terms: usize,
    /// Change of the cost by twice as many terms at which the search ends.
    pub tolerance: f64,
}

/// The best stroke that was found.
#[derive(Clone, Debug)]
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
/// [`DesignError::NoStroke`] if no start leads to a stroke, [`DesignError::Stopped`].
pub fn optimise(
    geometry: &ShapeGeometry,
    objective: &dyn Objective,
    limits: &[(f64, f64)],
    options: &SearchOptions,
    progress: &mut dyn DesignProgress,
) -> Result<Optimum, DesignError> {
    let series = Series::new(FIRST_TERMS.min(options.terms), options.start.as_deref());
    let starts = starts(geometry, objective, &series, limits);
    progress.begins(&format!("searching from {} strokes", starts.len()));
    let found = compared(geometry, objective, &series, &starts, limits);
    let mut iterations = found.iter().map(|(_, minimum)| minimum.iterations).sum();
    // The first of equal ones, so that the result does not depend on the number of threads.
    let best = (found.into_iter()).reduce(|a, b| if b.1.cost < a.1.cost { b } else { a });
    let Some((coefficients, best)) = best else {
        return Err(DesignError::no_stroke(
            "no stroke inside the limits meets the objective; widen optimise.lower and \
             optimise.upper, or ask for less",
        ));
    };
    let mut found = Refined {
        series,
        coefficients,
        best,
        error: f64::INFINITY,
    };
    let mut is_first = true;
    loop {
        check_interruption(progress, || {
            format!("{} terms of the stroke", found.series.terms())
        })?;
        let terms = match is_first {
            true => found.series.terms(),
            false => (2 * found.series.terms()).min(options.terms),
        };
        progress.begins(&format!("{terms} terms per joint"));
        let refined = found.refined(geometry, objective, limits, terms, options.tolerance);
        let refined = refined.ok_or_else(|| {
            DesignError::no_stroke(format!(
                "the search with {terms} terms has no start inside the limits"
            ))
        })?;
        iterations += refined.best.iterations;
        let error = match is_first {
            true => f64::INFINITY,
            false => refined.error,
        };
        found = Refined { error, ..refined };
        if error <= options.tolerance || terms == options.terms {
            break;
        }
        is_first = false;
    }
    let Refined {
        series,
        coefficients,
        best,
        error: refinement_error,
    } = found;
    if best.violation > options.tolerance || best.decrease > options.tolerance {
        return Err(DesignError::no_stroke(format!(
            "the search ended after {iterations} iterations with a violation of {:.1e} of the \
             condition and a possible decrease of {:.1e}; change the limits, the displacement or \
             optimise.terms",
            best.violation, best.decrease
        )));
    }
    let problem = StrokeProblem::new(geometry, objective, series.clone(), limits);
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
            series,
            coefficients,
        },
    })
}

/// The best stroke of a series.
struct Refined {
    series: Series,
    coefficients: Vec<f64>,
    best: Minimum,
    /// Change of the cost by the last increase of the number of terms.
    error: f64,
}

impl Refined {
    /// The best stroke with this number of terms, from this one; none without a start inside the
    /// limits.
    fn refined(
        &self,
        geometry: &ShapeGeometry,
        objective: &dyn Objective,
        limits: &[(f64, f64)],
        terms: usize,
        tolerance: f64,
    ) -> Option<Self> {
        let series = self.series.with_terms(terms);
        let start = self.series.extended(&self.coefficients, &series);
        let tolerance = SEARCH * tolerance;
        let (coefficients, best) =
            solved_inside(geometry, objective, &series, &start, limits, tolerance)?;
        Some(Self {
            error: (best.cost - self.best.cost).abs(),
            series,
            coefficients,
            best,
        })
    }
}

/// The best strokes of a short series from several starts.
pub(super) fn compared(
    geometry: &ShapeGeometry,
    objective: &dyn Objective,
    series: &Series,
    starts: &[Vec<f64>],
    limits: &[(f64, f64)],
) -> Vec<(Vec<f64>, Minimum)> {
    let problem = StrokeProblem::new(geometry, objective, series.clone(), limits);
    (starts.par_iter())
        .filter_map(|start| {
            let start = sized(&problem, objective, series, start);
            let start = inside(series, &start, limits)?;
            problem.solve(&start, limits, COMPARE, COMPARE_ITERATIONS)
        })
        .filter(|(_, minimum)| minimum.violation < COMPARE)
        .collect()
}

/// The stroke scaled to meet the condition of the objective, whose value is taken as proportional
/// to the square of the size.
fn sized(
    problem: &StrokeProblem,
    objective: &dyn Objective,
    series: &Series,
    coefficients: &[f64],
) -> Vec<f64> {
    const ROUNDS: usize = 4;
    let functions = series.functions();
    let has_mean = matches!(series, Series::Closed { .. });
    let mut coefficients = coefficients.to_vec();
    for _ in 0..ROUNDS {
        let stroke = problem.stroke(&coefficients);
        let condition = stroke.and_then(|stroke| objective.condition(&stroke.totals));
        let Some((excess, _)) = condition.filter(|(excess, _)| *excess > -1.0) else {
            break;
        };
        // A step that is too long would leave the table.
        let factor = (1.0 + excess).powf(-0.5).clamp(0.5, 1.5);
        let mut larger = coefficients.clone();
        for c in larger.chunks_mut(functions) {
            c[usize::from(has_mean)..]
                .iter_mut()
                .for_each(|c| *c *= factor);
        }
        if problem.stroke(&larger).is_none() {
            break;
        }
        coefficients = larger;
    }
    coefficients
}

/// The best stroke whose whole curve is inside the limits.
///
/// The search keeps them at the quadrature points; where the curve leaves them between two points,
/// they are narrowed by that much and the search is repeated.
fn solved_inside(
    geometry: &ShapeGeometry,
    objective: &dyn Objective,
    series: &Series,
    start: &[f64],
    limits: &[(f64, f64)],
    tolerance: f64,
) -> Option<(Vec<f64>, Minimum)> {
    const ROUNDS: usize = 10;
    let problem = StrokeProblem::new(geometry, objective, series.clone(), limits);
    let mut narrowed = limits.to_vec();
    let mut coefficients = start.to_vec();
    for round in 0..ROUNDS {
        // Ten per cent more than the excess. The factor grows, because the curve may oscillate
        // between the points.
        let factor = 1.1 + 0.5 * round as f64;
        let inner = inside(series, &coefficients, &narrowed)?;
        let (found, minimum) = problem.solve(&inner, &narrowed, tolerance, MAX_ITERATIONS)?;
        let ranges = ranges(series, &found);
        let mut is_inside = true;
        for ((narrowed, limit), range) in narrowed.iter_mut().zip(limits).zip(&ranges) {
            if range.0 < limit.0 {
                narrowed.0 += factor * (limit.0 - range.0);
                is_inside = false;
            }
            if range.1 > limit.1 {
                narrowed.1 -= factor * (range.1 - limit.1);
                is_inside = false;
            }
        }
        if is_inside {
            return Some((found, minimum));
        }
        coefficients = found;
    }
    None
}

/// Smallest and largest value of each joint on a fine grid of times.
fn ranges(series: &Series, coefficients: &[f64]) -> Vec<(f64, f64)> {
    let count = CHECKS_PER_TERM * series.terms();
    let mut ranges: Vec<(f64, f64)> = Vec::new();
    for k in 0..count {
        let shape = series.shape(coefficients, k as f64 / count as f64);
        ranges.resize(shape.len(), (f64::INFINITY, f64::NEG_INFINITY));
        for (range, x) in ranges.iter_mut().zip(shape) {
            *range = (range.0.min(x), range.1.max(x));
        }
    }
    ranges
}

/// The stroke made smaller until it is strictly inside the limits, except at a fixed start.
pub(super) fn inside(
    series: &Series,
    coefficients: &[f64],
    limits: &[(f64, f64)],
) -> Option<Vec<f64>> {
    const SHRINK: f64 = 0.995;
    const ROUNDS: usize = 400;
    let functions = series.functions();
    let has_mean = matches!(series, Series::Closed { .. });
    let mut coefficients = coefficients.to_vec();
    for _ in 0..ROUNDS {
        let is_inside = |(range, limit): (&(f64, f64), &(f64, f64))| match has_mean {
            true => limit.0 < range.0 && range.1 < limit.1,
            false => limit.0 <= range.0 && range.1 <= limit.1,
        };
        if ranges(series, &coefficients)
            .iter()
            .zip(limits)
            .all(is_inside)
        {
            return Some(coefficients);
        }
        for (joint, c) in coefficients.chunks_mut(functions).enumerate() {
            let middle = 0.5 * (limits[joint].0 + limits[joint].1);
            for (k, c) in c.iter_mut().enumerate() {
                match has_mean && k == 0 {
                    true => *c = middle + SHRINK * (*c - middle),
                    false => *c *= SHRINK,
                }
            }
        }
    }
    None
}
