//! Unbounded fluid as a large ball, and the correction for the effect of its wall.
//!
//! A force `F` on the fluid causes the far field `F / (8π μ r)`, so a wall at the distance `R`
//! reduces the velocity of a body of radius `a` by a relative amount `a / R`. No ball of
//! practicable size makes this negligible. But to first order the effect of the wall near the
//! centre of a ball is known exactly: the uniform flow
//!
//! ```text
//! -3 F / (8π μ R)
//! ```
//!
//! (Oseen 1927; the first-order term in Haberman & Sayre 1958). The remaining error is of third
//! order in the extent of the bodies over `R`. A uniform flow moves all bodies alike and puts no
//! load on links, so the correction is added to all velocities after the solve.

use std::f64::consts::PI;

use mesh::Sphere;
use nalgebra::{DMatrix, Vector3};

use crate::ModelError;
use crate::units::Scale;
use scene::Scene;

/// Radius of the ball relative to the extent of the bodies.
///
/// The relative error is of third order in its inverse. Elements grow with the distance, so the
/// additional volume needs few of them.
const RELATIVE_RADIUS: f64 = 60.0;

/// Relative error of the corrected velocity over `(extent / R)^3`.
///
/// 5/2 for one sphere (Haberman & Sayre 1958).
const THIRD_ORDER: f64 = 2.5;

/// The ball that replaces unbounded fluid, in scaled units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarField {
    ball: Sphere,
}

impl FarField {
    /// The ball around the bodies of a scene.
    pub fn around(scene: &Scene, scale: &Scale) -> Self {
        let positions = || scene.bodies().iter().map(|b| scale.point(b.position));
        let centre = positions().sum::<Vector3<f64>>() / scene.bodies().len().max(1) as f64;
        let extent = scene
            .bodies()
            .iter()
            .zip(positions())
            .map(|(body, x)| (x - centre).norm() + scale.length(body.bounding_radius()))
            .fold(1.0, f64::max);
        Self {
            ball: Sphere {
                centre,
                radius: RELATIVE_RADIUS * extent,
            },
        }
    }

    /// The ball.
    pub fn ball(&self) -> Sphere {
        self.ball
    }

    /// Correction `3 F / (8π R)` of all velocities, for the total force `F` on the fluid.
    pub fn velocity_correction(&self, force: Vector3<f64>) -> Vector3<f64> {
        force * self.mobility()
    }

    /// Relative error of corrected velocities, for bodies with these centres and radii.
    pub fn relative_error(&self, bodies: impl Iterator<Item = (Vector3<f64>, f64)>) -> f64 {
        let extent = bodies
            .map(|(centre, radius)| (centre - self.ball.centre).norm() + radius)
            .fold(0.0, f64::max);
        THIRD_ORDER * (extent / self.ball.radius).powi(3)
    }

    /// Grand resistance in unbounded fluid from the grand resistance in the ball.
    ///
    /// In the mobility matrix, every force adds the same velocity to every body.
    ///
    /// # Errors
    /// [`ModelError::Singular`] for a singular matrix.
    pub fn corrected(&self, resistance: DMatrix<f64>) -> Result<DMatrix<f64>, ModelError> {
        let mut mobility = inverse("grand resistance", resistance)?;
        let bodies = mobility.nrows() / 6;
        for (i, j) in (0..bodies).flat_map(|i| (0..bodies).map(move |j| (i, j))) {
            for axis in 0..3 {
                mobility[(6 * i + axis, 6 * j + axis)] += self.mobility();
            }
        }
        let resistance = inverse("corrected grand mobility", mobility)?;
        // The inversion leaves an asymmetry of the size of rounding errors.
        Ok(0.5 * (&resistance + resistance.transpose()))
    }

    fn mobility(&self) -> f64 {
        3.0 / (8.0 * PI * self.ball.radius)
    }
}

fn inverse(name: &'static str, matrix: DMatrix<f64>) -> Result<DMatrix<f64>, ModelError> {
    let size = matrix.nrows();
    let singular = ModelError::Singular { matrix: name, size };
    matrix.try_inverse().ok_or(singular)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_singular_resistance_is_named() {
        let far = FarField {
            ball: Sphere {
                centre: Vector3::zeros(),
                radius: 60.0,
            },
        };
        let error = far.corrected(DMatrix::zeros(6, 6)).unwrap_err();
        assert!(
            matches!(&error, ModelError::Singular { size: 6, .. }),
            "{error}"
        );
        assert!(
            error
                .to_string()
                .contains("grand resistance (6 x 6) is singular")
        );
    }
}
