//! Cases B, D and E by multipole expansions.

use std::f64::consts::PI;
use std::time::Instant;

use anyhow::Result;
use microhydro::multipole::Accuracy;
use microhydro::{Medium, Spheres, multipole};
use nalgebra::{DMatrix, Vector3};

use super::row::{Basis, Cost, Estimated, Row};
use super::spheres::symmetric;
use super::swimmer;
use crate::reference::{COLLINEAR, INSTANTANEOUS, OPPOSITE_MOTION};

/// Tolerance of resistances, relative to the drag of the spheres.
const TOLERANCE: f64 = 1e-6;

/// Tolerance in scenes for which resistances are expanded to [`TOLERANCE`].
const SCENE_TOLERANCE: f64 = 1e-4;

const PROMISED_BOUND: (f64, Basis) = (TOLERANCE, Basis::Promised);

/// All rows: milliseconds each.
pub fn rows(_: bool) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (distance, exact) in OPPOSITE_MOTION {
        rows.push(opposite(distance, exact)?);
    }
    for case in &COLLINEAR {
        let medium = Medium::Ball {
            centre: Vector3::zeros(),
            radius: case.container,
        };
        let ([found, errors], cost) = axial(case.positions, case.radii, &medium)?;
        let exact = symmetric(case.resistance, case.radii.len());
        let (i, j) = (&found - &exact).icamax_full();
        let name = format!("multipole, {}", case.name);
        let values = [exact[(i, j)], found[(i, j)]];
        let row = Row::scaled("D", name, values, exact.amax(), PROMISED_BOUND, cost);
        rows.push(row.with(Estimated::bound(errors[(i, j)])));
    }
    let model = format!("model = {{ kind = \"multipole\", tolerance = {SCENE_TOLERANCE:e} }}");
    for case in &INSTANTANEOUS {
        let tolerances = [PROMISED_BOUND; 2];
        rows.extend(swimmer::configuration(
            case,
            "multipole",
            &model,
            tolerances,
        )?);
    }
    Ok(rows)
}

/// Force over `6 pi U` on two spheres that move in opposite directions.
fn opposite(distance: f64, exact: f64) -> Result<Row> {
    let places = [-0.5 * distance, 0.5 * distance];
    let ([found, errors], cost) = axial(&places, &[1.0, 1.0], &Medium::Unbounded)?;
    let found = (found[(0, 0)] - found[(0, 1)]) / (6.0 * PI);
    let bound = (errors[(0, 0)] + errors[(0, 1)]) / (6.0 * PI);
    let name = format!("multipole, opposite, s {distance}");
    let row = Row::relative("B", name, [exact, found], PROMISED_BOUND, cost);
    Ok(row.with(Estimated::bound(bound)))
}

/// Axial resistance of spheres on the x axis, and bounds on its errors.
fn axial(positions: &[f64], radii: &[f64], medium: &Medium) -> Result<([DMatrix<f64>; 2], Cost)> {
    let clock = Instant::now();
    let centres = positions.iter().map(|&x| Vector3::new(x, 0.0, 0.0));
    let spheres = Spheres::new(centres.collect(), radii.to_vec())?;
    let found = multipole::resistance(&spheres, medium, &Accuracy::relative(TOLERANCE))?;
    let n = radii.len();
    let along = |full: &DMatrix<f64>| DMatrix::from_fn(n, n, |i, j| full[(6 * i, 6 * j)]);
    let cost = Cost {
        dofs: found.dofs(),
        iterations: 0,
        seconds: clock.elapsed().as_secs_f64(),
    };
    Ok(([along(found.matrix()), along(&found.error())], cost))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_rows_pass() {
        let rows = rows(true).expect("all are computed");
        println!("{}", super::super::summary::table(&rows).markdown());
        assert!(rows.iter().all(Row::passes));
    }
}
