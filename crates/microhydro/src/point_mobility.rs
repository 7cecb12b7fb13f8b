//! Mobilities of point forces as operators, for arrangements of thousands of spheres.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use crate::pair_sums::Columns;
use crate::{HydroError, Medium, Spheres, oseen, pair_mobility, rpy};

/// A model of spheres that act on each other as forces and torques alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointModel {
    /// Point forces ([`oseen`](crate::oseen)).
    Oseen,
    /// Rotne-Prager-Yamakawa ([`rpy`](crate::rpy)).
    Rpy,
}

/// The mobility of spheres by a model of point forces, without a matrix in unbounded fluid.
///
/// In a ball and beside a wall the matrix is computed once.
pub struct PointMobility<'a> {
    model: PointModel,
    spheres: &'a Spheres,
    medium: Medium,
    columns: Columns,
    /// The matrix in media with a boundary.
    matrix: Option<DMatrix<f64>>,
}

/// Number of spheres, of which an error message has the eigenvalues.
const MAX_EIGENVALUE_SPHERES: usize = 100;

impl<'a> PointMobility<'a> {
    /// The mobility of spheres in a medium.
    ///
    /// # Errors
    /// Those of [`oseen::mobility`] and [`rpy::mobility`].
    pub fn new(
        model: PointModel,
        spheres: &'a Spheres,
        medium: &Medium,
    ) -> Result<Self, HydroError> {
        spheres.check_inside(medium)?;
        let columns = match model {
            PointModel::Oseen => oseen::columns(spheres),
            PointModel::Rpy => rpy::columns(spheres),
        };
        let matrix = match (medium, model) {
            (Medium::Unbounded, _) => None,
            (_, PointModel::Oseen) => Some(oseen::mobility(spheres, medium)?),
            (_, PointModel::Rpy) => Some(rpy::mobility(spheres, medium)?),
        };
        Ok(Self {
            model,
            spheres,
            medium: *medium,
            columns,
            matrix,
        })
    }

    /// The spheres.
    pub fn spheres(&self) -> &Spheres {
        self.spheres
    }

    /// Velocities and angular velocities for forces and torques, six entries per sphere.
    ///
    /// Cost: `O(n²)` operations in parallel. The result does not depend on the number of threads.
    ///
    /// # Errors
    /// [`HydroError::Length`], [`HydroError::NotFinite`].
    pub fn apply(&self, forces: &DVector<f64>) -> Result<DVector<f64>, HydroError> {
        match &self.matrix {
            None => pair_mobility::apply(self.spheres, forces, &self.columns),
            Some(matrix) => {
                crate::error::check_entries(
                    "forces and torques on the spheres",
                    matrix.ncols(),
                    forces.len(),
                )?;
                Ok(matrix * forces)
            }
        }
    }

    /// The error for spheres that are too close for the model.
    pub(crate) fn not_positive_definite(&self) -> HydroError {
        let name = match self.model {
            PointModel::Oseen => "oseen",
            PointModel::Rpy => "rpy",
        };
        let all: Vec<usize> = (0..self.spheres.len().min(MAX_EIGENVALUE_SPHERES)).collect();
        pair_mobility::not_positive_definite(&self.block(&all), self.spheres, &self.medium, name)
    }

    /// The block of the mobility matrix of some spheres, in their order.
    pub fn block(&self, some: &[usize]) -> DMatrix<f64> {
        let rows = || some.iter().flat_map(|&k| 6 * k..6 * k + 6);
        if let Some(matrix) = &self.matrix {
            let rows: Vec<usize> = rows().collect();
            return matrix.select_rows(&rows).select_columns(&rows);
        }
        pair_mobility::block(self.spheres, some, |a, b| match self.model {
            PointModel::Oseen => 0.0,
            PointModel::Rpy => a * a + b * b,
        })
    }

    /// Change of the velocities by the stresslets that rigid spheres have in the flow of the forces
    /// and torques: what the model neglects to the order `(a/d)^4` (for points `(a/d)^3`).
    ///
    /// A sphere in the strain rate `E` of the others has the stresslet `20π/3 a³ E` (Batchelor
    /// 1970). The change is a symmetric, negative semi-definite operator on the forces; for points
    /// it contains the difference from Rotne-Prager-Yamakawa, too. In unbounded fluid: walls are
    /// ignored. Cost: two or four products.
    ///
    /// # Errors
    /// [`HydroError::Length`], [`HydroError::NotFinite`].
    pub fn first_reflection(&self, forces: &DVector<f64>) -> Result<DVector<f64>, HydroError> {
        let spheres = self.spheres;
        let mut change = DVector::zeros(6 * spheres.len());
        let finite;
        let columns = match self.model {
            PointModel::Rpy => &self.columns,
            PointModel::Oseen => {
                finite = rpy::columns(spheres);
                change += pair_mobility::apply(spheres, forces, &finite)?;
                change -= pair_mobility::apply(spheres, forces, &self.columns)?;
                &finite
            }
        };
        let mut stresslets = columns.strain_rates(forces);
        for (k, a) in spheres.radii().iter().enumerate() {
            let mut rows = stresslets.rows_mut(6 * k, 6);
            rows *= 20.0 / 3.0 * PI * a.powi(3);
        }
        change += columns.stresslet_velocities(&stresslets);
        crate::error::check_finite("a velocity of a sphere", &change)?;
        Ok(change)
    }
}
