//! Spheroids on the axis: the shapes of bodies and the outlines of their collars.

use crate::curve::{BoundaryPart, Curve, Point};

/// A spheroid whose axis of revolution is the axis of the flow; a sphere if the semi-axes are
/// equal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxialSpheroid {
    /// Position of the centre on the axis.
    pub centre: f64,
    /// Semi-axis along the axis of the flow.
    pub axial: f64,
    /// Semi-axis perpendicular to it.
    pub equatorial: f64,
}

impl AxialSpheroid {
    /// The sphere with this centre and radius.
    pub fn sphere(centre: f64, radius: f64) -> Self {
        Self {
            centre,
            axial: radius,
            equatorial: radius,
        }
    }

    /// Volume of the body.
    pub fn volume(&self) -> f64 {
        4.0 / 3.0 * std::f64::consts::PI * self.axial * self.equatorial.powi(2)
    }

    /// The same spheroid with its centre at the origin.
    pub(crate) fn centred(self) -> Self {
        Self {
            centre: 0.0,
            ..self
        }
    }

    /// The confocal spheroid whose larger semi-axis is `ratio` times as long.
    pub(crate) fn confocal_spheroid(&self, ratio: f64) -> Self {
        let square = self.axial * self.axial - self.equatorial * self.equatorial;
        let larger = ratio * self.axial.max(self.equatorial);
        let smaller = (larger * larger - square.abs()).sqrt();
        let [axial, equatorial] = match square > 0.0 {
            true => [larger, smaller],
            false => [smaller, larger],
        };
        Self {
            centre: self.centre,
            axial,
            equatorial,
        }
    }

    /// The confocal coordinate, half the sum of the distances to the foci, and its gradient.
    fn confocal(&self, x: &Point) -> (f64, Point) {
        let square = self.axial * self.axial - self.equatorial * self.equatorial;
        let c = square.abs().sqrt();
        let focus = if square > 0.0 {
            Point::new(c, 0.0)
        } else {
            Point::new(0.0, c)
        };
        let centre = Point::new(self.centre, 0.0);
        let [one, other] = [x - centre - focus, x - centre + focus];
        let direction = |v: Point| v.try_normalize(0.0).unwrap_or_default();
        (
            0.5 * (one.norm() + other.norm()),
            0.5 * (direction(one) + direction(other)),
        )
    }

    /// Signed distance to the surface, accurate to first order near it; negative inside.
    pub(crate) fn distance(&self, x: &Point) -> f64 {
        let (coordinate, gradient) = self.confocal(x);
        let outside = coordinate - self.axial.max(self.equatorial);
        outside / gradient.norm().max(f64::MIN_POSITIVE)
    }

    /// Distance to the segment or disc between the foci.
    ///
    /// This set contains the singularities of the analytic continuation of the exterior flow.
    pub(crate) fn focal_distance(&self, x: &Point) -> f64 {
        let square = self.axial * self.axial - self.equatorial * self.equatorial;
        let c = square.abs().sqrt();
        let from_centre = Point::new(x.x - self.centre, x.y);
        let (along, across) = match square > 0.0 {
            true => (from_centre.x.abs(), from_centre.y),
            false => (from_centre.y.abs(), from_centre.x),
        };
        (along - c).max(0.0).hypot(across)
    }

    /// The boundary curve from the left pole to the right one.
    pub(crate) fn upper_half(&self, part: BoundaryPart) -> Curve {
        Curve::HalfEllipse {
            centre: self.centre,
            axial: self.axial,
            equatorial: self.equatorial,
            leftward: false,
            part,
        }
    }

    /// The boundary curve from the right pole to the left one.
    pub(crate) fn upper_half_leftward(&self, part: BoundaryPart) -> Curve {
        Curve::HalfEllipse {
            centre: self.centre,
            axial: self.axial,
            equatorial: self.equatorial,
            leftward: true,
            part,
        }
    }
}
