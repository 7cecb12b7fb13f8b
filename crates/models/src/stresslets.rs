//! Stresslets of the bodies of one solution.

use nalgebra::{Matrix3, UnitQuaternion};

/// Stresslets of the bodies of one solution, in the scene's units.
///
/// The stresslet of a body has the sign of Batchelor (1970): it is the symmetric first moment,
/// without trace, of the traction `σ n` of the fluid on the body. With the normal `n` out of the
/// body and positions `x` relative to its centre
///
/// ```text
/// S = ∮ [(σ n) x^T + x (σ n)^T] / 2 - I (x · σ n) / 3 - μ (u n^T + n u^T) dS
/// ```
///
/// A rigid sphere in the strain `E` has `20π/3 μ a^3 E` (Einstein 1906), a squirmer
/// `4π/3 μ a^2 B2 (3 e e^T - I)`: positive along its axis for pullers, negative for pushers. The
/// forces of solutions are those on the fluid, so the first moment of these forces is `-S` for
/// rigid surfaces. The flow of a force-free body is `-3 x (x · S x) / (8π μ r^5)` far from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Stresslets {
    /// One per body of the scene; zero for points.
    pub bodies: Vec<Matrix3<f64>>,
    /// Those before the estimated discretisation error was subtracted.
    pub uncorrected: Vec<Matrix3<f64>>,
    /// Error bar of the norms of the stresslets; `None` if it was not estimated.
    pub error: Option<f64>,
}

impl Stresslets {
    /// These corrected stresslets, with what was computed, the relative uncertainty of the
    /// correction and a lower bound of the uncertainty.
    #[must_use]
    pub(crate) fn correcting(self, computed: &Self, relative: f64, at_least: f64) -> Self {
        let changes = self.bodies.iter().zip(&computed.bodies);
        let largest = changes.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        Self {
            uncorrected: computed.bodies.clone(),
            error: Some(at_least.max(relative * largest)),
            ..self
        }
    }

    /// Norm of the largest stresslet.
    pub fn largest(&self) -> f64 {
        (self.bodies.iter()).map(Matrix3::norm).fold(0.0, f64::max)
    }

    /// Rotates all stresslets, for a configuration that is rotated as a whole.
    pub(crate) fn rotate(&mut self, rotation: &UnitQuaternion<f64>) {
        let rotation = rotation.to_rotation_matrix();
        for stresslet in self.bodies.iter_mut().chain(&mut self.uncorrected) {
            *stresslet = rotation.matrix() * *stresslet * rotation.matrix().transpose();
        }
    }
}
