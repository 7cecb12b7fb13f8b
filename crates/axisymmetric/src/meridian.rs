//! The meridian domain: bodies, wall, distances to them and the target element size.

use crate::AxisymmetricError;
use crate::axial_shape::AxialShape;
use crate::curve::{BoundaryPart, Curve, MIN_CURVED_EDGES, Point};
use crate::spheroid::AxialSpheroid;

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

/// Edge length relative to the distance from the focus of the nearest body.
///
/// Shorter edges need more degrees of freedom for the same error, longer ones a higher order.
pub(crate) const GROWTH: f64 = 0.65;

/// Factor on [`GROWTH`] at the surface of a body.
///
/// The flow varies most along surfaces. For three spheres this factor, with [`GRADING`], divides
/// the error of order eight by 270, with a tenth more triangles.
const SIZE_AT_SURFACE: f64 = 0.6;

/// Increase of an edge over [`GROWTH`] per distance from the surface of a body.
const GRADING: f64 = 0.5;

/// Radius of the ball beyond which unbounded fluid or a large ball is not meshed, relative to the
/// radius of the smallest ball around the bodies with the same centre.
pub(crate) const OPEN_RADIUS_RATIO: f64 = 1.5;

/// Smallest radius of a ball around that sphere, relative to its radius, in which the mesh ends
/// there.
const MIN_WALL_RATIO: f64 = 1.2;

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

/// Largest ratio of the semi-axes of a body; the number of triangles is 30 times the ratio.
pub const MAX_ASPECT: f64 = 500.0;

/// Largest length of the problem relative to the smallest semi-axis.
const MAX_LENGTH_RATIO: f64 = 1e6;

/// Bodies on an axis and the wall that bounds the computed flow.
#[derive(Clone, Debug)]
pub(crate) struct Meridian {
    /// Bodies from left to right.
    bodies: Vec<AxialShape>,
    /// Index of each body in the caller's list.
    given: Vec<usize>,
    /// Outer boundary of the collar of each body; `None` for a body whose surface is meshed.
    outlines: Vec<Option<AxialSpheroid>>,
    wall: Wall,
}

/// A sphere where the mesh ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OpenSphere {
    pub centre: f64,
    pub radius: f64,
    /// Radius of the ball with the same centre that bounds the fluid; infinite without one.
    pub wall: f64,
}

#[derive(Clone, Copy, Debug)]
enum Wall {
    /// No slip on a sphere.
    Ball { centre: f64, radius: f64 },
    /// No slip on a cylinder and its plane ends.
    Tube { from: f64, to: f64, radius: f64 },
    /// A sphere in the fluid, beyond which the flow is known.
    Open(OpenSphere),
    /// The outline of a collar.
    Outline(AxialSpheroid),
}

impl Meridian {
    /// The domain around `bodies`.
    ///
    /// # Errors
    /// [`AxisymmetricError`] for sizes that are not positive and finite, and for bodies that touch
    /// each other or the wall.
    pub fn new(
        bodies: &[AxialSpheroid],
        surroundings: Surroundings,
    ) -> Result<Self, AxisymmetricError> {
        let shapes: Vec<AxialShape> = bodies.iter().map(|body| (*body).into()).collect();
        Self::around(&shapes, surroundings)
    }

