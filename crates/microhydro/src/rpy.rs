//! Rotne-Prager-Yamakawa model: spheres of finite size, without reflections between them.
//!
//! The formula for two spheres, shared with the Oseen model, is in `pair_mobility.rs`.

use nalgebra::DMatrix;

use crate::{HydroError, Medium, Spheres, multipole, pair_mobility};

/// Rotne-Prager-Yamakawa mobility matrix of spheres of any radii.
///
/// Translation and rotation, six rows per sphere (velocity, then angular velocity), viscosity 1,
/// after Zuk, Wajnryb, Mizerski & Szymczak (2014), the equations for spheres that do not overlap.
/// It is the mobility for prescribed force densities: uniform ones for forces, those of a lone
/// rotating sphere for torques. It is always positive definite, and its relative error is of the
/// order `(a/d)^4` for radius `a` and distance `d`.
///
/// In a ball and beside a wall the definition is the same with the Green's function that vanishes
/// on the boundary. It is computed as the rigid-motion block of the multipole system, with the
/// container's wall eliminated and no other multipole. Cost: microseconds per pair; in a ball
/// `O(L^3)` per sphere for the order `L` that the container's wall needs.
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
        Medium::Unbounded => {
            spheres.check_inside(medium)?;
            pair_mobility::mobility(spheres, |a, b| a * a + b * b)
        }
        Medium::Ball { .. } | Medium::Wall { .. } => multipole::rigid_mobility(spheres, medium),
    }
}

/// Grand resistance matrix of the spheres: the inverse of [`mobility`], in the same order of rows.
///
/// # Errors
/// As [`mobility`].
pub fn resistance(spheres: &Spheres, medium: &Medium) -> Result<DMatrix<f64>, HydroError> {
    pair_mobility::resistance(mobility(spheres, medium)?, spheres, medium, "rpy")
}
