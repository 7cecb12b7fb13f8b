//! The stroke of the largest displacement per time within bounds on rates and power.
//!
//! With bounds on the rates of two joints the best curve is a polygon. The maximum principle has
//! the switching functions `σ_i = A_i + p_i` along the displacement, with `σ_1' = -F q_2'` and
//! `σ_2' = F q_1'`: where the curvature `F` is not zero and no limit is active, none of them
//! vanishes for a time, so that both joints move at their largest rates. A side is along a limit,
//! or in the direction `(±v_1, ±v_2)`. The search therefore is over polygons, with the time of each
//! side as a variable; bounds on rates then are linear. Curves that are no polygons, of more joints
//! or with a bound on the power, are approximated by more and more corners.

mod first;
mod polygon;
mod problem;
mod rows;

use models::{ModelError, ShapeGeometry};
use rayon::prelude::*;

use self::first::{cost_without_rates, first_corners, without_rates};
use self::polygon::{TimedPolygon, path};
use self::problem::{SpeedProblem, Task};
use super::interior_point::Minimum;
use super::objective::DisplacementMeasure;
use super::optimise::{Optimum, SearchOptions};
use super::timing::{MotionBounds, Timing};
use super::totals::Stroke;
use crate::error::{DesignError, DesignProgress, check_interruption};

/// Predicted decrease of the cost at which a search ends, relative to the tolerance of refinement.
const SEARCH_SHARE: f64 = 0.01;

/// The same with a bound on the power, where a search takes more iterations.
const SEARCH_SHARE_WITH_POWER: f64 = 0.1;

/// Predicted decrease at which the starts are compared.
const COMPARE_DECREASE: f64 = 1e-3;

/// Largest number of iterations in which the starts are compared.
const COMPARE_ITERATIONS: usize = 40;

/// Largest number of iterations of a refined search.
const MAX_ITERATIONS: usize = 200;

/// Part of the distance to the middle of the limits by which a polygon is moved before a search.
const INWARD_SHIFT: f64 = 0.01;

/// Factor on the shortest times of the sides before a search.
const SLOWDOWN: f64 = 1.05;

/// Largest number of searches with split corners.
const MAX_SPLITS: usize = 4;

/// Searches for the stroke of the largest displacement per time inside `limits`, one range per
/// joint of the table, with the rates and the power within `bounds`.
///
/// The cost of the optimum is `log(T / Δ)` with the displacement `Δ` and the period `T` of
/// [`Timing::fastest`].
///
/// With a bound on the power alone `T` is proportional to the length in the dissipation metric, so
/// that the stroke is the one of the highest efficiency. It is the answer too if it keeps bounds on
/// rates. Otherwise the stroke is a polygon, with at most twice as many corners as `options.terms`.
///
/// # Errors
/// [`DesignError::NoStroke`] if no start leads to a stroke, [`DesignError::Stopped`].
pub fn fastest_stroke(
    geometry: &ShapeGeometry,
    measure: DisplacementMeasure,
    (limits, bounds): (&[(f64, f64)], &MotionBounds),
    options: &SearchOptions,
    progress: &mut dyn DesignProgress,
) -> Result<Optimum, DesignError> {
    let task = Task {
        geometry,
        measure,
        limits,
        bounds,
        start: options.start.as_deref(),
    };
    let mut iterations = 0;
    if bounds.power.is_finite() {
        let unlimited = without_rates(&task, options, progress)?;
        if unlimited.cost
            <= cost_without_rates(&task, &unlimited)? + SEARCH_SHARE * options.tolerance
        {
            return Ok(unlimited);
        }
        iterations += unlimited.iterations;
    }
    let firsts = first_corners(&task);
    progress.begins(&format!("searching from {} strokes", firsts.len()));
    let found: Vec<(TimedPolygon, Minimum)> = (firsts.par_iter())
        .filter_map(|corners| {
            let first = TimedPolygon::fastest(geometry, corners.clone(), bounds).ok()?;
            solved(&task, &first, COMPARE_DECREASE, COMPARE_ITERATIONS)
        })
        .collect();
    let counts = found.iter().map(|(_, minimum)| minimum.iterations);
    iterations += counts.sum::<usize>();
    // The first of equal ones, so that the result does not depend on the number of threads.
    let best = (found.into_iter()).reduce(|a, b| if b.1.cost < a.1.cost { b } else { a });
    let Some((first, _)) = best else {
        return Err(DesignError::no_stroke(
            "no stroke inside the limits has a displacement; widen optimise.lower and \
             optimise.upper, or change optimise.direction",
        ));
    };
    let smallest = options.tolerance
        * match bounds.power.is_finite() {
            true => SEARCH_SHARE_WITH_POWER,
            false => SEARCH_SHARE,
        };
    let mut found = Found {
        polygon: first,
        cost: f64::INFINITY,
        iterations,
    };
    let refinement_error = found.refine(&task, options, smallest, progress)?;
    found.split_corners(&task, smallest)?;
    let polygon = found.polygon;
    let stroke = Stroke::along(geometry, &path(&polygon.corners))?;
    Ok(Optimum {
        totals: stroke.totals,
        period_energy_product: stroke.length.powi(2),
        cost: exact_cost(&task, &polygon)?,
        refinement_error,
        at_limits: is_at_limits(&task, &polygon),
        starts: firsts.len(),
        iterations: found.iterations,
        curve: polygon.curve(),
    })
}

/// The best polygon so far.
struct Found {
    polygon: TimedPolygon,
    cost: f64,
    iterations: usize,
}

