//! Polygons from which the search for the largest displacement per time starts.

use models::ModelError;

use super::problem::Task;
use crate::error::{DesignError, DesignProgress};
use crate::objective::HighestEfficiency;
use crate::optimise::{FIRST_TERMS, Optimum, SearchOptions, optimise};
use crate::search::{StrokeProblem, inside};
use crate::starts::starts;
use crate::stroke_path::Series;
use crate::timing::{MotionBounds, Timing};

/// Number of corners of the first polygons, in which all starts are compared.
const CORNERS: usize = 16;

/// The stroke of the highest efficiency, with the cost of its motion within all bounds.
pub fn without_rates(
    task: &Task,
    options: &SearchOptions,
    progress: &mut dyn DesignProgress,
) -> Result<Optimum, DesignError> {
    let objective = HighestEfficiency {
        measure: task.measure,
    };
    let found = optimise(task.geometry, &objective, task.limits, options, progress)?;
    let period = Timing::fastest(task.geometry, &found.curve, task.bounds)?.period();
    Ok(Optimum {
        cost: (period / task.measure.of(&found.totals).0).ln(),
        // That of twice the logarithm.
        refinement_error: 0.5 * found.refinement_error,
        ..found
    })
}

/// The cost of a curve without bounds on rates: no stroke has a lower one than the most efficient
/// stroke.
pub fn cost_without_rates(task: &Task, found: &Optimum) -> Result<f64, ModelError> {
    let bounds = MotionBounds {
        rates: vec![f64::INFINITY; task.bounds.rates.len()],
        power: task.bounds.power,
    };
    let period = Timing::fastest(task.geometry, &found.curve, &bounds)?.period();
    Ok((period / task.measure.of(&found.totals).0).ln())
}

/// Corners of the strokes from which to start: the best small ellipses, and the strokes of high
/// efficiency to which these lead; with a bound on the power only the latter.
pub fn first_corners(task: &Task) -> Vec<Vec<Vec<f64>>> {
    let series = Series::new(FIRST_TERMS, task.start);
    let objective = HighestEfficiency {
        measure: task.measure,
    };
    let (geometry, limits) = (task.geometry, task.limits);
    let mut strokes = starts(geometry, &objective, &series, limits);
    let problem = StrokeProblem::new(geometry, &objective, series.clone(), limits);
    let efficient = problem.compared(&strokes);
    if task.bounds.power.is_finite() {
        strokes.clear();
    }
    strokes.extend(efficient.into_iter().map(|(stroke, _)| stroke));
    let corners = |stroke: Vec<f64>| {
        let at = |k: usize| k as f64 / CORNERS as f64;
        (0..CORNERS).map(|k| series.shape(&stroke, at(k))).collect()
    };
    let inner = strokes
        .into_iter()
        .filter_map(|stroke| inside(&series, &stroke, limits));
    inner.map(corners).collect()
}
