//! Shapes of bodies on the axis: spheroids, and spheres that are deformed along the radius.

use std::f64::consts::PI;

use crate::curve::{BoundaryPart, Curve, Point};
use crate::deformed_sphere::DeformedSphere;
use crate::spheroid::AxialSpheroid;

/// The shape of a body on the axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxialShape {
    /// The spheroid; of a deformed sphere that of its radius `a`.
    pub spheroid: AxialSpheroid,
    deformed: Option<DeformedSphere>,
}

impl From<AxialSpheroid> for AxialShape {
    fn from(spheroid: AxialSpheroid) -> Self {
        Self {
            spheroid,
            deformed: None,
        }
    }
}

impl From<DeformedSphere> for AxialShape {
    fn from(sphere: DeformedSphere) -> Self {
        let is_deformed = sphere.amplitudes.iter().any(|amplitude| *amplitude != 0.0);
        Self {
            spheroid: AxialSpheroid::sphere(sphere.centre, sphere.radius),
            deformed: is_deformed.then_some(sphere),
        }
    }
}

impl AxialShape {
    /// Position of the centre.
    pub fn centre(&self) -> f64 {
        self.spheroid.centre
    }

    /// Whether the shape is not that of the spheroid.
    pub fn is_deformed(&self) -> bool {
        self.deformed.is_some()
    }

    /// Position of the left pole.
    pub fn left(&self) -> f64 {
        let reach = (self.deformed).map_or(self.spheroid.axial, |sphere| sphere.radius_at(PI));
        self.spheroid.centre - reach
    }

    /// Position of the right pole.
    pub fn right(&self) -> f64 {
        let reach = (self.deformed).map_or(self.spheroid.axial, |sphere| sphere.radius_at(0.0));
        self.spheroid.centre + reach
    }

    /// Signed distance to the surface, accurate to first order near it; negative inside.
    pub fn distance(&self, x: &Point) -> f64 {
        let Some(sphere) = &self.deformed else {
            return self.spheroid.distance(x);
        };
        let arm = x - Point::new(sphere.centre, 0.0);
        let [radius, slope] = sphere.with_slope(arm.y.atan2(arm.x));
        (arm.norm() - radius) / (slope / radius).hypot(1.0)
    }

    /// Distance to the singularities of the analytic continuation of the exterior flow: for a
    /// deformed sphere a lower bound, as they move towards the parts of its surface that are near
    /// the centre.
    pub fn focal_distance(&self, x: &Point) -> f64 {
        let focal = self.spheroid.focal_distance(x);
        match &self.deformed {
            None => focal,
            Some(sphere) => {
                let size: f64 = sphere
                    .amplitudes
                    .iter()
                    .map(|amplitude| amplitude.abs())
                    .sum();
                focal / (1.0 + SHRINKAGE * size)
            }
        }
    }

    /// The boundary curve from the left pole to the right one.
    pub fn upper_half(&self, part: BoundaryPart) -> Curve {
        match self.deformed {
            None => self.spheroid.upper_half(part),
            Some(sphere) => Curve::Radial { sphere, part },
        }
    }
}

/// Decrease of the sizes of elements around a sphere per sum of its amplitudes: with it the errors
/// of one order are about those of the sphere up to amplitudes of 0.2.
const SHRINKAGE: f64 = 4.0;
