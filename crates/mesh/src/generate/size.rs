//! How long edges are to be, everywhere in the fluid.

use super::surface_mesh::sphere_radius;
use super::{Container, GenerateParams, MeshedBody};
use crate::{MeshError, Surface, Vec3};

/// Edges longer than this part of the radius of curvature cannot follow a surface: when the longest, `sqrt(2)` of the wanted
/// length, still turns by less than 60 degrees, no triangle faces away from its neighbours.
pub(super) const OF_CURVATURE: f64 = 0.7;

/// A close pair of surfaces: sizes are bounded in and around the gap between them.
#[derive(Clone)]
struct Gap<'a> {
    surfaces: [&'a dyn Surface; 2],
    /// `-1` for a wall: the fluid is inside of it.
    signs: [f64; 2],
    width: f64,
    /// Where the gap is narrowest.
    middle: Vec3,
    /// The gap is at least `width + bend s^2` wide at the distance `s` from its middle.
    bend: f64,
    /// Translation of the gap: copies of a body are all as fine as the one beside the gap.
    shift: Vec3,
}

/// The wanted edge length `h(x)`, as long as all of these allow:
///
/// * `size + growth d` around each body, `d` the distance to it;
/// * `0.7 rho + growth s` around the places where it is curved most, `rho` the radius of curvature and `s` the distance there;
/// * `gap (d1 + d2)` between each pair of close surfaces, lowered until it grows no faster than `growth`;
/// * the largest size, and a part of the container's size; in a capsule, the smallest of all these on its wall plus `growth` times the distance from there.
///
/// A background takes the place of the first. The field is Lipschitz continuous with constant `growth`, if the background is.
pub(super) struct SizeField<'a> {
    bodies: &'a [MeshedBody<'a>],
    /// Wanted edge length where each body is curved most.
    sharp: Vec<f64>,
    gaps: Vec<Gap<'a>>,
    growth: f64,
    gap: f64,
    max: f64,
    background: Option<Background<'a>>,
    /// A wall whose edges have one length.
    wall: Option<(&'a dyn Surface, f64)>,
}

/// A wanted edge length everywhere in the fluid.
pub(super) type Background<'a> = &'a (dyn Fn(Vec3) -> f64 + Sync);

impl<'a> SizeField<'a> {
    /// Checks the arrangement and finds its gaps.
    ///
    /// # Errors
    /// Bodies closer to each other or to the wall than [`GenerateParams::min_gap`] of the smaller radius.
    pub fn new(
        bodies: &'a [MeshedBody<'a>],
        container: &'a Container,
        copies: &[usize],
        params: &GenerateParams,
    ) -> Result<Self, MeshError> {
        let mut field = SizeField {
            bodies,
            sharp: bodies
                .iter()
                .map(|b| OF_CURVATURE * b.surface.smallest_curvature_radius())
                .collect(),
            gaps: Vec::new(),
            growth: params.growth,
            gap: params.gap,
            max: params.max_size.min(container.largest_size()),
            background: None,
            wall: None,
        };
        for (i, body) in bodies.iter().enumerate() {
            let (_, radius) = body.surface.bounding_ball();
            let least = params.min_gap * radius;
            let gap = Gap::to_wall(body.surface, container);
            if gap.width.is_nan() || gap.width <= least {
                return Err(MeshError::BodyAtWall {
                    body: body.name.into(),
                    distance: gap.width,
                    least,
                });
            }
            field.keep(gap, &[i], copies);
            for (j, other) in bodies[..i].iter().enumerate() {
                let (_, other_radius) = other.surface.bounding_ball();
                let least = params.min_gap * radius.min(other_radius);
                let gap = Gap::between(other.surface, body.surface);
                if gap.width.is_nan() || gap.width <= least {
                    return Err(MeshError::BodiesTouch {
                        first: other.name.into(),
                        second: body.name.into(),
                        distance: gap.width,
                        least,
                    });
                }
                field.keep(gap, &[i, j], copies);
            }
        }
        Ok(field)
    }

    /// Keeps a gap between `members` (one if it is to the wall), and beside all copies of them, if it can bind.
    fn keep(&mut self, gap: Gap<'a>, members: &[usize], copies: &[usize]) {
        let size = members
            .iter()
            .fold(0.0, |m: f64, &i| m.max(self.bodies[i].size));
        // In wide gaps the sizes grown from the surfaces are smaller.
        if self.gap * gap.width >= size + self.growth * gap.width {
            return;
        }
        for &i in members {
            for k in 0..self.bodies.len() {
                if copies[k] == copies[i] {
                    let shift = self.bodies[k].surface.centre() - self.bodies[i].surface.centre();
                    let shifted = Gap {
                        shift,
                        ..gap.clone()
                    };
                    if !self.gaps.iter().any(|g| g.is_like(&shifted)) {
                        self.gaps.push(shifted);
                    }
                }
            }
        }
    }

    /// The field with a background instead of sizes that grow from the bodies.
    ///
    /// Where the background is not a positive number, sizes stay as if there were none.
    pub fn with_background(self, background: Background<'a>) -> Self {
        Self {
            background: Some(background),
            ..self
        }
    }

    /// The same field, but with edges of one length on a wall.
    pub fn with_wall(self, wall: &'a dyn Surface, edge: f64) -> Self {
        Self {
            wall: Some((wall, edge)),
            ..self
        }
    }

    /// Length of the edges on that wall; without one the longest anywhere.
    pub fn edge_on_wall(&self) -> f64 {
        self.wall.map_or(self.max, |(_, edge)| edge)
    }

    /// The wanted edge length at `x`.
    pub fn at(&self, x: Vec3) -> f64 {
        let mut h = self.max;
        let wanted = self.background.map(|background| background(x));
        let wanted = wanted.filter(|size| *size > 0.0);
        if let Some(size) = wanted {
            h = h.min(size);
        }
        for (body, sharp) in self.bodies.iter().zip(&self.sharp) {
            // A lower bound of the distances saves evaluating shapes far away.
            let (centre, radius) = body.surface.bounding_ball();
            let away = ((x - centre).norm() - radius).max(0.0);
            if body.size.min(*sharp) + self.growth * away < h {
                let distance = body.surface.signed_distance(x).max(0.0);
                if wanted.is_none() {
                    h = h.min(body.size + self.growth * distance);
                }
                let to_sharpest = body.surface.distance_to_sharpest(x).max(distance);
                h = h.min(sharp + self.growth * to_sharpest);
            }
        }
        for gap in &self.gaps {
            h = h.min(gap.size(x, h, self.gap, self.growth));
        }
        if let Some((wall, edge)) = self.wall {
            h = h.min(edge + self.growth * (-wall.signed_distance(x)).max(0.0));
        }
        h
    }
}

