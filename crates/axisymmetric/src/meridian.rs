//! The meridian domain: bodies, wall, distances to them and the target element size.

use crate::AxisymmetricError;
use crate::curve::{BoundaryPart, Curve};
use crate::point::Point;

/// A spheroid whose axis of revolution is the axis of the flow; a sphere if the semi-axes are
/// equal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spheroid {
    /// Position of the centre on the axis.
    pub centre: f64,
    /// Semi-axis along the axis of the flow.
    pub axial: f64,
    /// Semi-axis perpendicular to it.
    pub equatorial: f64,
}

/// The container around the bodies, if any.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surroundings {
    /// Unbounded fluid, at rest at infinity.
    Unbounded,
    /// A ball centred at the origin of the axis, with no slip on its wall.
    Ball {
        /// Radius.
        radius: f64,
    },
    /// An infinite circular cylinder about the axis, with no slip on its wall and fluid at rest
    /// far from the bodies.
    Cylinder {
        /// Radius.
        radius: f64,
    },
}

/// Radius of the ball that replaces unbounded fluid, relative to half the length of the bodies.
///
/// After the first-order correction for this ball its relative error is of order `FAR^-3`.
const FAR: f64 = 1000.0;

/// Smallest gap supported, relative to a radius.
///
/// The number of elements along a gap grows with the inverse square root of its width, to about a
/// hundred here.
const MIN_GAP: f64 = 1e-4;

/// Length of a cylinder beyond the bodies at each end, relative to its radius.
///
/// Axisymmetric flow decays as `exp(-4.466 z / radius)`, where 4.466 is the first root λ of
/// `λ (J_0^2 + J_1^2) = 2 J_0 J_1`; that is 2e-9 at this length.
const CYLINDER_ENDS: f64 = 4.5;

/// Bodies on an axis and the wall that bounds the computed flow.
#[derive(Clone, Debug)]
pub(crate) struct Meridian {
    /// Bodies from left to right.
    bodies: Vec<Spheroid>,
    /// Index of each body in the caller's list.
    given: Vec<usize>,
    wall: Wall,
}

#[derive(Clone, Copy, Debug)]
enum Wall {
    Ball { centre: f64, radius: f64 },
    Tube { from: f64, to: f64, radius: f64 },
}

