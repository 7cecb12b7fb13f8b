//! The wanted edge length everywhere in the fluid.

use super::gap::Gap;
use super::input::{Container, GenerateParams, MeshedBody};
use super::size_map::SizeMap;
use crate::{BoxSurface, GenerateError};
use mesh::{Surface, Vec3};

/// Largest edge on a curved surface, as a fraction of the radius of curvature.
///
/// The longest edges have `sqrt(2)` of the wanted length. As long as the normal turns by less than
/// 60 degrees along them, neighbouring triangles face the same way.
const OF_CURVATURE: f64 = 0.7;

/// The same fraction for edges of one radius on the largest ball inside the body.
///
/// Edges of 0.4 radii, the default of the models, and longer ones give [`OF_CURVATURE`]. With finer
/// edges everywhere, those on strongly curved parts become finer in proportion.
const PER_SIZE: f64 = OF_CURVATURE / 0.4;

/// Largest edge on a body, as a fraction of the radius of the largest ball inside it.
///
/// A ball through the corners of a triangle on one side of a plate must be able to avoid the
/// vertices on the other side and those in the fluid.
const OF_THICKNESS: f64 = 1.2;

/// The wanted edge length `h(x)`: the minimum of
///
/// * `size + growth d` around each body, `d` the distance to it;
/// * `factor rho + growth s` around points of strong curvature, `rho` the radius of curvature and
///   `s` the distance to them ([`Surface::curvature_size`]), `factor` at most 0.7;
/// * `gap (d1 + d2)` between each pair of close surfaces, lowered until it grows no faster than
///   `growth`;
/// * the largest size, and a fraction of the container's size or, for a container of any shape, of
///   its radii of curvature and of the width of its narrow parts;
/// * `edge + growth s` around vertices of surfaces with sharp edges where these are closer
///   together;
/// * in a capsule, the smallest of all these on its wall plus `growth` times the distance from
///   there.
///
/// A background, if given, replaces the first of these. The field is Lipschitz continuous with
/// constant `growth` if the background is.
pub(crate) struct SizeField<'a> {
    bodies: &'a [MeshedBody<'a>],
    container: Option<&'a Container>,
    /// Wanted edge length on each body.
    sizes: Vec<f64>,
    /// Wanted edge length on each body as a fraction of the radius of curvature.
    of_curvature: Vec<f64>,
    /// Wanted edge length where the curvature of each body is largest.
    sharp: Vec<f64>,
    gaps: Vec<Gap<'a>>,
    growth: f64,
    gap: f64,
    max: f64,
    background: Option<Background<'a>>,
    /// Edge lengths at short edges of surfaces.
    short: Option<SizeMap>,
    /// A wall on which all edges have the same length, and that length.
    wall: Option<(&'a dyn Surface, f64)>,
}

/// The positive side of each coordinate plane, as boxes with faces at distances without meaning.
pub(crate) static HALF_SPACES: [Container; 3] = {
    const FACE_DISTANCE: f64 = 1e100;
    const fn half_space(min: Vec3) -> Container {
        let max = Vec3::new(FACE_DISTANCE, FACE_DISTANCE, FACE_DISTANCE);
        Container::Box(BoxSurface { min, max })
    }
    [
        half_space(Vec3::new(0.0, -FACE_DISTANCE, -FACE_DISTANCE)),
        half_space(Vec3::new(-FACE_DISTANCE, 0.0, -FACE_DISTANCE)),
        half_space(Vec3::new(-FACE_DISTANCE, -FACE_DISTANCE, 0.0)),
    ]
};

/// A given edge length everywhere in the fluid.
pub(crate) type Background<'a> = &'a (dyn Fn(Vec3) -> f64 + Sync);

