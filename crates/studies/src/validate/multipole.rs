//! Cases B, D and E by multipole expansions.

use std::f64::consts::PI;
use std::time::Instant;

use anyhow::Result;
use microhydro::multipole::Accuracy;
use microhydro::{Medium, Spheres, multipole};
use nalgebra::{DMatrix, Vector3};

use super::collinear::symmetric;
use super::estimated::Estimated;
use super::row::{Basis, Cost, Row};
use super::swimmer;
use crate::reference::{COLLINEAR, INSTANTANEOUS, OPPOSITE};

/// Tolerance of resistances, relative to the drag of the spheres.
const TOLERANCE: f64 = 1e-6;

/// Tolerance in scenes for which resistances are expanded to [`TOLERANCE`].
const SCENE_TOLERANCE: f64 = 1e-4;

/// All rows: milliseconds each.
pub fn rows() -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (distance, exact) in OPPOSITE {
        rows.push(opposite(distance, exact)?);
    }
    for case in &COLLINEAR {
        let (found, cost) = axial(
            case.positions,
            case.radii,
            &Medium::Ball {
                centre: Vector3::zeros(),
                radius: case.container,
            },
        )?;
        let exact = symmetric(case.resistance, case.radii.len());
        let (i, j) = (&found.matrix - &exact).icamax_full();
        rows.push(
            Row::scaled(
                "D",
                format!("multipole, {}", case.name),
                [exact[(i, j)], found.matrix[(i, j)]],
                exact.amax(),
                (TOLERANCE, Basis::Promised),
                cost,
            )
            .with(Some(Estimated::bound(found.errors[(i, j)]))),
        );
    }
    let model = format!("model = {{ kind = \"multipole\", tolerance = {SCENE_TOLERANCE:e} }}");
    for case in &INSTANTANEOUS {
        let tolerances = [(TOLERANCE, Basis::Promised); 2];
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
    let (found, cost) = axial(&places, &[1.0, 1.0], &Medium::Unbounded)?;
    let of = |matrix: &DMatrix<f64>| (matrix[(0, 0)] - matrix[(0, 1)]) / (6.0 * PI);
    let bound = (found.errors[(0, 0)] + found.errors[(0, 1)]) / (6.0 * PI);
    let name = format!("multipole, opposite, s {distance}");
    let pair = [exact, of(&found.matrix)];
    Ok(
        Row::relative("B", name, pair, (TOLERANCE, Basis::Promised), cost)
            .with(Some(Estimated::bound(bound))),
    )
}

/// Axial resistance of spheres on the x axis, with bounds on its errors.
struct Axial {
    matrix: DMatrix<f64>,
    errors: DMatrix<f64>,
}

fn axial(positions: &[f64], radii: &[f64], medium: &Medium) -> Result<(Axial, Cost)> {
    let clock = Instant::now();
    let centres = positions.iter().map(|&x| Vector3::new(x, 0.0, 0.0));
    let spheres = Spheres::new(centres.collect(), radii.to_vec())?;
    let found = multipole::resistance(&spheres, medium, &Accuracy::relative(TOLERANCE))?;
    let n = radii.len();
    let along = |full: &DMatrix<f64>| DMatrix::from_fn(n, n, |i, j| full[(6 * i, 6 * j)]);
    let axial = Axial {
        matrix: along(found.matrix()),
        errors: along(&found.error()),
    };
    let cost = Cost {
        dofs: found.dofs(),
        iterations: 0,
        seconds: clock.elapsed().as_secs_f64(),
    };
    Ok((axial, cost))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_rows_pass() {
        let rows = rows().expect("all are computed");
        println!("{}", super::super::table::markdown(&rows, &[]));
        assert!(rows.iter().all(Row::passes));
    }
}
