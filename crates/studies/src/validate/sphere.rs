//! Case A: one sphere at the centre of a ball, and the orders of convergence.

use std::f64::consts::PI;

use anyhow::Result;
use nalgebra::Vector3;

use super::effort::Effort;
use super::estimated::Estimated;
use super::expected;
use super::flow::{Sphere, scene, solve};
use super::row::{Basis, Cost, Row};
use super::similar::{self, Geometry, Loads};
use crate::reference::{concentric_drag, concentric_torque};

/// Drag and torque in balls of 10, 5 and 2 radii.
pub fn rows(effort: Effort) -> Result<Vec<Row>> {
    let sizes: &[f64] = match effort {
        Effort::Quick => &[0.4],
        Effort::Full => &[0.4, 0.2],
    };
    let mut rows = Vec::new();
    for lambda in [0.1, 0.2, 0.5] {
        for &size in sizes {
            rows.extend(drag_and_torque(lambda, size)?);
        }
    }
    Ok(rows)
}

/// Drag and torque of a unit sphere with elements of `size`, at the centre of a ball of radius
/// `1 / lambda`.
fn drag_and_torque(lambda: f64, size: f64) -> Result<[Row; 2]> {
    let sphere = Sphere {
        radius: 1.0,
        force: Vector3::x(),
        torque: Vector3::z(),
        ..Sphere::default()
    };
    let (instant, cost) = solve(&scene(1.0 / lambda, size, &[sphere], "")?)?;
    let body = &instant.bodies[0];
    let drag = 1.0 / (6.0 * PI * body.velocity.x);
    let torque = 1.0 / (8.0 * PI * body.angular_velocity.z);
    let of_drag = Estimated::velocity(&instant, 0).times(-drag / body.velocity.x);
    let of_torque = Estimated::angular_velocity(&instant, 0)
        .map(|estimated| estimated.times(-torque / body.angular_velocity.z));
    let expected = expected::sphere(size, lambda)?;
    Ok([
        Row::relative(
            "A",
            format!("drag / 6 pi, lambda {lambda}, h {size}"),
            [concentric_drag(lambda), drag],
            (expected.drag, Basis::Interpolation),
            cost,
        )
        .with(Some(of_drag)),
        Row::relative(
            "A",
            format!("torque / 8 pi, lambda {lambda}, h {size}"),
            [concentric_torque(lambda), torque],
            (expected.torque, Basis::Interpolation),
            cost,
        )
        .with(of_torque),
    ])
}

/// Radius ratio for the orders of convergence.
///
/// The ball is wide enough that the surfaces hardly interact, and narrow enough for fine meshes.
const ORDER_LAMBDA: f64 = 0.25;

/// Observed orders of drag and torque over three similar meshes, curved and straight-sided, before
/// the correction; on curved meshes also those of the answer.
pub fn orders() -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (geometry, uncorrected, corrected) in [
        (Geometry::Curved, (4.0, 0.7), Some((5.0, 1.0))),
        (Geometry::Straight, (2.0, 0.5), None),
    ] {
        let mut cost = Cost::default();
        let mut points = Vec::new();
        for parts in similar::FAMILY {
            let solved = similar::sphere(ORDER_LAMBDA, parts, geometry)?;
            let errors = |loads: Loads| {
                [
                    loads.drag / (6.0 * PI * concentric_drag(ORDER_LAMBDA)) - 1.0,
                    loads.torque / (8.0 * PI * concentric_torque(ORDER_LAMBDA)) - 1.0,
                ]
            };
            let both = [solved.uncorrected, solved.corrected].map(errors);
            points.push((f64::from(parts), both));
            cost.add(&solved.cost);
        }
        let kinds = [("uncorrected", Some(uncorrected)), ("corrected", corrected)];
        for (kind, (of_kind, expected)) in kinds.into_iter().enumerate() {
            let Some((theory, allowed)) = expected else {
                continue;
            };
            for (which, name) in ["drag", "torque"].into_iter().enumerate() {
                let logarithms =
                    (points.iter()).map(|(parts, e)| (parts.ln(), e[kind][which].abs().ln()));
                rows.push(Row::scaled(
                    "order",
                    format!(
                        "{name}, {}, {of_kind}, lambda {ORDER_LAMBDA}",
                        geometry.word()
                    ),
                    [theory, -slope(logarithms)],
                    1.0,
                    (allowed, Basis::Order),
                    cost,
                ));
            }
        }
    }
    Ok(rows)
}

/// Slope of the least-squares line through points.
fn slope(points: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let n = points.clone().count() as f64;
    let (x, y) = points
        .clone()
        .fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let (above, below) = points.fold((0.0, 0.0), |(a, b), (px, py)| {
        (a + (px - x) * (py - y), b + (px - x) * (px - x))
    });
    above / below
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validate::bars::assert_corrected;

    #[test]
    fn drag_and_torque_are_corrected_and_within_their_bars() {
        for row in drag_and_torque(0.25, 0.4).expect("it is solved") {
            assert_corrected(&row);
        }
    }
}
