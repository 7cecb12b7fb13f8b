//! Resistance matrices from approximate mobilities.

use nalgebra::DMatrix;

use crate::{HydroError, Medium, Spheres};

/// Inverse of an approximate mobility matrix by a Cholesky factorisation.
///
/// # Errors
/// [`HydroError::NotPositiveDefinite`] with the narrowest gap of the spheres;
/// [`HydroError::NotFinite`] for a mobility with NaN or infinite entries.
pub(crate) fn resistance(
    mobility: DMatrix<f64>,
    spheres: &Spheres,
    medium: &Medium,
    model: &'static str,
) -> Result<DMatrix<f64>, HydroError> {
    let factor = mobility.clone().cholesky();
    match factor.map(|factor| factor.inverse()) {
        Some(inverse) if inverse.iter().all(|x| x.is_finite()) => Ok(inverse),
        _ => Err(not_positive_definite(&mobility, spheres, medium, model)),
    }
}

fn not_positive_definite(
    mobility: &DMatrix<f64>,
    spheres: &Spheres,
    medium: &Medium,
    model: &'static str,
) -> HydroError {
    // Scaling to a unit diagonal makes translations and rotations comparable.
    let scaled = DMatrix::from_fn(mobility.nrows(), mobility.ncols(), |i, j| {
        mobility[(i, j)] / (mobility[(i, i)].abs() * mobility[(j, j)].abs()).sqrt()
    });
    // The eigenvalue iteration does not end for matrices with NaN.
    if !scaled.iter().all(|x| x.is_finite()) {
        return HydroError::NotFinite {
            what: "the mobility of the spheres",
        };
    }
    let eigenvalues = scaled.symmetric_eigenvalues();
    let (surfaces, gap) = spheres.narrowest_gap(medium);
    HydroError::NotPositiveDefinite {
        model,
        eigenvalue_ratio: eigenvalues.min() / eigenvalues.max(),
        surfaces,
        gap,
        instead: "multipole expansions",
    }
}
