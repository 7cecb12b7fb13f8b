//! Stokeslets and rotlets in unbounded fluid, the mobility matrices built from them, and the
//! inverses of approximate mobilities.

use std::f64::consts::PI;

use faer::{Mat, Side};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Vector3, Vector6};

use crate::error::{check_entries, check_finite};
use crate::multipole::{self, check_spheres};
use crate::periodic::PeriodicSums;
use crate::{HydroError, Medium, Spheres};

/// Velocity and angular velocity at `r` due to a force `F` and a torque `T` at the origin,
/// viscosity 1.
///
/// With `d = |r|` and `n = r/d`:
/// ```text
/// U = ((1 + s/(3 d²)) I + (1 - s/d²) n n^T) F / (8π d) + T × r / (8π d³)
/// ω = F × r / (8π d³) + (3 n n^T - I) T / (16π d³)
/// ```
/// With `s = 0` these are Oseen's tensor, the rotlet and their vorticities; with `s = a_i² +
/// a_j²` the pair mobility of Rotne, Prager and Yamakawa for radii `a_i` and `a_j`.
pub(crate) fn pair_mobility(r: &Vector3<f64>, s: f64) -> Matrix6<f64> {
    let distance = r.norm();
    let unit = r / distance;
    let (identity, along) = (Matrix3::identity(), unit * unit.transpose());
    let squared = s / (distance * distance);
    let translation =
        (identity * (1.0 + squared / 3.0) + along * (1.0 - squared)) / (8.0 * PI * distance);
    // T x r = -[r] T
    let coupling = -r.cross_matrix() / (8.0 * PI * distance.powi(3));
    let rotation = (along * 3.0 - identity) / (16.0 * PI * distance.powi(3));
    let mut block = Matrix6::zeros();
    block.fixed_view_mut::<3, 3>(0, 0).copy_from(&translation);
    block.fixed_view_mut::<3, 3>(0, 3).copy_from(&coupling);
    block.fixed_view_mut::<3, 3>(3, 0).copy_from(&coupling);
    block.fixed_view_mut::<3, 3>(3, 3).copy_from(&rotation);
    block
}

/// Mobility matrix with lone-sphere diagonal blocks and [`pair_mobility`] elsewhere; `s(a_i, a_j)`
/// gives its parameter.
///
/// # Errors
/// [`HydroError::TooLarge`], [`HydroError::NotFinite`].
pub(crate) fn mobility(
    spheres: &Spheres,
    s: impl Fn(f64, f64) -> f64,
) -> Result<DMatrix<f64>, HydroError> {
    check_spheres(spheres.len())?;
    let all: Vec<usize> = (0..spheres.len()).collect();
    let matrix = block(&all, unbounded(spheres, s));
    check_finite("the mobility of the spheres", &matrix)?;
    Ok(matrix)
}

/// The block of a mobility matrix of some spheres, in their order, from those of one sphere by one.
pub(crate) fn block(
    some: &[usize],
    mobility: impl Fn(usize, usize) -> Matrix6<f64>,
) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(6 * some.len(), 6 * some.len());
    for (i, &at) in some.iter().enumerate() {
        for (j, &of) in some[..=i].iter().enumerate() {
            let pair = mobility(at, of);
            let mut rows = matrix.fixed_view_mut::<6, 6>(6 * i, 6 * j);
            rows.copy_from(&pair);
            let mut columns = matrix.fixed_view_mut::<6, 6>(6 * j, 6 * i);
            columns.copy_from(&pair.transpose());
        }
    }
    matrix
}

/// Mobilities of one sphere by one in unbounded fluid; `s` as in [`mobility`].
pub(crate) fn unbounded<'s>(
    spheres: &'s Spheres,
    s: impl Fn(f64, f64) -> f64 + 's,
) -> impl Fn(usize, usize) -> Matrix6<f64> + 's {
    let (x, a) = (spheres.centres(), spheres.radii());
    move |at, of| match at == of {
        true => Matrix6::from_diagonal(&lone(a[at])),
        false => pair_mobility(&(x[at] - x[of]), s(a[at], a[of])),
    }
}

/// Mobilities of one sphere by one in a periodic box.
pub(crate) fn periodic<'s>(
    spheres: &'s Spheres,
    sums: &'s PeriodicSums,
) -> impl Fn(usize, usize) -> Matrix6<f64> + 's {
    move |at, of| match at == of {
        true => sums.block(at, of) + Matrix6::from_diagonal(&lone(spheres.radii()[at])),
        false => sums.block(at, of),
    }
}

/// Mobility of a lone sphere: three times that of its translation, and of its rotation.
fn lone(a: f64) -> Vector6<f64> {
    let [translation, rotation] = [1.0 / (6.0 * PI * a), 1.0 / (8.0 * PI * a.powi(3))];
    Vector6::from_fn(|k, _| if k < 3 { translation } else { rotation })
}

/// Product of the mobility of spheres and forces, without the matrix.
///
/// `sums` gives the velocities by the forces of all other spheres. Shapes: six entries per sphere.
/// The product does not depend on the number of threads if the sums do not.
///
/// # Errors
/// [`HydroError::Length`], [`HydroError::NotFinite`].
pub(crate) fn apply(
    spheres: &Spheres,
    forces: &DVector<f64>,
    sums: impl FnOnce(&DVector<f64>) -> DVector<f64>,
) -> Result<DVector<f64>, HydroError> {
    check_entries(
        "forces and torques on the spheres",
        6 * spheres.len(),
        forces.len(),
    )?;
    check_finite("a force or torque on a sphere", forces)?;
    let mut product = sums(forces);
    for (k, a) in spheres.radii().iter().enumerate() {
        let mut rows = product.fixed_rows_mut::<6>(6 * k);
        rows += lone(*a).component_mul(&forces.fixed_rows::<6>(6 * k));
    }
    check_finite("a velocity of a sphere", &product)?;
    Ok(product)
}

/// Inverse of an approximate mobility matrix by a Cholesky factorisation, symmetric exactly.
///
/// Cost: `N^3` operations for `N` rows.
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
    match multipole::inverse(&mobility, "mobility") {
        Ok(inverse) if inverse.iter().all(|x| x.is_finite()) => Ok(inverse),
        _ => Err(not_positive_definite(&mobility, spheres, medium, model)),
    }
}

/// The error for an approximate mobility that is not positive definite.
pub(crate) fn not_positive_definite(
    mobility: &DMatrix<f64>,
    spheres: &Spheres,
    medium: &Medium,
    model: &'static str,
) -> HydroError {
    // Scaling to a unit diagonal makes translations and rotations comparable.
    let scaled = Mat::from_fn(mobility.nrows(), mobility.ncols(), |i, j| {
        mobility[(i, j)] / (mobility[(i, i)].abs() * mobility[(j, j)].abs()).sqrt()
    });
    // The eigenvalue iteration does not end for matrices with NaN.
    if !scaled.is_all_finite() {
        return HydroError::NotFinite {
            what: "the mobility of the spheres",
        };
    }
    // In ascending order.
    let eigenvalues = scaled.self_adjoint_eigenvalues(Side::Lower);
    let eigenvalue_ratio = match eigenvalues.as_deref() {
        Ok([lowest, .., highest]) => lowest / highest,
        _ => f64::NAN,
    };
    let (surfaces, gap) = spheres.narrowest_gap(medium);
    HydroError::NotPositiveDefinite {
        model,
        eigenvalue_ratio,
        surfaces,
        gap,
        instead: "multipole expansions",
    }
}
