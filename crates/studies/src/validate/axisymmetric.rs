//! Cases A, D, E and H by elements in the meridian plane.

use std::f64::consts::PI;
use std::time::Instant;

use anyhow::Result;
use axisymmetric::{AxialSpheroid, Surroundings, axial_resistance};

use super::row::{Basis, Cost, Estimated, Row};
use super::spheres::symmetric;
use super::swimmer;
use crate::reference::{COLLINEAR, CYLINDER, INSTANTANEOUS, SPHEROIDS, STROKES, concentric_drag};

/// Tolerance of the resistances; reaching it takes about ten thousand dofs.
const TOLERANCE: f64 = 1e-6;

/// Tolerance of the net displacement of strokes; resistances are computed to a twentieth of it.
const NET: f64 = 2e-5;

/// All rows.
pub fn rows(quick: bool) -> Result<Vec<Row>> {
    let sphere = [AxialSpheroid::sphere(0.0, 1.0)];
    let of_lambda = |lambda: f64| format!("drag / 6 pi, lambda {lambda}");
    let ball = |radius| Surroundings::Ball { radius };
    let mut drags = Vec::new();
    for lambda in [0.1, 0.2, 0.5] {
        let exact = concentric_drag(lambda);
        drags.push(("A", of_lambda(lambda), sphere, ball(1.0 / lambda), exact));
    }
    for (axial, exact) in SPHEROIDS {
        let body = AxialSpheroid {
            centre: 0.0,
            axial,
            equatorial: 1.0,
        };
        let name = format!("spheroid {axial}:1, drag / 6 pi");
        drags.push(("A", name, [body], Surroundings::Unbounded, exact * axial));
    }
    for (lambda, exact) in CYLINDER {
        let radius = 1.0 / lambda;
        let around = Surroundings::Cylinder { radius };
        drags.push(("H", of_lambda(lambda), sphere, around, exact));
    }
    let mut rows = Vec::new();
    for (group, name, bodies, around, exact) in drags {
        let row = resistance(group, &name, &bodies, around, &[6.0 * PI * exact])?;
        // Drags over that of a unit sphere in unbounded fluid.
        rows.push(row.in_units_of(6.0 * PI));
    }
    for case in &COLLINEAR {
        let places = case.positions.iter().zip(case.radii);
        let bodies: Vec<AxialSpheroid> =
            places.map(|(&z, &a)| AxialSpheroid::sphere(z, a)).collect();
        let around = ball(case.container);
        rows.push(resistance(
            "D",
            case.name,
            &bodies,
            around,
            case.resistance,
        )?);
    }
    let model = format!("model = {{ kind = \"axisymmetric\", tolerance = {NET:e} }}");
    let tolerances = [(TOLERANCE, Basis::Promised); 2];
    for case in &INSTANTANEOUS[..if quick { 2 } else { INSTANTANEOUS.len() }] {
        let rows_of_case = swimmer::configuration(case, "axisymmetric", &model, tolerances)?;
        rows.extend(rows_of_case);
    }
    let options = [
        "model.kind=\"axisymmetric\"".to_owned(),
        format!("model.tolerance={NET:e}"),
    ];
    let tolerances = [(NET, Basis::Promised); 2];
    for case in &STROKES[..if quick { 1 } else { STROKES.len() }] {
        rows.extend(swimmer::stroke(
            case,
            "axisymmetric ",
            &options,
            tolerances,
        )?);
    }
    Ok(rows)
}

/// Entry with the largest error of a resistance matrix, which is given by its upper triangle.
///
/// The error bar of the extrapolated matrix is the estimated error of the matrix itself, an upper
/// bound.
fn resistance(
    group: &'static str,
    name: &str,
    bodies: &[AxialSpheroid],
    surroundings: Surroundings,
    exact: &[f64],
) -> Result<Row> {
    let clock = Instant::now();
    let found = axial_resistance(bodies, surroundings, TOLERANCE)?;
    let cost = Cost {
        dofs: found.dofs(),
        iterations: 0,
        seconds: clock.elapsed().as_secs_f64(),
    };
    let exact = symmetric(exact, bodies.len());
    let (computed, uncorrected) = (found.extrapolated(), found.matrix());
    let (i, j) = (&computed - &exact).icamax_full();
    let scale = (computed[(i, i)] * computed[(j, j)]).sqrt();
    let name = format!("axisymmetric, {name}");
    let values = [exact[(i, j)], computed[(i, j)]];
    let tolerance = (TOLERANCE, Basis::Promised);
    let row = Row::scaled(group, name, values, exact.amax(), tolerance, cost);
    Ok(row.with(Estimated {
        removed: Some(uncorrected[(i, j)] - computed[(i, j)]),
        bar: found.relative_error() * scale,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[ignore = "slow: 15 s"]
    fn all_rows_pass() {
        let rows = rows(true).expect("all are computed");
        println!("{}", super::super::summary::table(&rows).markdown());
        assert!(rows.iter().all(Row::passes));
    }
}
