//! Unbounded fluid by elements: a ball far away, and what its wall takes from the bodies.
//!
//! A body that is pulled by a force sets a far field $F / (8 \pi \mu r)$ in motion, so a wall at a distance `R` slows it by a part `a/R`:
//! to be rid of it, no ball is large enough. But the wall's answer at the centre of a ball is known exactly: it is the uniform flow
//! $-3 F / (8 \pi \mu R)$ (Oseen 1927; the term of first order in Haberman & Sayre 1958), and what is left is of third order in the extent of the
//! bodies over `R`. Uniform flow moves all bodies alike and strains no link, so it is added to their velocities after the solve.

use std::f64::consts::PI;

use mesh::Sphere;
use nalgebra::{DMatrix, Vector3};

use crate::ModelError;
use crate::scale::Scale;
use scene::Scene;

/// Radius of the ball over the extent of the bodies: the third power of it is left, and elements that grow with the distance make the
/// room cheap.
const REACH: f64 = 60.0;

/// What the wall leaves of a speed after the first order, over `(extent / R)^3`: 5/2 for one sphere (Haberman & Sayre 1958).
const THIRD_ORDER: f64 = 2.5;

/// The ball that stands for unbounded fluid, in units of the flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarField {
    ball: Sphere,
}

impl FarField {
    /// The ball around the bodies of a scene.
    pub fn around(scene: &Scene, scale: &Scale) -> Self {
        let places = || scene.bodies().iter().map(|b| scale.point(b.position));
        let centre = places().sum::<Vector3<f64>>() / scene.bodies().len().max(1) as f64;
        let extent = scene
            .bodies()
            .iter()
            .zip(places())
            .map(|(body, place)| (place - centre).norm() + scale.length(body.bounding_radius()))
            .fold(1.0, f64::max);
        Self {
            ball: Sphere {
                centre,
                radius: REACH * extent,
            },
        }
    }

    /// The ball.
    pub fn ball(&self) -> Sphere {
        self.ball
    }

    /// The velocity that the wall takes from all bodies, for the sum of the forces on the fluid: $3 F / (8 \pi R)$.
    pub fn taken(&self, force: Vector3<f64>) -> Vector3<f64> {
        force * self.mobility()
    }

    /// What is left of a relative error, for bodies at these places and with these radii.
    pub fn relative_error(&self, bodies: impl Iterator<Item = (Vector3<f64>, f64)>) -> f64 {
        let reach = bodies
            .map(|(place, radius)| (place - self.ball.centre).norm() + radius)
            .fold(0.0, f64::max);
        THIRD_ORDER * (reach / self.ball.radius).powi(3)
    }

    /// The grand resistance in unbounded fluid for the one in the ball: every force adds the same velocity to every body.
    ///
    /// # Errors
    /// A resistance that is singular.
    pub fn corrected(&self, resistance: DMatrix<f64>) -> Result<DMatrix<f64>, ModelError> {
        let singular = || ModelError::NotFinite {
            model: "fem",
            what: "the grand resistance",
        };
        let mut mobility = resistance.try_inverse().ok_or_else(singular)?;
        let bodies = mobility.nrows() / 6;
        for (i, j) in (0..bodies).flat_map(|i| (0..bodies).map(move |j| (i, j))) {
            for axis in 0..3 {
                mobility[(6 * i + axis, 6 * j + axis)] += self.mobility();
            }
        }
        let resistance = mobility.try_inverse().ok_or_else(singular)?;
        // Inverting leaves an asymmetry of rounding.
        Ok(0.5 * (&resistance + resistance.transpose()))
    }

    fn mobility(&self) -> f64 {
        3.0 / (8.0 * PI * self.ball.radius)
    }
}
