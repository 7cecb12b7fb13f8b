//! Arrangements of spheres, and the boundary of the fluid around them.

use nalgebra::{UnitVector3, Vector3};

use crate::HydroError;
use crate::error::{check_entries, check_finite};
use crate::near_pairs::for_near_pairs;

/// Rigid spheres of any radii that do not touch each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Spheres {
    centres: Vec<Vector3<f64>>,
    radii: Vec<f64>,
}

/// Domain of the fluid around the spheres. Its boundary, if any, is a no-slip surface at rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Medium {
    /// Fluid without boundary, at rest at infinity.
    #[default]
    Unbounded,
    /// Fluid inside a spherical container.
    Ball {
        /// Centre of the container.
        centre: Vector3<f64>,
        /// Radius of the container.
        radius: f64,
    },
    /// Half space above a plane wall.
    Wall {
        /// A point on the wall.
        point: Vector3<f64>,
        /// Unit normal of the wall, pointing into the fluid.
        normal: UnitVector3<f64>,
    },
}

/// Largest relative gap of touching spheres.
///
/// Gaps below this fraction of the smaller radius are rounding errors of the centres.
const CONTACT_TOLERANCE: f64 = 1e-12;

/// Lengths whose powers and quotients in the formulas neither overflow nor vanish.
const LENGTH_RANGE: (f64, f64) = (1e-50, 1e50);

/// Checks that a length is finite and between `lowest` and the highest of [`LENGTH_RANGE`].
fn check_length(what: &'static str, length: f64, lowest: f64) -> Result<(), HydroError> {
    check_finite(what, &[length])?;
    match (lowest..=LENGTH_RANGE.1).contains(&length.abs()) {
        true => Ok(()),
        false => Err(HydroError::OutOfRange {
            what,
            length,
            lowest: LENGTH_RANGE.0,
            highest: LENGTH_RANGE.1,
        }),
    }
}

impl Spheres {
    /// Spheres with the given centres and radii.
    ///
    /// # Errors
    /// Lists of different lengths, a radius that is not positive and finite, a centre that is not
    /// finite, lengths beyond [`HydroError::OutOfRange`], two spheres that touch.
    pub fn new(centres: Vec<Vector3<f64>>, radii: Vec<f64>) -> Result<Self, HydroError> {
        check_entries("radii of the spheres", centres.len(), radii.len())?;
        check_finite("a sphere's centre", centres.iter().flatten())?;
        if let Some(sphere) = radii.iter().position(|a| !(a.is_finite() && *a > 0.0)) {
            return Err(HydroError::BadRadius {
                sphere,
                radius: radii[sphere],
            });
        }
        for &x in centres.iter().flatten() {
            check_length("a sphere's centre", x, 0.0)?;
        }
        for &radius in &radii {
            check_length("a sphere's radius", radius, LENGTH_RANGE.0)?;
        }
        let spheres = Self { centres, radii };
        // Of the pairs that touch, the first one in the order of the spheres.
        let mut touching: Option<(usize, usize)> = None;
        let largest = spheres.radii.iter().copied().fold(0.0, f64::max);
        for_near_pairs(
            &spheres.centres,
            2.0 * largest * (1.0 + CONTACT_TOLERANCE),
            |i, j| {
                if spheres.relative_gap(i, j) <= CONTACT_TOLERANCE {
                    touching = Some(touching.map_or((j, i), |found| found.min((j, i))));
                }
            },
        );
        match touching {
            None => Ok(spheres),
            Some((second, first)) => Err(HydroError::Touching {
                first,
                second,
                gap: spheres.relative_gap(first, second)
                    * spheres.radii[first].min(spheres.radii[second]),
            }),
        }
    }

    /// Number of spheres.
    pub fn len(&self) -> usize {
        self.radii.len()
    }

    /// Whether there are no spheres.
    pub fn is_empty(&self) -> bool {
        self.radii.is_empty()
    }

    /// Centres of the spheres.
    pub fn centres(&self) -> &[Vector3<f64>] {
        &self.centres
    }

    /// Radii of the spheres.
    pub fn radii(&self) -> &[f64] {
        &self.radii
    }

    /// Distance between the surfaces of two spheres, divided by the smaller radius.
    ///
    /// None for an index that is not below [`Spheres::len`], and for a sphere with itself.
    pub fn gap(&self, first: usize, second: usize) -> Option<f64> {
        let exist = first < self.len() && second < self.len() && first != second;
        exist.then(|| self.relative_gap(first, second))
    }

    pub(crate) fn relative_gap(&self, first: usize, second: usize) -> f64 {
        let distance = (self.centres[first] - self.centres[second]).norm();
        self.relative_gap_at((first, second), distance)
    }

