//! Polygons without the corners that they do not need.

use models::ModelError;

use super::exact_cost;
use super::polygon::TimedPolygon;
use super::problem::Task;

/// The polygon without corners that it does not need: with a cost of at most `largest_cost`.
pub fn simplified(
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
