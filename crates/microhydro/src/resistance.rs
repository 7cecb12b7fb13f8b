//! The grand resistance matrix with its error estimate.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use crate::HydroError;
use crate::error::{check_entries, check_finite};
use crate::multipole::Orders;

/// Grand resistance matrix of spheres and its error estimate.
///
/// Symmetric positive definite, six rows and columns per sphere. Each column holds the forces and
/// torques (about the centres) that the spheres exert on the fluid for a unit velocity or angular
/// velocity of one of them; viscosity 1. The error is estimated from the same matrix computed with
/// expansions of lower order.
#[derive(Clone, Debug, PartialEq)]
pub struct Resistance {
    matrix: DMatrix<f64>,
    coarser: DMatrix<f64>,
    coarser_gaps: Option<DMatrix<f64>>,
    rounded: DMatrix<f64>,
    tail: f64,
    orders: Orders,
    dofs: usize,
}

/// Rounding error of a mobility in units of the mobility of a lone sphere.
///
/// Each entry is a difference of numbers of the size 1 that the elimination of the other modes
/// leaves: a few units in the last place. The error of 6e-4 that was found for a concentric gap of
/// 1e-4 radii, where the resistance is 4/3e12 of that of a lone sphere, is two units; the test
/// `bug_bars_of_concentric_spheres_were_zero_beside_errors` finds less than eight in all gaps.
const MOBILITY_ROUNDING: f64 = 8.0 * f64::EPSILON;

/// What a rounding error of the mobility changes in a resistance: `R M_r R` with the diagonal
/// matrix `M_r` of [`MOBILITY_ROUNDING`] times the mobilities of the lone spheres.
///
/// It grows as the square of the resistance, so that near contact it exceeds all other errors.
fn rounding_of(matrix: &DMatrix<f64>, radii: &[f64]) -> DMatrix<f64> {
    let mut scaled = matrix.clone();
    for (sphere, a) in radii.iter().enumerate() {
        let (drag, torque) = (6.0 * PI * a, 8.0 * PI * a.powi(3));
        let mut rows = scaled.rows_mut(6 * sphere, 3);
        rows *= MOBILITY_ROUNDING / drag;
        let mut rows = scaled.rows_mut(6 * sphere + 3, 3);
        rows *= MOBILITY_ROUNDING / torque;
    }
    matrix * scaled
}

impl Resistance {
    pub(crate) fn new(
        matrix: DMatrix<f64>,
        coarser: DMatrix<f64>,
        tail: f64,
        orders: Orders,
        radii: &[f64],
        dofs: usize,
    ) -> Self {
        Self {
            rounded: &matrix - rounding_of(&matrix, radii),
            matrix,
            coarser,
            coarser_gaps: None,
            tail,
            orders,
            dofs,
        }
    }

    /// The same resistance with the matrix that differs by the estimated error of narrow gaps.
    pub(crate) fn with_coarser_gaps(self, coarser: DMatrix<f64>) -> Self {
        Self {
            coarser_gaps: Some(coarser),
            ..self
        }
    }

    /// Orders of the expansions that were used.
    pub fn orders(&self) -> &Orders {
        &self.orders
    }

    /// Number of degrees of freedom: multipoles of all expansions.
    pub fn dofs(&self) -> usize {
        self.dofs
    }

    /// The resistance matrix.
    pub fn matrix(&self) -> &DMatrix<f64> {
        &self.matrix
    }

    /// Less accurate resistance matrix: from expansions whose orders are lower by two.
    ///
    /// With narrow gaps off an axis it is extrapolated, so that it differs from
    /// [`Resistance::matrix`] by the estimated error. A quantity computed from both matrices has an
    /// error estimate: see [`Resistance::tail`].
    pub fn coarser(&self) -> &DMatrix<f64> {
        &self.coarser
    }

    /// The matrix that differs from [`Resistance::matrix`] by the estimated error of narrow gaps
    /// off an axis, as [`Resistance::coarser`] does too; `None` if nothing was eliminated in gaps.
    ///
    /// Both parts of the error may have opposite signs in a quantity: its error estimate is the
    /// difference by this matrix plus that from this one to [`Resistance::coarser`].
    pub fn coarser_gaps(&self) -> Option<&DMatrix<f64>> {
        self.coarser_gaps.as_ref()
    }

    /// Factor that turns a change of the order into an error estimate.
    ///
    /// The error of a quantity computed from [`Resistance::matrix`] is estimated as this factor
    /// times its difference from the same quantity computed from [`Resistance::coarser`], by way
    /// of [`Resistance::coarser_gaps`] where there is one.
    pub fn tail(&self) -> f64 {
        self.tail
    }

    /// A resistance matrix that differs from [`Resistance::matrix`] by the rounding error.
    ///
    /// The rounding error of a quantity is estimated as its difference from the same quantity
    /// computed from this matrix. It adds to that of [`Resistance::tail`].
    pub fn rounded(&self) -> &DMatrix<f64> {
        &self.rounded
    }

    /// Estimated absolute error of each entry, by truncation and rounding.
    pub fn error(&self) -> DMatrix<f64> {
        let gaps = self.coarser_gaps.as_ref().unwrap_or(&self.matrix);
        (&self.matrix - gaps).abs()
            + (gaps - &self.coarser).abs() * self.tail
            + (&self.matrix - &self.rounded).abs()
    }

    /// Largest estimated error of an entry `R_ij`, relative to `sqrt(R_ii R_jj)`.
    ///
    /// The sum of the largest error by truncation and the largest one by rounding; never zero.
    pub fn relative_error(&self) -> f64 {
        self.truncation_error() + self.relative_difference(&self.rounded)
    }

    /// The part of [`Resistance::relative_error`] that higher orders reduce.
    pub(crate) fn truncation_error(&self) -> f64 {
        let gaps = self.coarser_gaps.as_ref().unwrap_or(&self.matrix);
        let size = self.relative_size(&(gaps - &self.coarser));
        self.relative_difference(gaps) + self.tail * size
    }

    /// Largest difference of an entry from `other`, relative to `sqrt(R_ii R_jj)`.
    ///
    /// Infinite for a matrix of another size or with NaN.
    pub fn relative_difference(&self, other: &DMatrix<f64>) -> f64 {
        if other.shape() != self.matrix.shape() {
            return f64::INFINITY;
        }
        self.relative_size(&(&self.matrix - other))
    }

    /// Largest entry of a difference of resistances, relative to `sqrt(R_ii R_jj)`.
    fn relative_size(&self, difference: &DMatrix<f64>) -> f64 {
        let size = |i: usize| self.matrix[(i, i)].sqrt();
        (0..difference.nrows())
            .flat_map(|i| (0..difference.ncols()).map(move |j| (i, j)))
            .map(|(i, j)| difference[(i, j)].abs() / (size(i) * size(j)))
            // a NaN is not a small difference
            .fold(
                0.0,
                |m, x| if x.is_nan() { f64::INFINITY } else { m.max(x) },
            )
    }

    /// Forces and torques on the fluid for given velocities and angular velocities.
    ///
    /// # Errors
    /// [`HydroError::Length`] if `velocities` does not have six entries per sphere;
    /// [`HydroError::NotFinite`].
    pub fn forces(&self, velocities: &DVector<f64>) -> Result<DVector<f64>, HydroError> {
        let (expected, found) = (self.matrix.ncols(), velocities.len());
        check_entries("velocities of the spheres", expected, found)?;
        let forces = &self.matrix * velocities;
        check_finite("a velocity or a force", &forces)?;
        Ok(forces)
    }
}
