//! Random loads on linked bodies.

use microhydro::Mobility;
use nalgebra::{DMatrix, DVector};

use super::SomeLinkages;
use super::moving_linkage::{cholesky, on_state};
use crate::error::ModelError;

impl SomeLinkages<'_> {
    /// Random loads on all generalised velocities, of the resistance as covariance, from standard
    /// normal numbers.
    ///
    /// # Errors
    /// A resistance that is not positive definite.
    pub fn random_loads(
        &self,
        resistance: &DMatrix<f64>,
        normal: &mut dyn FnMut() -> f64,
    ) -> Result<DVector<f64>, ModelError> {
        let (_, _, matrix) = self.reduced(resistance);
        let numbers = DVector::from_fn(matrix.nrows(), |_, _| normal());
        let loads = cholesky(matrix)?.l() * numbers;
        self.on_state(&self.of_linkages(&loads))
    }

    /// The same by a mobility, without the resistance.
    ///
    /// # Errors
    /// Spheres too close for the model; a square root that does not converge.
    pub fn random_loads_by_mobility(
        &self,
        mobility: &impl Mobility,
        normal: &mut dyn FnMut() -> f64,
    ) -> Result<DVector<f64>, ModelError> {
        self.on_state(&self.spheres(mobility, None)?.random_loads(normal)?)
    }

    /// Loads on the velocities of the state that do the work of loads on the coordinates of each
    /// linkage.
    fn on_state(&self, loads: &[DVector<f64>]) -> Result<DVector<f64>, ModelError> {
        let count = self.velocities.iter().map(Vec::len).sum();
        let mut all = DVector::zeros(count);
        for ((one, velocities), own) in self.linkages.iter().zip(&self.velocities).zip(loads) {
            let places = one.set().state_velocities();
            let loads = on_state(&one.reduction.all.basis, &places, own)?;
            for (&place, load) in places.iter().zip(loads.iter()) {
                all[velocities[place]] += load;
            }
        }
        Ok(all)
    }
}
