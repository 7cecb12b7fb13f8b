//! The objective along lines through the best sizes, for charts.

use std::ops::Range;

use scene::Scene;

use super::shares::SizeSpace;
use super::{BestSizes, Search};
use crate::error::{DesignError, DesignProgress};

/// Number of sizes per line beside the best one.
const POINTS_PER_LINE: usize = 7;

/// Number of bisections of the range of a line; its ends then are exact to `2^-30` of it.
const BISECTIONS: usize = 30;

/// The objective for values of one size. The other sizes of its kind keep their ratios, and change
/// with it such that their sum stays.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SizeSlice {
    /// Number of the size in [`BestSizes::parameters`].
    pub parameter: usize,
    /// Increasing values, the best one among them.
    pub values: Vec<f64>,
    /// The objective for each value.
    pub objectives: Vec<f64>,
    /// Error bars of the objective.
    pub errors: Vec<f64>,
    /// Position of the best value.
    pub best: usize,
}

/// Runs a scene with sizes on lines through the best ones, within the limits.
///
/// One line per size; of two sizes with a constant sum, one line for the first. Cost: eight runs
/// per line.
///
/// # Errors
/// Those of [`super::best_sizes`].
pub fn size_slices(
    scene: &Scene,
    found: &BestSizes,
    progress: &mut dyn DesignProgress,
) -> Result<Vec<SizeSlice>, DesignError> {
    let mut search = Search::new(scene, progress)?;
    let space = search.space.clone();
    search.progress.begins("running sizes around the best ones");
    let best = space.shares(&found.values);
    let mut slices = Vec::new();
    let lines = |group: &Range<usize>| match group.len() {
        2 => 1,
        count => count,
    };
    let all = space.groups().map(|group| lines(&group)).sum();
    search.progress.counted("lines of sizes", 0, all);
    for group in space.groups() {
        let lines = lines(&group);
        for parameter in group.start..group.start + lines {
            let (values, position) = values(&space, &best, parameter);
            let points: Vec<Vec<f64>> = (values.iter())
                .map(|value| space.with_value(&best, parameter, *value))
                .collect();
            let runs = search.costs(&points)?;
            slices.push(SizeSlice {
                parameter,
                values,
                objectives: runs.iter().map(|run| run.objective).collect(),
                errors: runs.iter().map(|run| run.error).collect(),
                best: position,
            });
            search.progress.counted("lines of sizes", slices.len(), all);
        }
    }
    Ok(slices)
}

/// Values of a size in equal steps between its limits, with the best one, and the position of that.
fn values(space: &SizeSpace, best: &[f64], parameter: usize) -> (Vec<f64>, usize) {
    let at_best = space.values(best)[parameter];
    let limits = space.limits()[parameter];
    // The value farthest from the best one up to which all limits hold.
    let end = |limit: f64| {
        let (mut inside, mut outside) = (at_best, limit);
        if space.is_allowed(&space.with_value(best, parameter, limit)) {
            return limit;
        }
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (inside + outside);
            match space.is_allowed(&space.with_value(best, parameter, middle)) {
                true => inside = middle,
                false => outside = middle,
            }
        }
        inside
    };
    let (low, high) = (end(limits.0), end(limits.1));
    let step = (high - low) / (POINTS_PER_LINE - 1) as f64;
    // One run is enough for two values of almost the same size.
    let mut values: Vec<f64> = (0..POINTS_PER_LINE)
        .map(|k| low + step * k as f64)
        .filter(|value| (value - at_best).abs() > 0.25 * step)
        .collect();
    let position = values.partition_point(|value| *value < at_best);
    values.insert(position, at_best);
    (values, position)
}