    /// As [`Meridian::new`], for bodies of any shape.
    ///
    /// # Errors
    /// Those of [`Meridian::new`].
    pub fn around(
        bodies: &[AxialShape],
        surroundings: Surroundings,
    ) -> Result<Self, AxisymmetricError> {
        if bodies.is_empty() {
            return Err(AxisymmetricError::NoBodies);
        }
        let spheroids: Vec<AxialSpheroid> = bodies.iter().map(|body| body.spheroid).collect();
        for (i, body) in spheroids.iter().enumerate() {
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
        check_sizes(&spheroids, surroundings)?;
        let mut given: Vec<usize> = (0..bodies.len()).collect();
        given.sort_by(|&i, &j| bodies[i].centre().total_cmp(&bodies[j].centre()));
        let sorted: Vec<AxialShape> = given.iter().map(|&i| bodies[i]).collect();
        for (pair, numbers) in sorted.windows(2).zip(given.windows(2)) {
            let gap = pair[1].left() - pair[0].right();
            let [one, other] = [0, 1].map(|k| pair[k].spheroid.equatorial);
            if gap.is_nan() || gap < MIN_GAP * one.min(other) {
                return Err(AxisymmetricError::BodiesTooClose {
                    bodies: [numbers[0], numbers[1]],
                    gap,
                    limit: MIN_GAP,
                });
            }
        }
        let from = sorted[0].left();
        let to = sorted[sorted.len() - 1].right();
        let wall = match surroundings {
            Surroundings::Unbounded => Wall::Open(OpenSphere {
                centre: 0.5 * (from + to),
                radius: OPEN_RADIUS_RATIO * enclosing_radius(&sorted, 0.5 * (from + to)),
                wall: f64::INFINITY,
            }),
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
            outlines: vec![None; sorted.len()],
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
            if gap.is_nan() || gap < MIN_GAP * body.spheroid.equatorial {
                return Err(AxisymmetricError::WallTooClose {
                    body: *number,
                    gap,
                    limit: MIN_GAP,
                });
            }
        }
        Ok(meridian)
    }

    /// The same domain with a larger ball where the mesh of unbounded fluid ends.
    pub fn enlarged(mut self, factor: f64) -> Self {
        if let Wall::Open(sphere) = &mut self.wall {
            sphere.radius *= factor;
        }
        self
    }

    /// The domain between a body and the outline of its collar, both with their centre at zero.
    pub fn from_collar(body: AxialSpheroid, outline: AxialSpheroid) -> Self {
        Self {
            bodies: vec![body.centred().into()],
            given: vec![0],
            outlines: vec![None],
            wall: Wall::Outline(outline.centred()),
        }
    }

    /// The same domain without the collars that its bodies have room for, and without the fluid far
    /// from the bodies in a large ball, where the flow is a series.
    ///
    /// A collar is confocal with its body and has one of a few sizes, so that it seldom changes
    /// when bodies move. Its outline is at most as close to other bodies as to its own, and
    /// elements on both sides of it have similar sizes.
    pub fn meshed_part(mut self) -> Self {
        if let Wall::Ball {
            centre,
            radius: wall,
        } = self.wall
        {
            let radius = OPEN_RADIUS_RATIO * enclosing_radius(&self.bodies, centre);
            if wall > MIN_WALL_RATIO * radius {
                self.wall = Wall::Open(OpenSphere {
                    centre,
                    radius,
                    wall,
                });
            }
        }
        self.outlines = (0..self.bodies.len())
            .map(|i| {
                let mut outlines = (0..COLLAR_SIZES)
                    .rev()
                    .map(|k| self.bodies[i].spheroid.confocal_spheroid(collar_ratio(k)));
                outlines
                    .find(|outline| self.has_room_for(i, outline))
                    .filter(|_| !self.bodies[i].is_deformed())
            })
            .collect();
        self
    }

    /// Whether a collar of body `i` may have this outline.
    fn has_room_for(&self, i: usize, outline: &AxialSpheroid) -> bool {
        let body = &self.bodies[i];
        let neighbours = [i.checked_sub(1), Some(i + 1)].into_iter().flatten();
        let clear_of_neighbours = neighbours.filter_map(|j| self.bodies.get(j)).all(|other| {
            let gap = (other.left() - body.right()).max(body.left() - other.right());
            outline.axial - body.spheroid.axial <= MAX_COLLAR_SHARE * gap
        });
        clear_of_neighbours
            && (outline.upper_half(BoundaryPart::Axis).samples()).all(|x| {
                let size = GROWTH * relative_size(body, &x);
                size <= MAX_COLLAR_SIZE_RATIO * self.size(&x, GROWTH)
                    && self.distance_to_wall(&x) >= MIN_COLLAR_CLEARANCE * size
            })
    }

    /// Bodies with collars, from left to right: index in the caller's list, body and outline.
    pub fn collars(&self) -> impl Iterator<Item = (usize, AxialSpheroid, AxialSpheroid)> + '_ {
        (self.given.iter().zip(&self.bodies).zip(&self.outlines))
            .filter_map(|((&given, body), outline)| outline.map(|o| (given, body.spheroid, o)))
    }