impl Spheroid {
    /// The sphere with this centre and radius.
    pub fn sphere(centre: f64, radius: f64) -> Self {
        Self {
            centre,
            axial: radius,
            equatorial: radius,
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
    fn distance(&self, x: &Point) -> f64 {
        let (coordinate, gradient) = self.confocal(x);
        let outside = coordinate - self.axial.max(self.equatorial);
        outside / gradient.norm().max(f64::MIN_POSITIVE)
    }

    /// Distance to the segment or disc between the foci.
    ///
    /// This set contains the singularities of the analytic continuation of the exterior flow.
    fn focal_distance(&self, x: &Point) -> f64 {
        let square = self.axial * self.axial - self.equatorial * self.equatorial;
        let c = square.abs().sqrt();
        let from_centre = Point::new(x.x - self.centre, x.y);
        let (along, across) = match square > 0.0 {
            true => (from_centre.x.abs(), from_centre.y),
            false => (from_centre.y.abs(), from_centre.x),
        };
        (along - c).max(0.0).hypot(across)
    }
}

impl Meridian {
    /// The domain around `bodies`.
    ///
    /// # Errors
    /// [`AxisymmetricError`] for sizes that are not positive and finite, and for bodies that touch
    /// each other or the wall.
    pub fn new(bodies: &[Spheroid], surroundings: Surroundings) -> Result<Self, AxisymmetricError> {
        if bodies.is_empty() {
            return Err(AxisymmetricError::NoBodies);
        }
        for (i, body) in bodies.iter().enumerate() {
            let semi_axes = [body.axial, body.equatorial];
            if !(body.centre.is_finite() && semi_axes.iter().all(|s| *s > 0.0 && s.is_finite())) {
                return Err(AxisymmetricError::InvalidBody {
                    body: i,
                    centre: body.centre,
                    semi_axes,
                });
            }
        }
        if let Surroundings::Ball { radius } | Surroundings::Cylinder { radius } = surroundings
            && !(radius > 0.0 && radius.is_finite())
        {
            return Err(AxisymmetricError::InvalidWall { radius });
        }
        let mut given: Vec<usize> = (0..bodies.len()).collect();
        given.sort_by(|&i, &j| bodies[i].centre.total_cmp(&bodies[j].centre));
        let sorted: Vec<Spheroid> = given.iter().map(|&i| bodies[i]).collect();
        for (pair, numbers) in sorted.windows(2).zip(given.windows(2)) {
            let gap = pair[1].centre - pair[1].axial - pair[0].centre - pair[0].axial;
            if gap.is_nan() || gap < MIN_GAP * pair[0].equatorial.min(pair[1].equatorial) {
                return Err(AxisymmetricError::BodiesTooClose {
                    bodies: [numbers[0], numbers[1]],
                    gap,
                    limit: MIN_GAP,
                });
            }
        }
        let from = sorted[0].centre - sorted[0].axial;
        let last = sorted[sorted.len() - 1];
        let to = last.centre + last.axial;
        let largest_radius = bodies.iter().map(|b| b.equatorial).fold(0.0, f64::max);
        let wall = match surroundings {
            Surroundings::Unbounded => Wall::Ball {
                centre: 0.5 * (from + to),
                radius: FAR * (0.5 * (to - from)).max(largest_radius),
            },
            Surroundings::Ball { radius } => Wall::Ball {
                centre: 0.0,
                radius,
            },
            Surroundings::Cylinder { radius } => Wall::Tube {
                from: from - CYLINDER_ENDS * radius,
                to: to + CYLINDER_ENDS * radius,
                radius,
            },
        };
        let meridian = Self {
            bodies: sorted,
            given,
            wall,
        };
        for (body, number) in meridian.bodies.iter().zip(&meridian.given) {
            let gap = body
                .upper_half(BoundaryPart::Body(*number))
                .samples()
                .map(|x| meridian.distance_to_wall(&x))
                .fold(f64::INFINITY, f64::min);
            if gap.is_nan() || gap < MIN_GAP * body.equatorial {
                return Err(AxisymmetricError::WallTooClose {
                    body: *number,
                    gap,
                    limit: MIN_GAP,
                });
            }
        }
        Ok(meridian)
    }

    /// Half the length from the first body's left pole to the last one's right, and the largest
    /// radius.
    pub fn extent(&self) -> [f64; 2] {
        let last = self.bodies[self.bodies.len() - 1];
        let length = last.centre + last.axial - self.bodies[0].centre + self.bodies[0].axial;
        let radii = self.bodies.iter().map(|body| body.equatorial);
        [0.5 * length, radii.fold(0.0, f64::max)]
    }

    /// Radius of the surrounding ball; `None` for a tube.
    pub fn ball_radius(&self) -> Option<f64> {
        match self.wall {
            Wall::Ball { radius, .. } => Some(radius),
            Wall::Tube { .. } => None,
        }
    }

    /// The closed boundary of the meridian domain, with the domain on its left.
    pub fn boundary(&self) -> Vec<Curve> {
        let (from, to) = match self.wall {
            Wall::Ball { centre, radius } => (centre - radius, centre + radius),
            Wall::Tube { from, to, .. } => (from, to),
        };
        let on_axis = |x: f64| Point::new(x, 0.0);
        let line = |from, to, part| Curve::Line { from, to, part };
        let mut curves = Vec::new();
        let mut at = on_axis(from);
        for (body, number) in self.bodies.iter().zip(&self.given) {
            let left = on_axis(body.centre - body.axial);
            curves.push(line(at, left, BoundaryPart::Axis));
            curves.push(body.upper_half(BoundaryPart::Body(*number)));
            at = on_axis(body.centre + body.axial);
        }
        curves.push(line(at, on_axis(to), BoundaryPart::Axis));
        match self.wall {
            Wall::Ball { centre, radius } => curves.push(Curve::HalfEllipse {
                centre,
                axial: radius,
                equatorial: radius,
                leftward: true,
                part: BoundaryPart::Wall,
            }),
            Wall::Tube { from, to, radius } => {
                let corners = [(to, 0.0), (to, radius), (from, radius), (from, 0.0)];
                let corners = corners.map(|(x, y)| Point::new(x, y));
                curves.extend(
                    corners
                        .windows(2)
                        .map(|c| line(c[0], c[1], BoundaryPart::Wall)),
                );
            }
        }
        curves
    }

    /// Target edge length at a point.
    ///
    /// It is `growth` times the distance to the nearest singularity of the continued flow, and at
    /// most [`GAP`] times the width of the gap between the two nearest surfaces.
    pub fn size(&self, x: &Point, growth: f64) -> f64 {
        let mut size = match self.wall {
            Wall::Ball { .. } => f64::INFINITY,
            Wall::Tube { radius, .. } => growth * radius,
        };
        let mut nearest = [self.distance_to_wall(x).max(0.0), f64::INFINITY];
        nearest.sort_by(f64::total_cmp);
        for body in &self.bodies {
            size = size.min(growth * body.focal_distance(x));
            let distance = body.distance(x).max(0.0);
            if distance < nearest[0] {
                nearest = [distance, nearest[0]];
            } else {
                nearest[1] = nearest[1].min(distance);
            }
        }
        size.min(GAP * (nearest[0] + nearest[1]))
    }

    /// Whether a point is in the interior of the fluid.
    pub fn contains(&self, x: &Point) -> bool {
        x.y > 0.0
            && self.distance_to_wall(x) > 0.0
            && self.bodies.iter().all(|body| body.distance(x) > 0.0)
    }

    fn distance_to_wall(&self, x: &Point) -> f64 {
        match self.wall {
            Wall::Ball { centre, radius } => radius - (x.x - centre).hypot(x.y),
            Wall::Tube { from, to, radius } => (radius - x.y).min(x.x - from).min(to - x.x),
        }
    }
}

/// Largest element size in a gap, relative to its width.
const GAP: f64 = 0.75;

impl Spheroid {
    /// The boundary curve from the left pole to the right one.
    fn upper_half(&self, part: BoundaryPart) -> Curve {
        Curve::HalfEllipse {
            centre: self.centre,
            axial: self.axial,
            equatorial: self.equatorial,
            leftward: false,
            part,
        }
    }
}
