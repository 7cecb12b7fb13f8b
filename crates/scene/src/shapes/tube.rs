//! Tubes with round ends, straight or bent by a wave.

use mesh::Surface;
use mesher::{BentTube, TubeProfile};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::geometry::{Geometry, ShapeFile, ShapeKeys, Support, placed};
use crate::error::SceneError;
use crate::keys::BodyFile;
use crate::undulation::{Bend, BentLine, WaveTube};

/// A tube with round ends along the x axis, before the rotation; a wave may bend it.
///
/// The position is the middle of the straight centreline, which is from `-length / 2`, the front,
/// to `length / 2`. Balls close the ends. A head is a ball in front of the centreline, joined to it
/// by a concave fillet of the radius of the tube.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct TubeShape {
    /// Length of the centreline.
    pub length: f64,
    /// Radius at the front.
    pub radius: f64,
    /// Radius at the end.
    pub end_radius: f64,
    /// Radius of the head; none without one.
    pub head_radius: Option<f64>,
    /// Rotation vector into the initial configuration, in radians.
    pub orientation: Vector3<f64>,
    /// The wave that bends the tube; none if it is straight.
    pub bend: Option<Bend>,
}

impl TubeShape {
    /// The bent tube with lengths divided by `unit`, about its position and before its rotation.
    pub(crate) fn tube(&self, unit: f64) -> WaveTube {
        let curve = BentLine::new(self.length / unit, self.bend);
        BentTube::new(curve, self.profile(unit))
    }

    fn profile(&self, unit: f64) -> TubeProfile {
        let [length, start, end] =
            [self.length, self.radius, self.end_radius].map(|length| length / unit);
        TubeProfile::new(length, [start, end], self.head_radius.map(|r| r / unit))
    }

    /// Radius of a ball about the middle of the centreline that contains the tube, however it is
    /// bent.
    pub(crate) fn largest_extent(&self) -> f64 {
        let [front, end] = self.profile(1.0).end_balls();
        let middle = 0.5 * self.length;
        (middle - front.0 + front.1)
            .max(end.0 - middle + end.1)
            .max(middle + self.radius)
    }
}

impl ShapeFile for TubeShape {
    fn keys() -> &'static [&'static str] {
        &[
            "length",
            "radius",
            "end_radius",
            "head_radius",
            "orientation",
        ]
    }

    fn read(keys: &mut ShapeKeys) -> Result<Self, SceneError> {
        let file = keys.file;
        let why = ": a tube needs the radius at its front";
        let radius = keys.required("radius", file.radius, why)?;
        Ok(Self {
            length: keys.required("length", file.length, ": a tube needs its length")?,
            radius,
            end_radius: file.end_radius.unwrap_or(radius),
            head_radius: file.head_radius,
            orientation: keys.orientation()?,
            bend: None,
        })
    }

    fn write(&self, file: &mut BodyFile) {
        file.length = Some(self.length);
        file.radius = Some(self.radius);
        file.end_radius = Some(self.end_radius).filter(|end| *end != self.radius);
        file.head_radius = self.head_radius;
        file.orientation = Some(self.orientation.into());
    }

    fn orientation(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_scaled_axis(self.orientation)
    }
}

impl Geometry for TubeShape {
    fn problem(&self) -> Option<(&'static str, String)> {
        if (self.radius - self.end_radius).abs() >= 0.5 * self.length {
            let bound = "differ from `radius` by less than half the length: a tube is slender";
            return Some(("end_radius", format!("{bound}; use another shape")));
        }
        let least = MIN_HEAD * self.radius.max(self.end_radius);
        (self.head_radius.is_some_and(|head| head < least)).then(|| {
            let bound = format!("at least {least:.5e}, {MIN_HEAD} radii of the tube");
            ("head_radius", bound)
        })
    }

    fn lengths(&self) -> Vec<(&'static str, f64)> {
        let mut lengths = vec![
            ("length", self.length),
            ("radius", self.radius),
            ("end_radius", self.end_radius),
        ];
        lengths.extend(self.head_radius.map(|head| ("head_radius", head)));
        lengths
    }

    fn bounding_radius(&self) -> f64 {
        let offset = self.bend.map_or(0.0, |bend| {
            bend.amplitude.abs() * bend.wave.offset(self.length)
        });
        self.largest_extent() + offset
    }

    /// That of the thicker end, up to twice that of the other: a thin end has a small part of the
    /// force, but elements of its size cover the whole tube.
    fn size_radius(&self) -> f64 {
        let (low, high) = (
            self.radius.min(self.end_radius),
            self.radius.max(self.end_radius),
        );
        high.min(2.0 * low)
    }

    fn volume(&self) -> f64 {
        self.profile(1.0).volume_and_moment()[0]
    }

    /// That of the straight tube; none of a bent one, on which no weight acts.
    fn centroid(&self) -> Vector3<f64> {
        let [volume, moment] = self.profile(1.0).volume_and_moment();
        Vector3::x() * (moment / volume - 0.5 * self.length)
    }

    fn centreline(&self) -> Vec<(Vector3<f64>, f64)> {
        let balls = self.tube(1.0).balls().into_iter();
        balls
            .map(|(x, radius)| (self.orientation() * x, radius))
            .collect()
    }

    fn support_point(&self, n: &Vector3<f64>) -> Vector3<f64> {
        // A taper bulges out of the convex hull of the balls at its ends.
        if self.bend.is_some() || self.radius != self.end_radius {
            return self.tube(1.0).support_point(n);
        }
        let balls = self.profile(1.0).end_balls();
        let [front, end] =
            balls.map(|(arc, radius)| Vector3::x() * (arc - 0.5 * self.length) + radius * n);
        if end.dot(n) > front.dot(n) {
            end
        } else {
            front
        }
    }

    fn support(&self) -> Box<Support<'_>> {
        // The circles of a bent or tapered tube are the same for all directions.
        if self.bend.is_none() && self.radius == self.end_radius {
            return Box::new(|n| self.support_point(n));
        }
        let tube = self.tube(1.0);
        Box::new(move |n| tube.support_point(n))
    }

    fn transverse_support_distance(&self, n: &Vector3<f64>) -> f64 {
        self.tube(1.0).distance_from_axis(n)
    }

    fn surface(&self, pose: Isometry3<f64>, unit: f64) -> Option<Box<dyn Surface>> {
        placed(pose, self.tube(unit))
    }
}

/// Smallest radius of a head over that of its tube: below it the fillet leaves nothing of the ball.
const MIN_HEAD: f64 = 1.2;
