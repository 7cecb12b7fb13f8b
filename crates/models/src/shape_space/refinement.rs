//! Degrees of successive grids of a table.

use super::sampler::MAX_DEGREE;

/// Degree of the first grid in each variable.
pub const FIRST_DEGREE: usize = 4;

/// Maximum number of grid points: degree 8 in four variables has 6561, degree 4 in five 3125.
///
/// Larger tables take longer than they save.
const MAX_POINTS: usize = 7000;

/// Degrees of the grid after one with these sums of highest coefficients, [`Interpolant::tails`].
///
/// The degree is doubled in the variables with more than half of an equal share of the error
/// `wanted`.
///
/// [`Interpolant::tails`]: super::chebyshev::Interpolant::tails
pub fn refined(degrees: &[usize], tails: &[f64], wanted: f64) -> Vec<usize> {
    let share = 0.5 * wanted / tails.len() as f64;
    (degrees.iter().zip(tails))
        .map(|(&degree, &tail)| if tail > share { 2 * degree } else { degree })
        .collect()
}

/// Whether a grid is small enough to be computed.
pub fn fits(degrees: &[usize]) -> bool {
    points(degrees) <= MAX_POINTS && degrees.iter().all(|&n| n <= MAX_DEGREE)
}

/// Number of points of a grid.
pub fn points(degrees: &[usize]) -> usize {
    degrees.iter().map(|n| n + 1).product()
}
