//! Rotne, Prager and Yamakawa: spheres of finite size that do not reflect each other's flow.

use nalgebra::DMatrix;

use crate::{HydroError, Medium, Spheres, inverse, multipole, point};

/// Mobility of spheres after Rotne, Prager and Yamakawa, of any radii, translations and rotations, six rows a sphere, viscosity 1.
///
/// Zuk, Wajnryb, Mizerski & Szymczak (2014), equations for spheres that do not overlap: the mobility for force densities that are uniform,
/// or those of a lone rotating sphere. Positive definite always. Errs by $(a/d)^4$. In a ball and beside a wall it is
/// the same definition with the Green's function that vanishes there: the lowest block of the multipole expansion, before its
/// elimination. Cost: microseconds a pair, in a ball `O(L^3)` a sphere for the order `L` that the container's wall needs.
///
/// # Errors
/// Spheres outside the medium.
///
/// ```
/// use microhydro::{Medium, Spheres, rpy};
/// use nalgebra::Vector3;
/// let pair = Spheres::new(vec![Vector3::zeros(), Vector3::new(4.0, 0.0, 0.0)], vec![1.0; 2])?;
/// let m = rpy::mobility(&pair, &Medium::Unbounded)?;
/// // along the line of centres: 1/(6 pi a) times 3/2 a/d - a^3/d^3
/// assert!((m[(0, 6)] / m[(0, 0)] - (3.0 / 8.0 - 1.0 / 64.0)).abs() < 1e-15);
/// # Ok::<(), microhydro::HydroError>(())
/// ```
pub fn mobility(spheres: &Spheres, medium: &Medium) -> Result<DMatrix<f64>, HydroError> {
    match medium {
        Medium::Unbounded => Ok(point::mobility(spheres, |a, b| a * a + b * b)),
        Medium::Ball { .. } | Medium::Wall { .. } => multipole::rigid_mobility(spheres, medium),
    }
}

/// Grand resistance matrix of the spheres: the inverse of [`mobility`], in the same order of rows.
///
/// # Errors
/// As [`mobility`].
pub fn resistance(spheres: &Spheres, medium: &Medium) -> Result<DMatrix<f64>, HydroError> {
    inverse::resistance(mobility(spheres, medium)?, spheres, medium, "rpy")
}
