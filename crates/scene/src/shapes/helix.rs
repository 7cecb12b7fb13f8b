//! Tubes along helices.

use std::f64::consts::{PI, TAU};

use mesh::Surface;
use nalgebra::{Isometry3, Vector3};

use super::geometry::{BALL, Geometry, ShapeFile, helix_points, placed, shape_struct};

shape_struct! {
    /// A tube with round ends along a helix about the x axis, before the rotation.
    ///
    /// The middle of the helix is at `(0, radius, 0)` relative to the position.
    HelixShape {
        /// Radius of the helix in the middle of the tube.
        radius: f64 = ": a helix needs the radius of its centreline",
        /// Radius of the tube.
        tube_radius: f64 = ": a helix needs the radius of its tube",
        /// Length along the axis per turn: positive if right-handed, negative if left-handed.
        pitch: f64 = ": a helix needs its length per turn",
        /// Number of turns.
        turns: f64 = ": a helix needs its number of turns",
        orientation
    }
}

/// Largest number of turns of a helix; closest points are searched for on all of them.
const MAX_TURNS: f64 = 1000.0;

impl Geometry for HelixShape {
    fn problem(&self) -> Option<(&'static str, String)> {
        let direction =
            "other than zero: positive for a right-handed helix, negative for a left-handed one";
        if self.pitch == 0.0 {
            return Some(("pitch", direction.to_owned()));
        }
        if self.turns > MAX_TURNS {
            return Some(("turns", format!("at most {MAX_TURNS}")));
        }
        // Lengths relative to the radius, so that no square of them overflows.
        let [pitch, tube] = [self.pitch, self.tube_radius].map(|length| length / self.radius);
        let reach = mesher::Helix::new(1.0, pitch, self.turns, tube).reach();
        (reach <= 0.0).then(|| {
            let limit = (reach + tube) * self.radius;
            let problem = format!("below {limit:.5e}, where the tube touches itself");
            ("tube_radius", problem)
        })
    }

    fn lengths(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("radius", self.radius),
            ("tube_radius", self.tube_radius),
            ("pitch", self.pitch.abs() * self.turns.max(1.0)),
        ]
    }

    fn bounding_radius(&self) -> f64 {
        self.radius.hypot(0.5 * self.pitch * self.turns) + self.tube_radius
    }

    fn size_radius(&self) -> f64 {
        self.tube_radius
    }

    /// That of a tube along the curve, with half balls at the ends.
    fn volume(&self) -> f64 {
        let length = self.turns * (TAU * self.radius).hypot(self.pitch);
        PI * self.tube_radius * self.tube_radius * length + BALL * self.tube_radius.powi(3)
    }

    /// On the line through the position and the middle of the curve: with the curvature `k` of the
    /// curve and a tube of the radius `b` the first moment of a piece is `π b^2 + k π b^4 / 4`
    /// outwards over the radius, because the outer side of a bent tube is longer (Pappus), and the
    /// half balls at the ends have their centroids `3/8 b` beyond the ends.
    fn centroid(&self) -> Vector3<f64> {
        let (radius, b) = (self.radius, self.tube_radius);
        let speed = radius.hypot(self.pitch / TAU);
        let curvature = radius / (speed * speed);
        let (sin, cos) = (PI * self.turns).sin_cos();
        let of_tube = PI * b * b * (radius + 0.25 * curvature * b * b) * speed * 2.0 * sin;
        let of_end = radius * cos - 0.375 * b * radius / speed * sin;
        let of_ends = 4.0 / 3.0 * PI * b.powi(3) * of_end;
        Vector3::y() * ((of_tube + of_ends) / self.volume())
    }

    fn centreline(&self) -> Vec<(Vector3<f64>, f64)> {
        helix_points(
            &self.orientation(),
            [self.radius, self.tube_radius, self.pitch, self.turns],
        )
    }

    fn support_point(&self, n: &Vector3<f64>) -> Vector3<f64> {
        self.farthest_of_curve(n) + self.tube_radius * n
    }

    /// That of the cylinder around the helix.
    fn transverse_support_distance(&self, n: &Vector3<f64>) -> f64 {
        0.5 * (self.pitch * self.turns).abs() * n.y.hypot(n.z) + self.radius + self.tube_radius
    }

    fn surface(&self, pose: Isometry3<f64>, unit: f64) -> Option<Box<dyn Surface>> {
        let [radius, pitch, tube] =
            [self.radius, self.pitch, self.tube_radius].map(|length| length / unit);
        placed(pose, mesher::Helix::new(radius, pitch, self.turns, tube))
    }
}

impl HelixShape {
    /// The point of the curve `(h t, R cos t, R sin t)`, `|t| <= pi turns`, farthest in direction
    /// `n`.
    ///
    /// The candidates are the ends and, on each turn, the point with
    /// `n_x h = R |n_yz| sin(t - phase)` at which the distance has a maximum.
    fn farthest_of_curve(&self, n: &Vector3<f64>) -> Vector3<f64> {
        let radius = self.radius;
        let (rise, end) = (self.pitch / TAU, PI * self.turns);
        let at = |t: f64| Vector3::new(rise * t, radius * t.cos(), radius * t.sin());
        let better = |a: Vector3<f64>, b: Vector3<f64>| if b.dot(n) > a.dot(n) { b } else { a };
        let mut best = better(at(-end), at(end));
        let phase = n.z.atan2(n.y);
        let slope = rise * n.x / (radius * n.y.hypot(n.z)).max(f64::MIN_POSITIVE);
        if slope.abs() <= 1.0 {
            // The maxima lie one turn apart, and of two the one farther along n_x is higher.
            let first = phase + slope.asin();
            let last = first + TAU * ((end - first) / TAU).floor();
            let earliest = first - TAU * ((end + first) / TAU).floor();
            for t in [last, earliest] {
                if t.abs() <= end {
                    best = better(best, at(t));
                }
            }
        }
        best
    }
}
