//! Grand resistance matrices of spheres, and those from which their errors are estimated.

use microhydro::multipole::Orders;
use microhydro::{Accuracy, HydroError, Medium, Resistance, Spheres, multipole, oseen, rpy};
use nalgebra::{DMatrix, DVector};

use super::SphereModel;
use crate::error::ModelError;

/// Orders of the multipole expansions that estimate the error of Oseen and RPY, in ascending order.
///
/// They are fixed orders instead of tolerances. Near contact a tolerance would need orders in the
/// hundreds, although these models have errors of the size of the velocities there.
pub(super) const REFERENCE_ORDERS: [usize; 4] = [4, 8, 16, 28];

/// Largest error of an accepted reference, relative to the error that it finds.
const REFERENCE_ACCURACY: f64 = 0.3;

/// Factor on the change from a lower order to the lowest one of this model, for all quantities.
///
/// That of velocities of linked spheres, which are ratios of forces, is the largest: errors were
/// 1.0 to 1.2 times the change for distant pairs, 1.8 times at most among three spheres.
const LOWEST_ORDER_FACTOR: f64 = 3.0;

/// Predicted seconds of a limited reference.
const REFERENCE_SECONDS: f64 = 0.05;

/// A grand resistance matrix, and reference matrices from which its error is estimated.
#[derive(Clone)]
pub(super) struct SphereResistances {
    pub matrix: DMatrix<f64>,
    /// Reference matrices with factors.
    ///
    /// The error of a quantity is the sum of the differences between successive matrices, starting
    /// with `matrix`, each multiplied by the factor of the later one. The last of these differs by
    /// rounding.
    pub references: Vec<(DMatrix<f64>, f64)>,
    /// The references that follow, of lower orders of the expansions.
    pub coarser: Vec<(DMatrix<f64>, f64)>,
    /// Orders of the multipole expansion of the resistance, or of the last reference.
    pub orders: Orders,
    pub dofs: usize,
}

/// Matrices with factors of lower orders: with coarser gaps, then with coarser expansions too.
fn coarser_than(resistance: &Resistance) -> Vec<(DMatrix<f64>, f64)> {
    let of_gaps = resistance
        .coarser_gaps()
        .map(|of_gaps| (of_gaps.clone(), 1.0));
    let factor = match resistance.orders().are_lowest() {
        true => LOWEST_ORDER_FACTOR,
        false => 1.0,
    };
    let coarser = (resistance.coarser().clone(), factor * resistance.tail());
    of_gaps.into_iter().chain(Some(coarser)).collect()
}

impl SphereResistances {
    /// The resistance of spheres by a model.
    ///
    /// # Errors
    /// Spheres that are too close, or too many.
    pub fn new(kind: SphereModel, spheres: &Spheres, medium: &Medium) -> Result<Self, ModelError> {
        Self::within(f64::INFINITY, kind, spheres, medium)
    }

    /// The same with references that take at most a few hundredths of a second, as predicted; the
    /// first one is of the lowest order. The error of a reference counts.
    ///
    /// # Errors
    /// As [`SphereResistances::new`].
    pub fn limited(
        kind: SphereModel,
        spheres: &Spheres,
        medium: &Medium,
    ) -> Result<Self, ModelError> {
        Self::within(REFERENCE_SECONDS, kind, spheres, medium)
    }

    fn within(
        seconds: f64,
        kind: SphereModel,
        spheres: &Spheres,
        medium: &Medium,
    ) -> Result<Self, ModelError> {
        let expansion = |accuracy: Accuracy| -> Result<Resistance, ModelError> {
            Ok(multipole::resistance(spheres, medium, &accuracy)?)
        };
        let matrix = match kind {
            SphereModel::Multipole(tolerance) => {
                // Where the tolerance is out of reach, the error bar of the answer says so.
                let accuracy = Accuracy::relative(tolerance);
                let result = multipole::resistance_best(spheres, medium, &accuracy)?;
                return Ok(Self {
                    dofs: result.dofs(),
                    orders: result.orders().clone(),
                    references: vec![(result.rounded().clone(), 1.0)],
                    coarser: coarser_than(&result),
                    matrix: result.matrix().clone(),
                });
            }
            SphereModel::Oseen => oseen::resistance(spheres, medium)?,
            SphereModel::Rpy => rpy::resistance(spheres, medium)?,
        };
        let dofs = matrix.nrows();
        let mut reference = expansion(Accuracy::order(REFERENCE_ORDERS[0]))?;
        for &order in &REFERENCE_ORDERS[1..] {
            let difference = reference.relative_difference(&matrix);
            let accuracy = Accuracy::order(order);
            if reference.relative_error() <= REFERENCE_ACCURACY * difference
                || multipole::predicted_seconds(spheres, medium, &accuracy, 0)? > seconds
            {
                break;
            }
            match expansion(Accuracy::order(order)) {
                // The last reference that fits into memory estimates the error.
                Err(ModelError::Spheres(HydroError::TooLarge { .. })) => break,
                found => reference = found?,
            }
        }
        let references = [reference.matrix(), reference.rounded()];
        Ok(Self {
            matrix,
            references: references.map(|matrix| (matrix.clone(), 1.0)).to_vec(),
            coarser: coarser_than(&reference),
            orders: reference.orders().clone(),
            dofs,
        })
    }

    /// Largest velocity and angular velocity `|Δf_i| / R_ii` of single spheres, the others held,
    /// due to the errors `Δf = Σ c ΔR (U - U_0)` of forces and torques at fixed velocities.
    ///
    /// `c` and `ΔR` are the factors and the differences of successive references; `velocities` has
    /// `U - U_0`, relative to force-free spheres.
    pub fn unbalanced_velocities(&self, velocities: &DVector<f64>) -> [f64; 2] {
        let mut forces = DVector::zeros(velocities.len());
        self.visit_changes(|factor, change| forces += factor * (change * velocities));
        let diagonal = self.matrix.diagonal();
        let largest = |first: usize| {
            (0..forces.len())
                .filter(|row| row % 6 / 3 == first)
                .map(|row| (forces[row] / diagonal[row]).abs())
                .fold(0.0, f64::max)
        };
        [largest(0), largest(1)]
    }

    /// Error bars of the entries.
    pub fn errors(&self) -> DMatrix<f64> {
        let mut errors = DMatrix::zeros(self.matrix.nrows(), self.matrix.ncols());
        self.visit_changes(|factor, change| errors += factor * change.abs());
        errors
    }

    /// Visits the differences between successive references, with the factors of the later ones.
    fn visit_changes(&self, mut visit: impl FnMut(f64, DMatrix<f64>)) {
        let mut previous = &self.matrix;
        for (reference, factor) in self.references.iter().chain(&self.coarser) {
            visit(*factor, previous - reference);
            previous = reference;
        }
    }
}