impl<'a> SizeField<'a> {
    /// Finds the gaps between the bodies and to the wall of the container, if there is one.
    ///
    /// # Errors
    /// [`GenerateError::BodiesTouch`] and [`GenerateError::BodyAtWall`] for gaps below
    /// [`GenerateParams::min_gap`] times the (smaller) radius.
    pub fn new(
        bodies: &'a [MeshedBody<'a>],
        container: Option<&'a Container>,
        copies: &[usize],
        params: &GenerateParams,
    ) -> Result<Self, GenerateError> {
        let per_size = |b: &MeshedBody| PER_SIZE * b.size / b.surface.inradius();
        let of_curvature: Vec<f64> = (bodies.iter())
            .map(|b| OF_CURVATURE.min(per_size(b)))
            .collect();
        let mut field = SizeField {
            bodies,
            container,
            sizes: (bodies.iter())
                .map(|b| b.size.min(OF_THICKNESS * b.surface.inradius()))
                .collect(),
            sharp: (bodies.iter().zip(&of_curvature))
                .map(|(b, factor)| factor * b.surface.reach())
                .collect(),
            of_curvature,
            gaps: Vec::new(),
            growth: params.growth,
            gap: params.gap,
            max: container.map_or(params.max_size, |container| {
                params.max_size.min(container.largest_size())
            }),
            background: None,
            short: None,
            wall: None,
        };
        for (i, body) in bodies.iter().enumerate() {
            let (_, radius) = body.surface.bounding_ball();
            let minimum = params.min_gap * radius;
            if let Some(container) = container {
                let gap = Gap::to_wall(body.surface, container);
                if gap.width.is_nan() || gap.width <= minimum {
                    return Err(GenerateError::BodyAtWall {
                        body: body.name.into(),
                        distance: gap.width,
                        minimum,
                    });
                }
                field.add_gap(gap, &[i], copies);
            }
            for axis in (0..3).filter(|&axis| params.symmetry_planes[axis]) {
                let gap = Gap::to_wall(body.surface, &HALF_SPACES[axis]);
                // A body that the plane cuts leaves no gap.
                if gap.width > minimum {
                    field.add_gap(gap, &[i], copies);
                }
            }
            for (j, other) in bodies[..i].iter().enumerate() {
                let (_, other_radius) = other.surface.bounding_ball();
                let minimum = params.min_gap * radius.min(other_radius);
                let gap = Gap::between(other.surface, body.surface);
                if gap.width.is_nan() || gap.width <= minimum {
                    return Err(GenerateError::BodiesTouch {
                        first: other.name.into(),
                        second: body.name.into(),
                        distance: gap.width,
                        minimum,
                    });
                }
                field.add_gap(gap, &[i, j], copies);
            }
        }
        Ok(field)
    }

    /// Adds the gap between `members`, if it can limit the size.
    ///
    /// Its translations to all copies of the members are added too. There is one member if the gap
    /// is between a body and the wall.
    fn add_gap(&mut self, gap: Gap<'a>, members: &[usize], copies: &[usize]) {
        let size = members.iter().fold(0.0, |m: f64, &i| m.max(self.sizes[i]));
        // In wide gaps the sizes that grow from the surfaces are smaller.
        if self.gap * gap.width >= size + self.growth * gap.width {
            return;
        }
        for &i in members {
            for k in 0..self.bodies.len() {
                if copies[k] == copies[i] {
                    let shift = self.bodies[k].surface.centre() - self.bodies[i].surface.centre();
                    let shifted = gap.shifted(shift);
                    if !self.gaps.iter().any(|g| g.is_like(&shifted)) {
                        self.gaps.push(shifted);
                    }
                }
            }
        }
    }

    /// The field with a background instead of sizes that grow from the bodies.
    ///
    /// Where the background is not a positive number, it is ignored.
    pub fn with_background(self, background: Background<'a>) -> Self {
        Self {
            background: Some(background),
            ..self
        }
    }

    /// The field with edges of the same length everywhere on a wall.
    pub fn with_wall(self, wall: &'a dyn Surface, edge: f64) -> Self {
        Self {
            wall: Some((wall, edge)),
            ..self
        }
    }

    /// Limits the field near points where edges of a surface are shorter than wanted.
    ///
    /// # Errors
    /// Those of [`SizeMap::new`].
    pub fn limit_near(&mut self, short: Vec<(Vec3, f64)>) -> Result<(), GenerateError> {
        self.short = match short.is_empty() {
            true => None,
            false => Some(SizeMap::new(short, self.growth)?),
        };
        Ok(())
    }

    /// Edge length on the wall given to `with_wall`; without one, the largest length anywhere.
    pub fn edge_on_wall(&self) -> f64 {
        self.wall.map_or(self.max, |(_, edge)| edge)
    }

    /// Wanted edge length at `x`.
    pub fn at(&self, x: Vec3) -> f64 {
        let of_container = (self.container).map_or(f64::INFINITY, |c| c.local_size(x, self.growth));
        let mut h = self.max.min(of_container);
        let wanted = self.background.map(|background| background(x));
        let wanted = wanted.filter(|size| *size > 0.0);
        if let Some(size) = wanted {
            h = h.min(size);
        }
        for (k, body) in self.bodies.iter().enumerate() {
            let size = self.sizes[k];
            // A lower bound of the distance avoids evaluating shapes far away.
            let (centre, radius) = body.surface.bounding_ball();
            let away = ((x - centre).norm() - radius).max(0.0);
            if size.min(self.sharp[k]) + self.growth * away < h {
                let distance = body.surface.signed_distance(x).max(0.0);
                if wanted.is_none() {
                    h = h.min(size + self.growth * distance);
                }
                let factor = self.of_curvature[k];
                h = h.min(body.surface.curvature_size(x, factor, self.growth));
            }
        }
        for gap in &self.gaps {
            h = h.min(gap.size(x, h, self.gap, self.growth));
        }
        if let Some(short) = &self.short {
            h = h.min(short.at(x));
        }
        if let Some((wall, edge)) = self.wall {
            h = h.min(edge + self.growth * (-wall.signed_distance(x)).max(0.0));
        }
        h
    }
}

