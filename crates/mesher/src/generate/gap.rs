//! Gaps between close surfaces, and the edge lengths that they allow.

use super::input::Container;
use crate::surface::sphere_radius;
use mesh::{Surface, Vec3};

/// A pair of close surfaces, which bounds the edge lengths in and around the gap between them.
#[derive(Clone)]
pub(super) struct Gap<'a> {
    surfaces: [&'a dyn Surface; 2],
    /// 1 for a body, -1 for a wall, which has the fluid inside.
    signs: [f64; 2],
    /// Width of the gap at its narrowest point.
    pub width: f64,
    /// The narrowest point of the gap.
    middle: Vec3,
    /// Lower bound of the opening of the gap.
    ///
    /// At the distance `s` from the narrowest point its width is at least `width + bend s^2`.
    bend: f64,
    /// Translation of the gap to copies of a body, which all get the same edge lengths.
    shift: Vec3,
}

impl<'a> Gap<'a> {
    /// The gap between two bodies.
    pub fn between(a: &'a dyn Surface, b: &'a dyn Surface) -> Self {
        let ((centre_a, r_a), (centre_b, r_b)) = (a.bounding_ball(), b.bounding_ball());
        let (width, middle, bend) = if let (Some(r_a), Some(r_b)) =
            (sphere_radius(a), sphere_radius(b))
        {
            let arm = centre_b - centre_a;
            let distance = arm.norm();
            let width = distance - r_a - r_b;
            let middle = centre_a + arm * ((r_a + 0.5 * width) / distance.max(f64::MIN_POSITIVE));
            (width, middle, 0.5 * (1.0 / r_a + 1.0 / r_b))
        } else {
            let clearance = (centre_b - centre_a).norm() - r_a - r_b;
            if clearance > r_a + r_b {
                // Far apart: the distance of the bounding balls is accurate enough.
                (clearance, 0.5 * (centre_a + centre_b), 0.0)
            } else {
                let (p, q) = closest_points(a, b);
                (a.signed_distance(q), 0.5 * (p + q), 0.0)
            }
        };
        Gap {
            surfaces: [a, b],
            signs: [1.0, 1.0],
            width,
            middle,
            bend,
            shift: Vec3::zeros(),
        }
    }

    /// The gap between a body and the wall of the container.
    pub fn to_wall(body: &'a dyn Surface, container: &'a Container) -> Self {
        let wall = container.surface();
        let (centre, body_radius) = body.bounding_ball();
        let depth = -wall.signed_distance(centre);
        let (width, middle, bend) = if let Some(radius) = sphere_radius(body) {
            let out = wall.closest_point(centre) - centre;
            let width = depth - radius;
            let middle =
                centre + out * ((radius + 0.5 * width) / out.norm().max(f64::MIN_POSITIVE));
            let bend = match container {
                // For spheres of radii r < R with centres at the distance e, the gap opens at least
                // like e s^2 / (2 r R).
                Container::Ball(ball) => {
                    (ball.radius - depth).max(0.0) / (2.0 * radius * ball.radius)
                }
                // Around the cylinder the gap opens as in a ball, along it faster.
                Container::Capsule(capsule) => {
                    (capsule.radius - depth).max(0.0) / (2.0 * radius * capsule.radius)
                }
                // Next to another face or bend the gap need not open.
                Container::Box(_) | Container::Surface(_) => 0.0,
            };
            (width, middle, bend)
        } else if depth > 3.0 * body_radius {
            // Far from the wall: the distance of the bounding ball is accurate enough.
            (depth - body_radius, centre, 0.0)
        } else {
            let foot = closest_to_wall(body, wall);
            (-wall.signed_distance(foot), foot, 0.0)
        };
        Gap {
            surfaces: [body, wall],
            signs: [1.0, -1.0],
            width,
            middle,
            bend,
            shift: Vec3::zeros(),
        }
    }

    /// The same gap, translated.
    pub fn shifted(&self, shift: Vec3) -> Self {
        Gap {
            shift,
            ..self.clone()
        }
    }

    /// Whether two gaps allow the same sizes, up to rounding.
    pub fn is_like(&self, other: &Self) -> bool {
        let apart = (self.middle + self.shift - other.middle - other.shift).norm();
        apart.max((self.width - other.width).abs()) <= 1e-9 * self.width
            && (self.bend - other.bend).abs() <= 1e-9 * self.bend
    }

