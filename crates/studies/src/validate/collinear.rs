//! D: spheres on a diameter of a ball, their axial resistance matrices.

use anyhow::Result;
use nalgebra::DMatrix;

use super::effort::Effort;
use super::estimated::Estimated;
use super::expected;
use super::flow::{Sphere, axial_resistance};
use super::row::{Basis, Row};
use crate::reference::{COLLINEAR, Collinear};

/// The entry with the largest error of each matrix, relative to the largest entry.
pub fn rows(effort: Effort) -> Result<Vec<Row>> {
    let size = match effort {
        Effort::Quick => 0.4,
        Effort::Full => 0.25,
    };
    COLLINEAR.iter().map(|case| row(case, size)).collect()
}

fn row(case: &Collinear, size: f64) -> Result<Row> {
    let spheres: Vec<Sphere> = case
        .positions
        .iter()
        .zip(case.radii)
        .map(|(&position, &radius)| Sphere {
            position,
            radius,
            ..Sphere::default()
        })
        .collect();
    let exact = symmetric(case.resistance, spheres.len());
    let found = axial_resistance(case.container, size, &spheres)?;
    let (i, j) = (&found.matrix - &exact).icamax_full();
    Ok(Row::scaled(
        "D",
        format!("{}: R{}{}, h {size}", case.name, i + 1, j + 1),
        [exact[(i, j)], found.matrix[(i, j)]],
        exact.amax(),
        (tolerance(case, size)?, Basis::Interpolation),
        found.cost,
    )
    .with(Some(Estimated {
        removed: Some(found.removed[(i, j)]),
        bar: found.bars[(i, j)],
    })))
}

/// Largest tolerance over the spheres, each taken at the centre of a ball that touches the wall at
/// its nearest point.
///
/// Errors of a resistance matrix are a scalar product, so those of off-diagonal entries are not
/// larger than those of diagonal entries (Cauchy & Schwarz).
fn tolerance(case: &Collinear, size: f64) -> Result<f64> {
    let mut worst = 0.0_f64;
    for (position, radius) in case.positions.iter().zip(case.radii) {
        let to_wall = case.container - position.abs();
        worst = worst.max(expected::sphere(size / radius, radius / to_wall)?.drag);
    }
    Ok(worst)
}

/// Symmetric matrix from the rows of its upper triangle.
pub fn symmetric(upper: &[f64], n: usize) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(n, n);
    let places = (0..n).flat_map(|i| (i..n).map(move |j| (i, j)));
    for ((i, j), &value) in places.zip(upper) {
        matrix[(i, j)] = value;
        matrix[(j, i)] = value;
    }
    matrix
}
