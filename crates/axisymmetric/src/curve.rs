//! The pieces of a meridian boundary.

use std::f64::consts::PI;

use crate::meridian::{Point, Side};

/// A piece of the boundary with a parameter from 0 to 1, the domain to its left.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Curve {
    /// A straight line.
    Line { from: Point, to: Point, side: Side },
    /// An ellipse about a point of the axis, from pole to pole through the upper half-plane.
    HalfEllipse {
        centre: f64,
        axial: f64,
        equatorial: f64,
        /// Whether it runs from the right pole to the left one.
        leftward: bool,
        side: Side,
    },
}

/// Points that a curve is probed at.
const SAMPLES: usize = 64;

/// Step of a walk along a curve over the size wanted there.
const STEP: f64 = 0.05;

impl Curve {
    pub fn side(&self) -> Side {
        match self {
            Self::Line { side, .. } | Self::HalfEllipse { side, .. } => *side,
        }
    }

    /// The point at parameter `t`; ends on the axis are on it exactly.
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
                // the sine of pi is not zero in floating point
                let y = if t == 0.0 || t == 1.0 {
                    0.0
                } else {
                    equatorial * (PI * t).sin()
                };
                Point::new(centre + direction * axial * (PI * t).cos(), y)
            }
        }
    }

    /// Whether edges between its points bend.
    pub fn bends(&self) -> bool {
        matches!(self, Self::HalfEllipse { .. })
    }

    /// Points spread over the curve, ends included.
    pub fn samples(&self) -> impl Iterator<Item = Point> + '_ {
        (0..=SAMPLES).map(|i| self.point(i as f64 / SAMPLES as f64))
    }

    /// Parameters, from 0 to 1, of points whose distances are in proportion to `size` and at most as large.
    pub fn divide(&self, least: usize, size: impl Fn(&Point) -> f64) -> Vec<f64> {
        // length over size, counted along the curve
        let mut walked = vec![(0.0, 0.0)];
        let (mut t, mut count) = (0.0, 0.0);
        while t < 1.0 {
            let here = self.point(t);
            let wanted = size(&here);
            let speed = self.speed(t).max(f64::MIN_POSITIVE);
            // not a larger step than a part of the curve: an ellipse changes its speed along it
            let next = (t + (STEP * wanted / speed).clamp(1e-9, 0.01)).min(1.0);
            let chord = (self.point(next) - here).norm();
            count += chord / wanted;
            t = next;
            walked.push((t, count));
        }
        let parts = (count.ceil() as usize).max(least);
        let mut places = walked.windows(2).peekable();
        let inner = (1..parts).map(|k| {
            let target = count * k as f64 / parts as f64;
            while let Some(pair) = places.peek() {
                let [(t0, c0), (t1, c1)] = [pair[0], pair[1]];
                if c1 >= target {
                    return t0 + (t1 - t0) * (target - c0) / (c1 - c0);
                }
                places.next();
            }
            1.0
        });
        let inner: Vec<f64> = inner.collect();
        std::iter::once(0.0).chain(inner).chain([1.0]).collect()
    }

    fn speed(&self, t: f64) -> f64 {
        match *self {
            Self::Line { from, to, .. } => (to - from).norm(),
            Self::HalfEllipse {
                axial, equatorial, ..
            } => PI * (axial * (PI * t).sin()).hypot(equatorial * (PI * t).cos()),
        }
    }
}