    /// The sphere in the fluid where the mesh ends.
    pub fn open_sphere(&self) -> Option<OpenSphere> {
        match self.wall {
            Wall::Open(sphere) => Some(sphere),
            _ => None,
        }
    }

    /// Radius of the sphere in the fluid where the mesh ends.
    pub fn open_radius(&self) -> Option<f64> {
        self.open_sphere().map(|sphere| sphere.radius)
    }

    /// The closed boundary of the meridian domain, with the domain on its left.
    ///
    /// Each curve comes with the parameters at which it is divided into edges, if they are given.
    pub fn boundary(&self) -> Vec<(Curve, Option<Vec<f64>>)> {
        let (from, to) = match self.wall {
            Wall::Ball { centre, radius } | Wall::Open(OpenSphere { centre, radius, .. }) => {
                (centre - radius, centre + radius)
            }
            Wall::Tube { from, to, .. } => (from, to),
            Wall::Outline(outline) => (-outline.axial, outline.axial),
        };
        let on_axis = |x: f64| Point::new(x, 0.0);
        let line = |from, to, part| (Curve::Line { from, to, part }, None);
        let mut curves = Vec::new();
        let mut at = on_axis(from);
        for ((body, &number), outline) in self.bodies.iter().zip(&self.given).zip(&self.outlines) {
            let (shape, curve) = match outline {
                Some(outline) => {
                    let curve = outline.upper_half(BoundaryPart::Interface(number));
                    let division = outline_division(&body.spheroid, outline);
                    (AxialShape::from(*outline), (curve, Some(division)))
                }
                None => (*body, (body.upper_half(BoundaryPart::Body(number)), None)),
            };
            curves.push(line(at, on_axis(shape.left()), BoundaryPart::Axis));
            curves.push(curve);
            at = on_axis(shape.right());
        }
        curves.push(line(at, on_axis(to), BoundaryPart::Axis));
        match self.wall {
            Wall::Ball { centre, radius } => {
                let ball = AxialSpheroid::sphere(centre, radius);
                curves.push((ball.upper_half_leftward(BoundaryPart::Wall), None));
            }
            Wall::Open(OpenSphere { centre, radius, .. }) => {
                let ball = AxialSpheroid::sphere(centre, radius);
                curves.push((ball.upper_half_leftward(BoundaryPart::Open), None));
            }
            Wall::Outline(outline) => {
                let division = outline_division(&self.bodies[0].spheroid, &outline);
                let reversed = division.into_iter().rev().map(|t| 1.0 - t).collect();
                let curve = outline.upper_half_leftward(BoundaryPart::Open);
                curves.push((curve, Some(reversed)));
            }
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
    /// It is `growth` times the distance to the nearest singularity of the continued flow, less
    /// near a surface, and at most [`MAX_SIZE_IN_GAP`] times the width of the gap between the two
    /// nearest surfaces.
    pub fn size(&self, x: &Point, growth: f64) -> f64 {
        let mut size = match self.wall {
            Wall::Tube { radius, .. } => growth * radius,
            _ => f64::INFINITY,
        };
        let to_wall = match self.wall {
            Wall::Ball { .. } | Wall::Tube { .. } => self.distance_to_wall(x).max(0.0),
            Wall::Open(_) | Wall::Outline(_) => f64::INFINITY,
        };
        let mut nearest = [to_wall, f64::INFINITY];
        nearest.sort_by(f64::total_cmp);
        for body in &self.bodies {
            size = size.min(growth * relative_size(body, x));
            let distance = body.distance(x).max(0.0);
            if distance < nearest[0] {
                nearest = [distance, nearest[0]];
            } else {
                nearest[1] = nearest[1].min(distance);
            }
        }
        size.min(MAX_SIZE_IN_GAP * (nearest[0] + nearest[1]))
    }

    /// Whether a point is in the interior of the fluid.
    pub fn contains(&self, x: &Point) -> bool {
        x.y > 0.0
            && self.distance_to_wall(x) > 0.0
            && (self.bodies.iter().zip(&self.outlines)).all(|(body, outline)| match outline {
                Some(outline) => outline.distance(x) > 0.0,
                None => body.distance(x) > 0.0,
            })
    }

    fn distance_to_wall(&self, x: &Point) -> f64 {
        match self.wall {
            Wall::Ball { centre, radius } | Wall::Open(OpenSphere { centre, radius, .. }) => {
                radius - (x.x - centre).hypot(x.y)
            }
            Wall::Tube { from, to, radius } => (radius - x.y).min(x.x - from).min(to - x.x),
            Wall::Outline(outline) => -outline.distance(x),
        }
    }
}

/// Fails if lengths differ so much that meshes are too large or positions are rounded too much.
fn check_sizes(
    bodies: &[AxialSpheroid],
    surroundings: Surroundings,
) -> Result<(), AxisymmetricError> {
    let fold = |f: fn(f64, f64) -> f64, lengths: &dyn Fn(&AxialSpheroid) -> f64| {
        bodies.iter().map(lengths).reduce(f).unwrap_or(0.0)
    };
    let smallest = fold(f64::min, &|b| b.axial.min(b.equatorial));
    let right = fold(f64::max, &|b| b.centre + b.axial.max(b.equatorial));
    let left = fold(f64::min, &|b| b.centre - b.axial.max(b.equatorial));
    let largest = match surroundings {
        Surroundings::Unbounded => right - left,
        Surroundings::Ball { radius } => radius,
        Surroundings::Cylinder { radius } => radius.max(right - left),
    };
    for (i, body) in bodies.iter().enumerate() {
        let aspect = body.axial.max(body.equatorial) / body.axial.min(body.equatorial);
        if aspect > MAX_ASPECT {
            return Err(AxisymmetricError::TooSlender {
                body: i,
                aspect,
                limit: MAX_ASPECT,
            });
        }
    }
    let ratio = largest / smallest;
    if ratio <= MAX_LENGTH_RATIO {
        return Ok(());
    }
    Err(AxisymmetricError::SizesTooDifferent {
        ratio,
        limit: MAX_LENGTH_RATIO,
    })
}

/// Target edge length around a body alone, relative to [`GROWTH`].
fn relative_size(body: &AxialShape, x: &Point) -> f64 {
    let focal = body.focal_distance(x);
    focal.min(SIZE_AT_SURFACE * focal + GRADING * body.distance(x).max(0.0))
}

/// Parameters at which the outline of a body's collar is divided into edges.
///
/// They are the same on both sides of the outline.
fn outline_division(body: &AxialSpheroid, outline: &AxialSpheroid) -> Vec<f64> {
    let (body, outline) = (body.centred(), outline.centred());
    let body = AxialShape::from(body);
    let size = |x: &Point| GROWTH * relative_size(&body, x);
    outline
        .upper_half(BoundaryPart::Axis)
        .divide(MIN_CURVED_EDGES, size)
}

/// Radius of the smallest ball with this centre around bodies.
fn enclosing_radius(bodies: &[AxialShape], centre: f64) -> f64 {
    let surface = |body: &AxialShape| body.upper_half(BoundaryPart::Axis);
    (bodies.iter())
        .flat_map(|body| surface(body).samples().collect::<Vec<_>>())
        .map(|x| (x.x - centre).hypot(x.y))
        .fold(0.0, f64::max)
}

/// Number of sizes of collars.
const COLLAR_SIZES: i32 = 4;

/// Larger semi-axis of a collar relative to that of its body; `k` is below [`COLLAR_SIZES`].
fn collar_ratio(k: i32) -> f64 {
    1.5 * 1.5_f64.powi(k)
}

/// Largest width of a collar relative to the gap to the next body.
const MAX_COLLAR_SHARE: f64 = 0.32;

/// Largest ratio of the element sizes inside and outside the outline of a collar.
const MAX_COLLAR_SIZE_RATIO: f64 = 1.25;

/// Smallest distance of a collar from the wall relative to the size of its elements.
const MIN_COLLAR_CLEARANCE: f64 = 0.5;

/// Largest element size in a gap, relative to its width.
const MAX_SIZE_IN_GAP: f64 = 0.75;