    /// Longest edge that this gap allows at `x` if it is below `h`, otherwise a value of at least
    /// `h`.
    ///
    /// The larger of two lower bounds of `gap (d1 + d2)` with its slope limited to `growth`, where
    /// `d1` and `d2` are the distances from the two surfaces.
    pub fn size(&self, x: Vec3, h: f64, gap: f64, growth: f64) -> f64 {
        let x = x - self.shift;
        // (1) The parabola gap (width + bend s^2), continued by its tangent where it becomes
        // steeper than `growth`.
        let s = ((x - self.middle).norm() - 0.5 * self.width).max(0.0);
        let curve = gap * self.bend;
        let opening = if 2.0 * curve * s < growth {
            curve * s * s
        } else {
            growth * s - growth * growth / (4.0 * curve)
        };
        let narrow = gap * self.width;
        if narrow + opening >= h {
            return h;
        }
        // (2) d1 + d2 grows by at most 2 per unit of length, so its factor is at most half of
        // `growth`.
        let sum: f64 = (0..2)
            .map(|k| (self.signs[k] * self.surfaces[k].signed_distance(x)).max(0.0))
            .sum();
        let slope = (0.5 * growth).min(gap);
        narrow + opening.max(slope * (sum - self.width).max(0.0))
    }
}

/// Closest points of two shapes that do not overlap, by alternating projections (Cheney & Goldstein
/// 1959).
///
/// They converge for convex shapes from anywhere; for other shapes they start at the vertex of a
/// coarse triangulation that is closest to the other shape. Overlapping shapes give a point of `a`
/// inside `b`, twice.
fn closest_points(a: &dyn Surface, b: &dyn Surface) -> (Vec3, Vec3) {
    let mut q = match [a, b].iter().all(|s| s.is_convex()) {
        true => b.closest_point(a.centre()),
        false => {
            let of_a = closest_vertex(a, b).map(|(x, distance)| (b.closest_point(x), distance));
            let candidates = [of_a, closest_vertex(b, a)].into_iter().flatten();
            let closest = candidates.min_by(|x, y| x.1.total_cmp(&y.1));
            closest.map_or_else(|| b.closest_point(a.centre()), |(q, _)| q)
        }
    };
    let mut p = a.closest_point(q);
    // Convergence is linear, but sizes need a few digits only.
    for _ in 0..200 {
        if b.signed_distance(p) <= 0.0 {
            return (p, p);
        }
        q = b.closest_point(p);
        p = a.closest_point(q);
    }
    (p, q)
}

/// The vertex of a coarse triangulation of `a` closest to `b`, with its signed distance.
fn closest_vertex(a: &dyn Surface, b: &dyn Surface) -> Option<(Vec3, f64)> {
    let points = a.triangulation()?.points.into_iter();
    let distances = points.map(|x| (x, b.signed_distance(x)));
    distances.min_by(|x, y| x.1.total_cmp(&y.1))
}

/// Point of `body` closest to the wall, by alternating projections.
///
/// If the body crosses the wall, the point is outside.
fn closest_to_wall(body: &dyn Surface, wall: &dyn Surface) -> Vec3 {
    let all_convex = body.is_convex() && wall.is_convex();
    let points = (body.triangulation().filter(|_| !all_convex)).map(|mesh| mesh.points);
    let nearest = (points.into_iter().flatten()).max_by(|x, y| {
        wall.signed_distance(*x)
            .total_cmp(&wall.signed_distance(*y))
    });
    let start = nearest.unwrap_or_else(|| body.centre());
    let mut p = body.closest_point(wall.closest_point(start));
    for _ in 0..200 {
        if wall.signed_distance(p) >= 0.0 {
            return p;
        }
        p = body.closest_point(wall.closest_point(p));
    }
    p
}

/// Distance between the surface of a body and the wall of a container around it.
///
/// Negative if the body crosses the wall: minus how far the point found is outside. For spheres and
/// for convex containers it is the smallest distance. Otherwise the search begins at the vertex of
/// the body's triangulation closest to the wall, and finds the smallest distance from there.
pub fn clearance(body: &dyn Surface, wall: &dyn Surface) -> f64 {
    match sphere_radius(body) {
        Some(radius) => -wall.signed_distance(body.centre()) - radius,
        None => -wall.signed_distance(closest_to_wall(body, wall)),
    }
}
