//! Rotne-Prager-Yamakawa model: spheres of finite size, without reflections between them.
//!
//! The formula for two spheres, shared with the Oseen model, is in `pair_mobility.rs`.

use nalgebra::{DMatrix, DVector};

use crate::error::check_finite;
use crate::pair_sums::Columns;
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

/// Velocities of the spheres for given forces and torques: the product with [`mobility`], without
/// the matrix.
///
/// `forces` has six entries `(F, T)` per sphere, the result six entries `(U, ω)`. Cost for `n`
/// spheres: `O(n²)` operations in parallel and `O(n)` numbers, nanoseconds per pair, tens of
/// microseconds beside a wall; in a ball `O(L³)` more per sphere. From 5000 spheres on what is in
/// unbounded fluid is `O(n)` by a fast multipole method, to about 1e-5 of the largest velocity. The
/// result is the same for any number of threads.
///
/// # Errors
/// Spheres outside the medium; [`HydroError::Length`]; [`HydroError::NotFinite`].
///
/// ```
/// use microhydro::{Medium, Spheres, rpy};
/// use nalgebra::{DVector, Vector3};
/// let centres = (0..2000).map(|k| Vector3::x() * 3.0 * k as f64).collect();
/// let chain = Spheres::new(centres, vec![1.0; 2000])?;
/// let mut forces = DVector::zeros(12_000);
/// forces[0] = 6.0 * std::f64::consts::PI; // of the first sphere, along the chain
/// let velocities = rpy::apply(&chain, &Medium::Unbounded, &forces)?;
/// // the second one moves with 3/2 a/d - a^3/d^3 of the first
/// assert!((velocities[0] - 1.0).abs() < 1e-15);
/// assert!((velocities[6] - (0.5 - 1.0 / 27.0)).abs() < 1e-15);
/// # Ok::<(), microhydro::HydroError>(())
/// ```
pub fn apply(
    spheres: &Spheres,
    medium: &Medium,
    forces: &DVector<f64>,
) -> Result<DVector<f64>, HydroError> {
    spheres.check_inside(medium)?;
    let velocities = pair_mobility::apply(spheres, forces, |f| columns(spheres).velocities(f))?;
    match medium {
        Medium::Unbounded => Ok(velocities),
        Medium::Ball { .. } | Medium::Wall { .. } => {
            let all = velocities + multipole::boundary_product(spheres, medium, forces);
            check_finite("a velocity of a sphere", &all)?;
            Ok(all)
        }
    }
}

/// The spheres with their radii.
pub(crate) fn columns(spheres: &Spheres) -> Columns {
    Columns::new(spheres.centres(), spheres.radii().iter().copied())
}

/// Grand resistance matrix of the spheres: the inverse of [`mobility`], in the same order of rows.
///
/// Cost: a Cholesky factorisation and inversion, `(6n)^3` operations.
///
/// # Errors
/// As [`mobility`].
pub fn resistance(spheres: &Spheres, medium: &Medium) -> Result<DMatrix<f64>, HydroError> {
    pair_mobility::resistance(mobility(spheres, medium)?, spheres, medium, "rpy")
}
