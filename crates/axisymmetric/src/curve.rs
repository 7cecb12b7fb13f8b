//! Points of the meridian half-plane and the curves that bound the domain in it.

use std::f64::consts::PI;

use nalgebra::Vector2;

use crate::deformed_sphere::DeformedSphere;

/// A point `(z, r)` of the meridian half-plane: position along the axis and distance from it.
pub(crate) type Point = Vector2<f64>;

/// A boundary curve with a parameter from 0 to 1 and the domain on its left.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Curve {
    /// A straight line.
    Line {
        from: Point,
        to: Point,
        part: BoundaryPart,
    },
    /// The upper half of an ellipse centred on the axis, from one pole to the other.
    HalfEllipse {
        centre: f64,
        axial: f64,
        equatorial: f64,
        /// Whether it runs from the right pole to the left one.
        leftward: bool,
        part: BoundaryPart,
    },
    /// The upper half of a deformed sphere, from its left pole to its right one.
    Radial {
        sphere: DeformedSphere,
        part: BoundaryPart,
    },
}

/// Part of the boundary. The order of the variants matters: see [`crate::space::Space::parts`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum BoundaryPart {
    /// The outer boundary of a mesh that ends in the fluid.
    Open,
    /// The outline of the collar of the body with this index, inside which another mesh begins.
    Interface(usize),
    /// The axis of symmetry.
    Axis,
    /// The container's wall.
    Wall,
    /// The body with this index in the caller's list.
    Body(usize),
}

impl BoundaryPart {
    /// Whether the boundary is in the fluid, so that velocities on it are degrees of freedom.
    pub fn is_in_fluid(self) -> bool {
        matches!(self, Self::Open | Self::Interface(_))
    }
}

/// Smallest number of edges of a curve that is not straight.
pub(crate) const MIN_CURVED_EDGES: usize = 4;

/// Number of intervals at whose ends a curve is sampled.
const SAMPLE_INTERVALS: usize = 64;

/// Step length along a curve relative to the target edge length there.
const RELATIVE_STEP: f64 = 0.05;

impl Curve {
    pub fn part(&self) -> BoundaryPart {
        match self {
            Self::Line { part, .. }
            | Self::HalfEllipse { part, .. }
            | Self::Radial { part, .. } => *part,
        }
    }

    /// The point at parameter `t`. Ends on the axis are on it exactly.
    pub fn point(&self, t: f64) -> Point {
        match *self {
            Self::Line { from, to, .. } => from * (1.0 - t) + to * t,
            Self::HalfEllipse {
                centre,
                axial,
                equatorial,
                leftward,
                ..
            } => {
                let direction = if leftward { 1.0 } else { -1.0 };
                // sin(π) is not zero in floating point
                let y = if t == 0.0 || t == 1.0 {
                    0.0
                } else {
                    equatorial * (PI * t).sin()
                };
                Point::new(centre + direction * axial * (PI * t).cos(), y)
            }
            Self::Radial { sphere, .. } => {
                let angle = PI * (1.0 - t);
                let radius = sphere.radius_at(angle);
                // sin(π) is not zero in floating point
                let y = if t == 0.0 || t == 1.0 {
                    0.0
                } else {
                    radius * angle.sin()
                };
                Point::new(sphere.centre + radius * angle.cos(), y)
            }
        }
    }

    /// Whether the curve is not straight.
    pub fn is_curved(&self) -> bool {
        matches!(self, Self::HalfEllipse { .. } | Self::Radial { .. })
    }

    /// Points at equally spaced parameters, both ends included.
    pub fn samples(&self) -> impl Iterator<Item = Point> + '_ {
        (0..=SAMPLE_INTERVALS).map(|i| self.point(i as f64 / SAMPLE_INTERVALS as f64))
    }

    /// Parameters from 0 to 1 of points that divide the curve into edges of about length `size`.
    ///
    /// Edge lengths are proportional to `size` and at most `size`; there are at least `min_edges`.
    pub fn divide(&self, min_edges: usize, size: impl Fn(&Point) -> f64) -> Vec<f64> {
        // (t, integral of ds / size up to t)
        let mut table = vec![(0.0, 0.0)];
        let (mut t, mut count) = (0.0, 0.0);
        while t < 1.0 {
            let here = self.point(t);
            let local_size = size(&here);
            let speed = self.speed(t).max(f64::MIN_POSITIVE);
            // the step in t is bounded because the speed of an ellipse varies along it
            let next = (t + (RELATIVE_STEP * local_size / speed).clamp(1e-9, 0.01)).min(1.0);
            let chord = (self.point(next) - here).norm();
            count += chord / local_size;
            t = next;
            table.push((t, count));
        }
        let parts = (count.ceil() as usize).max(min_edges);
        let mut intervals = table.windows(2).peekable();
        let inner = (1..parts).map(|k| {
            let target = count * k as f64 / parts as f64;
            while let Some(pair) = intervals.peek() {
                let [(t0, c0), (t1, c1)] = [pair[0], pair[1]];
                if c1 >= target {
                    return t0 + (t1 - t0) * (target - c0) / (c1 - c0);
                }
                intervals.next();
            }
            1.0
        });
        let inner: Vec<f64> = inner.collect();
        std::iter::once(0.0).chain(inner).chain([1.0]).collect()
    }

    /// Norm of the derivative of the point with respect to the parameter.
    fn speed(&self, t: f64) -> f64 {
        match *self {
            Self::Line { from, to, .. } => (to - from).norm(),
            Self::HalfEllipse {
                axial, equatorial, ..
            } => PI * (axial * (PI * t).sin()).hypot(equatorial * (PI * t).cos()),
            Self::Radial { sphere, .. } => {
                let [radius, slope] = sphere.with_slope(PI * (1.0 - t));
                PI * radius.hypot(slope)
            }
        }
    }
}
