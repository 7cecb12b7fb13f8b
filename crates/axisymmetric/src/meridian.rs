//! What lies on the axis and what surrounds it: shapes, distances and the size that elements should have.

use nalgebra::Vector2;

use crate::AxisymmetricError;
use crate::curve::Curve;

/// A point of the meridian half-plane: along the axis, and away from it.
pub(crate) type Point = Vector2<f64>;

/// A spheroid whose axis of revolution is the axis of the flow; a sphere where both semi-axes are equal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spheroid {
    /// Place of the centre on the axis.
    pub centre: f64,
    /// Semi-axis along the axis.
    pub axial: f64,
    /// Semi-axis across it.
    pub equatorial: f64,
}

/// What surrounds the bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surroundings {
    /// Nothing.
    Unbounded,
    /// A ball about the origin of the axis, with no slip.
    Ball {
        /// Radius.
        radius: f64,
    },
    /// An infinite circular cylinder about the axis, with no slip and the fluid at rest far away.
    Cylinder {
        /// Radius.
        radius: f64,
    },
}

/// Radius of the ball that stands for unbounded fluid over half the length of what is in it. What its exact image
/// to first order leaves is of the order of the third power of the inverse.
const FAR: f64 = 1000.0;

/// The narrowest gap over a radius: elements along it grow in number as its root falls, to some hundred here.
const LEAST_GAP: f64 = 1e-4;

/// Length of a cylinder beyond the bodies over its radius: axisymmetric flow decays by `exp(-4.466 z / radius)` (first root of
/// $\lambda (J_0^2 + J_1^2) = 2 J_0 J_1$), to 2e-9 there.
const CYLINDER_ENDS: f64 = 4.5;

/// Bodies on an axis and the wall that the computed flow ends at.
#[derive(Clone, Debug)]
pub(crate) struct Meridian {
    /// From the left to the right.
    bodies: Vec<Spheroid>,
    /// Place of each of them among the bodies given.
    given: Vec<usize>,
    wall: Wall,
}

#[derive(Clone, Copy, Debug)]
enum Wall {
    Ball { centre: f64, radius: f64 },
    Tube { from: f64, to: f64, radius: f64 },
}

/// What a piece of the boundary belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Side {
    Axis,
    Wall,
    /// The number of the body among those given.
    Body(usize),
}

impl Spheroid {
    /// A sphere.
    pub fn sphere(centre: f64, radius: f64) -> Self {
        Self {
            centre,
            axial: radius,
            equatorial: radius,
        }
    }

    /// Sum of the distances to the foci, halved, and the mean of the directions from them: the confocal coordinate and its gradient.
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

    /// About the distance to the surface, to first order; negative inside.
    fn distance(&self, x: &Point) -> f64 {
        let (coordinate, gradient) = self.confocal(x);
        let outside = coordinate - self.axial.max(self.equatorial);
        outside / gradient.norm().max(f64::MIN_POSITIVE)
    }

    /// Distance to the segment or disc between the foci, where the flow outside would be singular if it were continued.
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
    /// # Errors
    /// [`AxisymmetricError`] for sizes that are not positive and finite, and bodies that touch each other or the wall.
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
            if gap.is_nan() || gap < LEAST_GAP * pair[0].equatorial.min(pair[1].equatorial) {
                return Err(AxisymmetricError::BodiesTooClose {
                    bodies: [numbers[0], numbers[1]],
                    gap,
                    limit: LEAST_GAP,
                });
            }
        }
        let from = sorted[0].centre - sorted[0].axial;
        let last = sorted[sorted.len() - 1];
        let to = last.centre + last.axial;
        let widest = bodies.iter().map(|b| b.equatorial).fold(0.0, f64::max);
        let wall = match surroundings {
            Surroundings::Unbounded => Wall::Ball {
                centre: 0.5 * (from + to),
                radius: FAR * (0.5 * (to - from)).max(widest),
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
                .upper_half(Side::Body(*number))
                .samples()
                .map(|x| meridian.distance_to_wall(&x))
                .fold(f64::INFINITY, f64::min);
            if gap.is_nan() || gap < LEAST_GAP * body.equatorial {
                return Err(AxisymmetricError::WallTooClose {
                    body: *number,
                    gap,
                    limit: LEAST_GAP,
                });
            }
        }
        Ok(meridian)
    }

    /// Half the length of everything on the axis, and its largest radius.
    pub fn extent(&self) -> [f64; 2] {
        let last = self.bodies[self.bodies.len() - 1];
        let length = last.centre + last.axial - self.bodies[0].centre + self.bodies[0].axial;
        let radii = self.bodies.iter().map(|body| body.equatorial);
        [0.5 * length, radii.fold(0.0, f64::max)]
    }

    /// Radius of the ball around; none for a tube.
    pub fn ball_radius(&self) -> Option<f64> {
        match self.wall {
            Wall::Ball { radius, .. } => Some(radius),
            Wall::Tube { .. } => None,
        }
    }

    /// The closed boundary of the meridian domain, which lies to its left.
    pub fn boundary(&self) -> Vec<Curve> {
        let (from, to) = match self.wall {
            Wall::Ball { centre, radius } => (centre - radius, centre + radius),
            Wall::Tube { from, to, .. } => (from, to),
        };
        let on_axis = |x: f64| Point::new(x, 0.0);
        let line = |from, to, side| Curve::Line { from, to, side };
        let mut curves = Vec::new();
        let mut at = on_axis(from);
        for (body, number) in self.bodies.iter().zip(&self.given) {
            let left = on_axis(body.centre - body.axial);
            curves.push(line(at, left, Side::Axis));
            curves.push(body.upper_half(Side::Body(*number)));
            at = on_axis(body.centre + body.axial);
        }
        curves.push(line(at, on_axis(to), Side::Axis));
        match self.wall {
            Wall::Ball { centre, radius } => curves.push(Curve::HalfEllipse {
                centre,
                axial: radius,
                equatorial: radius,
                leftward: true,
                side: Side::Wall,
            }),
            Wall::Tube { from, to, radius } => {
                let corners = [(to, 0.0), (to, radius), (from, radius), (from, 0.0)];
                let corners = corners.map(|(x, y)| Point::new(x, y));
                curves.extend(corners.windows(2).map(|c| line(c[0], c[1], Side::Wall)));
            }
        }
        curves
    }

    /// Edge length wanted at a point: `growth` times the distance to the nearest continued singularity, and not more than the room
    /// between the two nearest surfaces.
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

    /// Whether a point is in the fluid and not on its boundary.
    pub fn holds(&self, x: &Point) -> bool {
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

/// Elements in a gap, as a part of its width.
const GAP: f64 = 0.75;

impl Spheroid {
    /// From the left pole to the right one.
    fn upper_half(&self, side: Side) -> Curve {
        Curve::HalfEllipse {
            centre: self.centre,
            axial: self.axial,
            equatorial: self.equatorial,
            leftward: false,
            side,
        }
    }
}