    /// The gap of two spheres whose centres have this distance, over the smaller radius.
    pub(crate) fn relative_gap_at(&self, (first, second): (usize, usize), distance: f64) -> f64 {
        let (a, b) = (self.radii[first], self.radii[second]);
        (distance - a - b) / a.min(b)
    }

    /// The two spheres with the narrowest gap relative to the smaller radius among those that are
    /// near each other; `None` for fewer than two spheres.
    ///
    /// Near are spheres whose centres are at most twice as far apart as those of some pair. Cost:
    /// `O(n log n)` for spheres of similar sizes that are not crowded.
    pub fn closest_pair(&self) -> Option<(usize, usize)> {
        let largest = self.radii.iter().copied().fold(0.0, f64::max);
        let mut reach = 4.0 * largest;
        let mut closest: Option<(f64, usize, usize)> = None;
        while self.len() > 1 && closest.is_none() && reach.is_finite() {
            for_near_pairs(&self.centres, reach, |i, j| {
                let found = (self.relative_gap(i, j), i, j);
                if closest.is_none_or(|known| found < known) {
                    closest = Some(found);
                }
            });
            reach *= 2.0;
        }
        closest.map(|(_, first, second)| (first, second))
    }

    /// Narrowest gap of the arrangement: the two surfaces, in words, and their distance divided by
    /// the smaller radius.
    pub(crate) fn narrowest_gap(&self, medium: &Medium) -> (String, f64) {
        let mut narrowest = (String::from("the spheres"), f64::INFINITY);
        for second in 0..self.len() {
            for first in 0..second {
                let gap = self.relative_gap(first, second);
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

    /// Checks that all spheres lie inside the medium.
    ///
    /// # Errors
    /// [`HydroError::OutsideMedium`] for the first sphere that touches the boundary or lies beyond
    /// it; [`HydroError::NotFinite`] and [`HydroError::OutOfRange`] for the lengths of the medium.
    pub fn check_inside(&self, medium: &Medium) -> Result<(), HydroError> {
        medium.check()?;
        for sphere in 0..self.len() {
            let clearance = medium.distance(&self.centres[sphere]) - self.radii[sphere];
            // The comparison also rejects a clearance that is NaN.
            if clearance > CONTACT_TOLERANCE * self.radii[sphere] {
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
    /// Half space bounded by a wall through `point`; `normal` points into the fluid.
    ///
    /// `normal` may have any length.
    ///
    /// # Errors
    /// [`HydroError::NotFinite`] for a zero or non-finite normal or a non-finite point;
    /// [`HydroError::OutOfRange`].
    pub fn wall(point: Vector3<f64>, normal: Vector3<f64>) -> Result<Self, HydroError> {
        // the largest component first, so that squares neither overflow nor vanish
        let largest = normal.amax();
        let wall = UnitVector3::try_new(normal / largest, 0.0)
            .map(|normal| Self::Wall { point, normal })
            .ok_or(HydroError::NotFinite {
                what: "the direction of the wall's normal",
            })?;
        wall.check()?;
        Ok(wall)
    }

    /// Checks that the lengths of the medium are in range and its normal is a unit vector.
    fn check(&self) -> Result<(), HydroError> {
        match self {
            Self::Unbounded => Ok(()),
            Self::Ball { centre, radius } => {
                for &x in centre {
                    check_length("the container's centre", x, 0.0)?;
                }
                check_length("the container's radius", *radius, LENGTH_RANGE.0)
            }
            Self::Wall { point, normal } => {
                for &x in point {
                    check_length("the point on the wall", x, 0.0)?;
                }
                match (normal.norm() - 1.0).abs() <= 1e-12 {
                    true => Ok(()),
                    false => Err(HydroError::NotFinite {
                        what: "the direction of the wall's normal",
                    }),
                }
            }
        }
    }

    /// Distance from `x` to the boundary.
    ///
    /// Negative for points beyond the boundary, infinite in unbounded fluid.
    pub fn distance(&self, x: &Vector3<f64>) -> f64 {
        match self {
            Self::Unbounded => f64::INFINITY,
            Self::Ball { centre, radius } => radius - (x - centre).norm(),
            Self::Wall { point, normal } => (x - point).dot(normal),
        }
    }

    /// Name of the boundary in error messages.
    pub(crate) fn boundary(&self) -> &'static str {
        match self {
            Self::Unbounded => "unbounded fluid",
            Self::Ball { .. } => "container",
            Self::Wall { .. } => "wall",
        }
    }
}