impl Found {
    /// Searches with more and more corners; returns the change of the cost by the last ones.
    fn refine(
        &mut self,
        task: &Task,
        options: &SearchOptions,
        smallest: f64,
        progress: &mut dyn DesignProgress,
    ) -> Result<f64, DesignError> {
        loop {
            let count = self.polygon.corners.len();
            check_interruption(progress, || format!("a stroke with {count} corners"))?;
            progress.begins(&format!("{count} corners"));
            let found = solved(task, &self.polygon, smallest, MAX_ITERATIONS);
            let (refined, minimum) = found.ok_or_else(|| {
                DesignError::no_stroke(format!(
                    "the search with {count} corners has no start inside the limits"
                ))
            })?;
            self.iterations += minimum.iterations;
            let reached = exact_cost(task, &refined)?;
            let error = (self.cost - reached).abs().max(minimum.decrease);
            (self.polygon, self.cost) = (refined, reached);
            if error <= options.tolerance || count >= 2 * options.terms {
                return Ok(error);
            }
            self.polygon = self.polygon.halved();
        }
    }

    /// Removes corners without need, and searches again with two corners in place of each: a short
    /// side along a limit that the search has missed begins as two corners of one place.
    fn split_corners(&mut self, task: &Task, smallest: f64) -> Result<(), ModelError> {
        let searched = self.polygon.corners.len();
        self.polygon = simplified(task, self.polygon.clone(), self.cost + smallest)?;
        for _ in 0..MAX_SPLITS {
            let split = self.polygon.split(task.start.is_some());
            if split.corners.len() > searched {
                break;
            }
            let Some((refined, minimum)) = solved(task, &split, smallest, MAX_ITERATIONS) else {
                break;
            };
            self.iterations += minimum.iterations;
            let gained = self.cost - exact_cost(task, &refined)?;
            if gained > 0.0 {
                self.cost -= gained;
                self.polygon = simplified(task, refined, self.cost + smallest)?;
            }
            if gained <= smallest {
                break;
            }
        }
        Ok(())
    }
}

/// The best polygon from one that is inside the limits or on them.
fn solved(
    task: &Task,
    first: &TimedPolygon,
    tolerance: f64,
    max_iterations: usize,
) -> Option<(TimedPolygon, Minimum)> {
    let middle: Vec<f64> = match task.start {
        Some(start) => start.to_vec(),
        None => task.limits.iter().map(|r| 0.5 * (r.0 + r.1)).collect(),
    };
    let inner = first.moved_towards(&middle, INWARD_SHIFT);
    let mut inner = TimedPolygon::fastest(task.geometry, inner.corners, task.bounds).ok()?;
    // Sides of no length have a time too.
    let mean = inner.period() / inner.durations.len() as f64;
    for time in &mut inner.durations {
        *time = (SLOWDOWN * *time).max(0.1 * mean);
    }
    SpeedProblem::new(*task, &inner).solve(&inner, tolerance, max_iterations)
}

/// `log(T / Δ)` with the period of the fastest motion along the polygon.
fn exact_cost(task: &Task, polygon: &TimedPolygon) -> Result<f64, ModelError> {
    let stroke = Stroke::along(task.geometry, &path(&polygon.corners))?;
    let timing = Timing::fastest(task.geometry, &polygon.curve(), task.bounds)?;
    Ok((timing.period() / task.measure.of(&stroke.totals).0).ln())
}

/// Whether a corner is at a limit.
fn is_at_limits(task: &Task, polygon: &TimedPolygon) -> bool {
    /// Distance from a limit, relative to the range, below which it counts as active.
    const ACTIVE_DISTANCE: f64 = 1e-3;
    polygon.corners.iter().any(|corner| {
        let mut pairs = corner.iter().zip(task.limits);
        pairs.any(|(x, range)| {
            (x - range.0).min(range.1 - x) < ACTIVE_DISTANCE * (range.1 - range.0)
        })
    })
}

/// The polygon without corners that it does not need: with a cost of at most `largest_cost`.
fn simplified(
    task: &Task,
    polygon: TimedPolygon,
    largest_cost: f64,
) -> Result<TimedPolygon, ModelError> {
    let mut polygon = polygon;
    let first = usize::from(task.start.is_some());
    loop {
        let count = polygon.corners.len();
        let mut order: Vec<(f64, usize)> = (first..count)
            .map(|k| (deviation(task, &polygon.corners, k), k))
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, corner)) = order.first().filter(|_| count > 3) else {
            return Ok(polygon);
        };
        let mut corners = polygon.corners.clone();
        corners.remove(*corner);
        let simpler = TimedPolygon::fastest(task.geometry, corners, task.bounds)?;
        let cost = exact_cost(task, &simpler)?;
        if cost.is_nan() || cost > largest_cost {
            return Ok(polygon);
        }
        polygon = simpler;
    }
}

/// Distance of a corner from the line between its neighbours, in units of the ranges.
fn deviation(task: &Task, corners: &[Vec<f64>], k: usize) -> f64 {
    let count = corners.len();
    let scaled = |k: usize| -> Vec<f64> {
        let pairs = corners[k % count].iter().zip(task.limits);
        pairs.map(|(x, range)| x / (range.1 - range.0)).collect()
    };
    let (before, here, after) = (scaled(k + count - 1), scaled(k), scaled(k + 1));
    let along: Vec<f64> = after.iter().zip(&before).map(|(a, b)| a - b).collect();
    let arm: Vec<f64> = here.iter().zip(&before).map(|(a, b)| a - b).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let length = dot(&along, &along);
    let share = match length > 0.0 {
        true => (dot(&along, &arm) / length).clamp(0.0, 1.0),
        false => 0.0,
    };
    let off: Vec<f64> = arm.iter().zip(&along).map(|(a, b)| a - share * b).collect();
    dot(&off, &off).sqrt()
}
