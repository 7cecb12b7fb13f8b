//! Shapes of bodies on the axis: spheroids, and spheres that are deformed along the radius.

use std::f64::consts::PI;

use crate::curve::{BoundaryPart, Curve, Point};
use crate::quadrature::legendre;
use crate::spheroid::AxialSpheroid;

/// Number of amplitudes of a radial function: degrees from zero to twelve.
pub const RADIAL_DEGREES: usize = 13;

/// A sphere on the axis that is deformed along the radius, to
///
/// ```text
/// r(θ) = a (1 + Σ_l α_l P_l(cos θ) / p)^p
/// ```
///
/// at the angle `θ` from the axis, with Legendre polynomials `P_l`. With `p = 1/3` all amplitudes
/// but that of the degree zero keep its volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeformedSphere {
    /// Position of the centre on the axis.
    pub centre: f64,
    /// `a`.
    pub radius: f64,
    /// `p`.
    pub power: f64,
    /// `α_l`.
    pub amplitudes: [f64; RADIAL_DEGREES],
}

impl DeformedSphere {
    /// Distance of the surface from the centre at an angle from the axis.
    pub fn radius_at(&self, angle: f64) -> f64 {
        self.with_slope(angle)[0]
    }

    /// The distance `r(θ)` and its derivative.
    pub(crate) fn with_slope(&self, angle: f64) -> [f64; 2] {
        let (sin, cos) = angle.sin_cos();
        let mut base = [1.0, 0.0];
        for (degree, amplitude) in self.amplitudes.iter().enumerate() {
            if *amplitude == 0.0 {
                continue;
            }
            let [p, slope] = match degree {
                0 => [1.0, 0.0],
                _ => {
                    let [p, slope, _] = legendre(degree, cos);
                    [p, slope]
                }
            };
            base[0] += amplitude * p / self.power;
            base[1] -= amplitude * slope * sin / self.power;
        }
        let radius = self.radius * base[0].powf(self.power);
        [radius, self.power * radius / base[0] * base[1]]
    }
}

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

/// Decrease of the sizes of elements around a sphere per sum of its amplitudes: with it the errors of
/// one order are about those of the sphere up to amplitudes of 0.2.
const SHRINKAGE: f64 = 4.0;
