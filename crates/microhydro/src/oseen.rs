//! Point-force model: each sphere has the drag of a lone sphere and acts on the others as a point.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::pair_sums::Columns;
use crate::{HydroError, Medium, Spheres, pair_mobility, wall};

/// Mobility matrix of spheres that interact as point forces and point torques.
///
/// The pair blocks are Oseen's tensor, the rotlet and their vorticities; the diagonal blocks are
/// the mobility of a lone sphere. Six rows per sphere: velocity, then angular velocity; viscosity
/// 1. Beside a wall, the image system of Blake (1971) is added.
///
/// For radius `a` and distance `d` the relative error is of the order `(a/d)^3`; the matrix may be
/// indefinite for spheres closer than a few radii. Cost: microseconds per pair.
///
/// # Errors
/// Spheres outside the medium; a container, which this model does not support.
///
/// ```
/// use microhydro::{Medium, Spheres, oseen};
/// use nalgebra::Vector3;
/// let pair = Spheres::new(vec![Vector3::zeros(), Vector3::new(4.0, 0.0, 0.0)], vec![1.0; 2])?;
/// let m = oseen::mobility(&pair, &Medium::Unbounded)?;
/// // along the line of centres: 1/(6 pi a) and 1/(4 pi d)
/// assert!((m[(0, 6)] / m[(0, 0)] - 6.0 / 16.0).abs() < 1e-15);
/// # Ok::<(), microhydro::HydroError>(())
/// ```
pub fn mobility(spheres: &Spheres, medium: &Medium) -> Result<DMatrix<f64>, HydroError> {
    spheres.check_inside(medium)?;
    let mut matrix = pair_mobility::mobility(spheres, |_, _| 0.0)?;
    match medium {
        Medium::Unbounded => Ok(matrix),
        Medium::Wall { point, normal } => {
            let x = spheres.centres();
            for i in 0..x.len() {
                for j in 0..x.len() {
                    let image = wall::image(&x[i], &x[j], point, normal)?;
                    let mut block = matrix.fixed_view_mut::<6, 6>(6 * i, 6 * j);
                    block += image;
                }
            }
            Ok(matrix)
        }
        Medium::Ball { .. } => Err(BALL),
    }
}

/// The spheres as points.
pub(crate) fn columns(spheres: &Spheres) -> Columns {
    Columns::new(spheres.centres(), spheres.radii().iter().map(|_| 0.0))
}

/// The error for a container.
const BALL: HydroError = HydroError::Unsupported {
    model: "oseen",
    medium: "ball",
    instead: "rpy or multipole",
};

/// Velocities of the spheres for given forces and torques: the product with [`mobility`], without
/// the matrix.
///
/// `forces` has six entries `(F, T)` per sphere, the result six entries `(U, ω)`. Cost for `n`
/// spheres: `O(n²)` operations in parallel and `O(n)` numbers, as for [`crate::rpy::apply`] `O(n)`
/// for many spheres. The result is the same for any number of threads.
///
/// # Errors
/// As [`mobility`]; [`HydroError::Length`]; [`HydroError::NotFinite`].
pub fn apply(
    spheres: &Spheres,
    medium: &Medium,
    forces: &DVector<f64>,
) -> Result<DVector<f64>, HydroError> {
    spheres.check_inside(medium)?;
    let mut velocities = pair_mobility::apply(spheres, forces, |f| columns(spheres).velocities(f))?;
    match medium {
        Medium::Unbounded => Ok(velocities),
        Medium::Wall { point, normal } => {
            let x = spheres.centres();
            let rows = velocities.as_mut_slice().par_chunks_mut(6).enumerate();
            rows.map(|(i, rows)| {
                for (j, source) in x.iter().enumerate() {
                    let image = wall::image(&x[i], source, point, normal)?;
                    let added = image * forces.fixed_rows::<6>(6 * j);
                    rows.iter_mut().zip(&added).for_each(|(u, v)| *u += v);
                }
                Ok(())
            })
            .collect::<Result<(), HydroError>>()?;
            Ok(velocities)
        }
        Medium::Ball { .. } => Err(BALL),
    }
}

/// Grand resistance matrix of the spheres: the inverse of [`mobility`], in the same order of rows.
///
/// # Errors
/// As [`mobility`]; [`HydroError::NotPositiveDefinite`] for spheres too close for point forces.
pub fn resistance(spheres: &Spheres, medium: &Medium) -> Result<DMatrix<f64>, HydroError> {
    pair_mobility::resistance(mobility(spheres, medium)?, spheres, medium, "oseen")
}