#[cfg(test)]
mod tests {
    use super::super::input::first_copies;
    use super::*;
    use crate::Sphere;

    /// Calls `check` with the field around equal unit spheres on the x axis in a ball.
    fn in_ball(x: &[f64], radius: f64, check: impl FnOnce(&[Sphere], SizeField<'_>)) {
        let sphere = |&x: &f64| Sphere::new(Vec3::new(x, 0.0, 0.0), 1.0);
        let shapes: Vec<Sphere> = x.iter().map(sphere).collect();
        let body = |sphere| MeshedBody::new("b", sphere as &dyn Surface, 0.3);
        let bodies: Vec<MeshedBody> = shapes.iter().map(body).collect();
        let container = Container::Ball(Sphere::new(Vec3::zeros(), radius));
        let copies = first_copies(&bodies);
        assert!(copies.iter().all(|&first| first == 0));
        let params = GenerateParams::default();
        let field = SizeField::new(&bodies, Some(&container), &copies, &params);
        check(&shapes, field.expect("valid"));
    }

    #[test]
    fn sizes_are_lipschitz_and_resolve_gaps() {
        in_ball(&[-1.05, 1.05], 10.0, |shapes, field| {
            assert!((field.at(Vec3::zeros()) - field.gap * 0.1).abs() < 1e-12);
            let mut before = None;
            // A path along the surface of the first sphere, into the gap and out of it.
            for k in 0..2000 {
                let t = f64::from(k) * 1e-3 * std::f64::consts::PI - 1.0;
                let x = shapes[0].centre + Vec3::new(t.cos(), t.sin(), 0.0);
                let h = field.at(x);
                let sum: f64 = shapes.iter().map(|s| s.signed_distance(x).max(0.0)).sum();
                // The parabola is a lower bound of the gap up to fourth order in s <= 1.
                assert!(h <= 1.2 * field.gap * sum, "{x} {h} {sum}");
                if let Some((y, g)) = before {
                    let step: Vec3 = x - y;
                    let rise: f64 = h - g;
                    assert!(rise.abs() <= (field.growth + 1e-9) * step.norm());
                }
                before = Some((x, h));
            }
        });
    }

    /// Copies share the surface mesh of the body at the gap, so the sizes around them must be the
    /// same; they once were not.
    #[test]
    fn sizes_around_copies_follow_the_gap_of_another_copy() {
        in_ball(&[0.0, 2.1, 12.0], 40.0, |_, field| {
            for x in [1.0, 1.1, -1.0, 3.1, 11.0, 13.0] {
                assert!((field.at(Vec3::new(x, 0.0, 0.0)) - 0.1 * field.gap).abs() < 1e-9);
            }
        });
    }

    #[test]
    fn a_background_replaces_growth_but_not_gaps() {
        in_ball(&[-1.05, 1.05], 40.0, |_, field| {
            let wanted = |x: Vec3| if x.x > 0.0 { 1.5 } else { f64::NAN };
            let (far, inside) = (Vec3::new(20.0, 0.0, 0.0), 1e-6 * Vec3::x());
            let plain = [far, inside, -far].map(|x| field.at(x));
            let field = field.with_background(&wanted);
            // Far from both bodies the background applies, even where it differs from the sizes
            // that grow from the bodies.
            assert!(field.at(far) == 1.5 && plain[0] > 1.5);
            // In the gap the gap decides.
            assert_eq!(field.at(inside), plain[1]);
            // Where the background is not a number, the field is as without it.
            assert_eq!(field.at(-far), plain[2]);
        });
    }

    #[test]
    fn a_concentric_shell_has_one_size() {
        in_ball(&[0.0], 1.1, |_, field| {
            for x in [Vec3::x(), -Vec3::y(), Vec3::new(0.6, 0.6, 0.6)] {
                assert!((field.at(x * (1.05 / x.norm())) - 0.1 * field.gap).abs() < 1e-9);
            }
        });
    }
}