impl<'a> Gap<'a> {
    fn between(a: &'a dyn Surface, b: &'a dyn Surface) -> Self {
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
            let spread = (centre_b - centre_a).norm() - r_a - r_b;
            if spread > r_a + r_b {
                // So far apart that the bounding balls tell enough.
                (spread, 0.5 * (centre_a + centre_b), 0.0)
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

    fn to_wall(body: &'a dyn Surface, container: &'a Container) -> Self {
        let wall = container.surface();
        let (centre, reach) = body.bounding_ball();
        let depth = -wall.signed_distance(centre);
        let (width, middle, bend) = if let Some(radius) = sphere_radius(body) {
            let out = wall.closest_point(centre) - centre;
            let width = depth - radius;
            let middle =
                centre + out * ((radius + 0.5 * width) / out.norm().max(f64::MIN_POSITIVE));
            let bend = match container {
                // Spheres of radii r < R, centres e apart: the gap opens like e s^2 / (2 r R) at least.
                Container::Ball(ball) => {
                    (ball.radius - depth).max(0.0) / (2.0 * radius * ball.radius)
                }
                // Along the cylinder it opens faster than around it, where it opens as in a ball.
                Container::Capsule(capsule) => {
                    (capsule.radius - depth).max(0.0) / (2.0 * radius * capsule.radius)
                }
                // Beside another face of the box it need not open.
                Container::Box(_) => 0.0,
            };
            (width, middle, bend)
        } else if depth > 3.0 * reach {
            // So far away that the bounding ball tells enough.
            (depth - reach, centre, 0.0)
        } else {
            let foot = deepest_point(body, wall);
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

    /// Whether two gaps ask for the same sizes, up to rounding.
    fn is_like(&self, other: &Self) -> bool {
        let apart = (self.middle + self.shift - other.middle - other.shift).norm();
        apart.max((self.width - other.width).abs()) <= 1e-9 * self.width
            && (self.bend - other.bend).abs() <= 1e-9 * self.bend
    }

    /// The longest edge that this gap allows at `x`, if below `h`, otherwise something not below it.
    ///
    /// It is the larger of two lower bounds of the slope-limited `gap (d1 + d2)`.
    fn size(&self, x: Vec3, h: f64, gap: f64, growth: f64) -> f64 {
        let x = x - self.shift;
        // (1) the parabola gap (width + bend s^2), continued by its tangent where it becomes steeper than the growth.
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
        // (2) d1 + d2 grows by at most 2 a unit of length, hence half the growth of the size for each.
        let sum: f64 = (0..2)
            .map(|k| (self.signs[k] * self.surfaces[k].signed_distance(x)).max(0.0))
            .sum();
        let slope = (0.5 * growth).min(gap);
        narrow + opening.max(slope * (sum - self.width).max(0.0))
    }
}

/// Closest points of two convex shapes that do not overlap, by alternating projections (Cheney & Goldstein 1959).
fn closest_points(a: &dyn Surface, b: &dyn Surface) -> (Vec3, Vec3) {
    let mut q = b.closest_point(a.centre());
    let mut p = a.closest_point(q);
    // Linear convergence; sizes need a few digits only.
    for _ in 0..200 {
        if b.signed_distance(p) <= 0.0 {
            return (p, p);
        }
        q = b.closest_point(p);
        p = a.closest_point(q);
    }
    (p, q)
}

/// The point of `body` closest to the wall `part`, by walking its surface towards it.
fn deepest_point(body: &dyn Surface, part: &dyn Surface) -> Vec3 {
    let mut p = body.closest_point(part.closest_point(body.centre()));
    for _ in 0..200 {
        if part.signed_distance(p) >= 0.0 {
            return p;
        }
        p = body.closest_point(part.closest_point(p));
    }
    p
}

#[cfg(test)]
mod tests {
    use super::super::copies::first_copies;
    use super::*;
    use crate::Sphere;

    fn spheres(x: &[f64]) -> Vec<Sphere> {
        x.iter()
            .map(|&x| Sphere {
                centre: Vec3::new(x, 0.0, 0.0),
                radius: 1.0,
            })
            .collect()
    }

    fn bodies(spheres: &[Sphere]) -> Vec<MeshedBody<'_>> {
        spheres
            .iter()
            .map(|s| MeshedBody {
                name: "b",
                surface: s,
                size: 0.3,
            })
            .collect()
    }

    #[test]
    fn sizes_are_lipschitz_and_resolve_gaps() {
        let shapes = spheres(&[-1.05, 1.05]);
        let bodies = bodies(&shapes);
        let params = GenerateParams::default();
        let container = Container::Ball(Sphere {
            centre: Vec3::zeros(),
            radius: 10.0,
        });
        let field =
            SizeField::new(&bodies, &container, &first_copies(&bodies), &params).expect("valid");
        assert!((field.at(Vec3::zeros()) - params.gap * 0.1).abs() < 1e-12);
        let mut before = None;
        // A path along the first sphere's surface into the gap and out again.
        for k in 0..2000 {
            let t = f64::from(k) * 1e-3 * std::f64::consts::PI - 1.0;
            let x = shapes[0].centre + Vec3::new(t.cos(), t.sin(), 0.0);
            let h = field.at(x);
            let sum: f64 = shapes.iter().map(|s| s.signed_distance(x).max(0.0)).sum();
            // The parabola bounds the gap from below up to fourth order in s <= 1.
            assert!(h <= 1.2 * params.gap * sum, "{x} {h} {sum}");
            if let Some((y, g)) = before {
                let step: Vec3 = x - y;
                let rise: f64 = h - g;
                assert!(rise.abs() <= (params.growth + 1e-9) * step.norm());
            }
            before = Some((x, h));
        }
    }

    /// Copies have the surface mesh of the body beside the gap: the fluid around them was once sized as if they had not.
    #[test]
    fn sizes_around_copies_follow_the_gap_of_another_copy() {
        let shapes = spheres(&[0.0, 2.1, 12.0]);
        let bodies = bodies(&shapes);
        let params = GenerateParams::default();
        let container = Container::Ball(Sphere {
            centre: Vec3::zeros(),
            radius: 40.0,
        });
        let copies = first_copies(&bodies);
        assert_eq!(copies, [0, 0, 0]);
        let field = SizeField::new(&bodies, &container, &copies, &params).expect("valid");
        for x in [1.0, 1.1, -1.0, 3.1, 11.0, 13.0] {
            assert!((field.at(Vec3::new(x, 0.0, 0.0)) - 0.1 * params.gap).abs() < 1e-9);
        }
    }

    #[test]
    fn a_background_replaces_growth_but_not_gaps() {
        let shapes = spheres(&[-1.05, 1.05]);
        let bodies = bodies(&shapes);
        let params = GenerateParams::default();
        let container = Container::Ball(Sphere {
            centre: Vec3::zeros(),
            radius: 40.0,
        });
        let copies = first_copies(&bodies);
        let plain = SizeField::new(&bodies, &container, &copies, &params).expect("valid");
        let wanted = |x: Vec3| if x.x > 0.0 { 1.5 } else { f64::NAN };
        let field = SizeField::new(&bodies, &container, &copies, &params)
            .expect("valid")
            .with_background(&wanted);
        // Far from both: as wanted, even if that is coarser or finer than what grows from the bodies.
        let far = Vec3::new(20.0, 0.0, 0.0);
        assert!(field.at(far) == 1.5 && plain.at(far) > 1.5);
        // In the gap: the gap's.
        assert_eq!(field.at(1e-6 * Vec3::x()), plain.at(1e-6 * Vec3::x()));
        // Where nothing is wanted: as ever.
        assert_eq!(field.at(-far), plain.at(-far));
    }

    #[test]
    fn a_concentric_shell_has_one_size() {
        let shapes = spheres(&[0.0]);
        let bodies = bodies(&shapes);
        let params = GenerateParams::default();
        let container = Container::Ball(Sphere {
            centre: Vec3::zeros(),
            radius: 1.1,
        });
        let field =
            SizeField::new(&bodies, &container, &first_copies(&bodies), &params).expect("valid");
        for x in [Vec3::x(), -Vec3::y(), Vec3::new(0.6, 0.6, 0.6)] {
            assert!((field.at(x * (1.05 / x.norm())) - 0.1 * params.gap).abs() < 1e-9);
        }
    }
}
