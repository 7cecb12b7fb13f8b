//! Spheres and what surrounds them.

use nalgebra::{UnitVector3, Vector3};

use crate::HydroError;

/// Rigid spheres of any radii that do not touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Spheres {
    centres: Vec<Vector3<f64>>,
    radii: Vec<f64>,
}

/// Where the fluid around the spheres ends; there it does not slip.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Medium {
    /// Nowhere.
    #[default]
    Unbounded,
    /// On a sphere around all others.
    Ball {
        /// Its centre.
        centre: Vector3<f64>,
        /// Its radius.
        radius: f64,
    },
    /// On a plane.
    Wall {
        /// A point of the plane.
        point: Vector3<f64>,
        /// The normal that points into the fluid.
        normal: UnitVector3<f64>,
    },
}

/// Gaps below this part of the smaller radius are rounding errors of the centres: the spheres touch.
const TOUCHING: f64 = 1e-12;

impl Spheres {
    /// Spheres with these centres and radii.
    ///
    /// # Errors
    /// Lists of different lengths, a radius that is not positive, a centre that is not finite, two spheres that touch.
    pub fn new(centres: Vec<Vector3<f64>>, radii: Vec<f64>) -> Result<Self, HydroError> {
        if centres.len() != radii.len() {
            return Err(HydroError::Length {
                what: "radii of the spheres",
                expected: centres.len(),
                found: radii.len(),
            });
        }
        if !centres.iter().flatten().all(|x| x.is_finite()) {
            return Err(HydroError::NotFinite {
                what: "a sphere's centre",
            });
        }
        if let Some(sphere) = radii.iter().position(|a| !(a.is_finite() && *a > 0.0)) {
            return Err(HydroError::BadRadius {
                sphere,
                radius: radii[sphere],
            });
        }
        let spheres = Self { centres, radii };
        for second in 0..spheres.len() {
            for first in 0..second {
                let gap = spheres.gap(first, second);
                if gap <= TOUCHING {
                    return Err(HydroError::Touching {
                        first,
                        second,
                        gap: gap * spheres.radii[first].min(spheres.radii[second]),
                    });
                }
            }
        }
        Ok(spheres)
    }

    /// Number of spheres.
    pub fn len(&self) -> usize {
        self.radii.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.radii.is_empty()
    }

    /// The centres.
    pub fn centres(&self) -> &[Vector3<f64>] {
        &self.centres
    }

    /// The radii.
    pub fn radii(&self) -> &[f64] {
        &self.radii
    }

    /// Distance between the surfaces of two spheres over the smaller radius.
    pub fn gap(&self, first: usize, second: usize) -> f64 {
        let (a, b) = (self.radii[first], self.radii[second]);
        ((self.centres[first] - self.centres[second]).norm() - a - b) / a.min(b)
    }

    /// The two surfaces with the narrowest gap, in words, and their distance over the smaller radius.
    pub(crate) fn narrowest_gap(&self, medium: &Medium) -> (String, f64) {
        let mut narrowest = (String::from("the spheres"), f64::INFINITY);
        for second in 0..self.len() {
            for first in 0..second {
                let gap = self.gap(first, second);
                if gap < narrowest.1 {
                    narrowest = (format!("spheres {first} and {second}"), gap);
                }
            }
            let radius = self.radii[second];
            let clearance = (medium.distance(&self.centres[second]) - radius) / radius;
            if clearance < narrowest.1 {
                let surfaces = format!("sphere {second} and the {}", medium.boundary());
                narrowest = (surfaces, clearance);
            }
        }
        narrowest
    }

    /// Refuses spheres that reach through the boundary of a medium.
    ///
    /// # Errors
    /// [`HydroError::OutsideMedium`] names the sphere; a radius of the container that is not positive.
    pub fn check_inside(&self, medium: &Medium) -> Result<(), HydroError> {
        for sphere in 0..self.len() {
            let clearance = medium.distance(&self.centres[sphere]) - self.radii[sphere];
            // Written so that a distance that is not a number is refused as well.
            if clearance > TOUCHING * self.radii[sphere] {
                continue;
            }
            return Err(HydroError::OutsideMedium {
                sphere,
                boundary: medium.boundary(),
                clearance,
            });
        }
        Ok(())
    }
}

impl Medium {
    /// A wall through a point, with the fluid on the side of `normal`.
    ///
    /// # Errors
    /// A normal without direction.
    pub fn wall(point: Vector3<f64>, normal: Vector3<f64>) -> Result<Self, HydroError> {
        match UnitVector3::try_new(normal, 0.0) {
            Some(normal) if normal.iter().all(|x| x.is_finite()) => {
                Ok(Self::Wall { point, normal })
            }
            _ => Err(HydroError::NotFinite {
                what: "the direction of the wall's normal",
            }),
        }
    }

    /// Distance from a point in the fluid to the boundary, negative beyond it, infinite where there is none.
    pub fn distance(&self, x: &Vector3<f64>) -> f64 {
        match self {
            Self::Unbounded => f64::INFINITY,
            Self::Ball { centre, radius } => radius - (x - centre).norm(),
            Self::Wall { point, normal } => (x - point).dot(normal),
        }
    }

    /// What the boundary is called in messages.
    pub(crate) fn boundary(&self) -> &'static str {
        match self {
            Self::Unbounded => "unbounded fluid",
            Self::Ball { .. } => "container",
            Self::Wall { .. } => "wall",
        }
    }
}
