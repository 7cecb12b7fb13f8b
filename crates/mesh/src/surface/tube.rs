//! Coarse triangulations of tubes with a circular cross-section.

use super::SurfaceMesh;
use crate::Vec3;
use std::f64::consts::{FRAC_PI_4, PI};

/// Points around a tube: edges of 0.77 radii.
const AROUND: usize = 8;

/// A circular cross-section: its centre and two orthogonal unit vectors.
///
/// Their cross product is the direction of the tube.
pub(super) struct Section {
    pub centre: Vec3,
    pub across: [Vec3; 2],
}

impl Section {
    fn tangent(&self) -> Vec3 {
        self.across[0].cross(&self.across[1])
    }

    /// Circle of points with the given radius, shifted along the tube; every other one is turned
    /// by half a step.
    fn circle(&self, radius: f64, shift: f64, turned: bool) -> impl Iterator<Item = Vec3> {
        let centre = self.centre + shift * self.tangent();
        let [u, v] = self.across;
        let start = if turned { 0.5 } else { 0.0 };
        (0..AROUND).map(move |k| {
            let angle = 2.0 * PI * (k as f64 + start) / AROUND as f64;
            centre + radius * (angle.cos() * u + angle.sin() * v)
        })
    }
}

/// A sphere of 26 points about the x axis, stretched to the given semi-axes.
pub(super) fn stretched_sphere(semi_axes: Vec3) -> SurfaceMesh {
    let equator = Section {
        centre: Vec3::zeros(),
        across: [Vec3::y(), Vec3::z()],
    };
    let mut mesh = open_tube(1.0, &[equator]);
    for p in &mut mesh.points {
        p.component_mul_assign(&semi_axes);
    }
    mesh
}

/// Number of intervals of about one radius in a length, at least `least`.
pub(super) fn intervals(length: f64, radius: f64, least: usize) -> usize {
    ((length / radius).ceil() as usize).max(least)
}

/// The tube through the sections, with round ends.
pub(super) fn open_tube(radius: f64, sections: &[Section]) -> SurfaceMesh {
    let mut mesh = SurfaceMesh::default();
    let (Some(first), Some(last)) = (sections.first(), sections.last()) else {
        return mesh;
    };
    // Half of each end: a circle at 45 degrees and the pole.
    let diagonal = radius * FRAC_PI_4.cos();
    mesh.points.push(first.centre - radius * first.tangent());
    mesh.points.extend(first.circle(diagonal, -diagonal, true));
    for (k, section) in sections.iter().enumerate() {
        mesh.points.extend(section.circle(radius, 0.0, k % 2 == 1));
    }
    let turned = sections.len() % 2 == 1;
    mesh.points.extend(last.circle(diagonal, diagonal, turned));
    mesh.points.push(last.centre + radius * last.tangent());
    let circles = sections.len() + 2;
    let at = |circle: usize, k: usize| (1 + circle * AROUND + k % AROUND) as u32;
    let pole = mesh.points.len() as u32 - 1;
    for k in 0..AROUND {
        mesh.triangles.push([0, at(0, k + 1), at(0, k)]);
        let end = circles - 1;
        mesh.triangles.push([pole, at(end, k), at(end, k + 1)]);
    }
    for circle in 0..circles - 1 {
        // The first circle is turned, then every other one.
        join(&mut mesh, circle % 2 == 0, [circle, circle + 1], at);
    }
    mesh
}

/// The closed tube through an even number of sections.
pub(super) fn closed_tube(radius: f64, sections: &[Section]) -> SurfaceMesh {
    let mut mesh = SurfaceMesh::default();
    for (k, section) in sections.iter().enumerate() {
        mesh.points.extend(section.circle(radius, 0.0, k % 2 == 1));
    }
    let at = |circle: usize, k: usize| (circle * AROUND + k % AROUND) as u32;
    for circle in 0..sections.len() {
        let next = (circle + 1) % sections.len();
        join(&mut mesh, circle % 2 == 1, [circle, next], at);
    }
    mesh
}

/// Joins two circles; `turned` if the points of the first one are half a step ahead.
fn join(
    mesh: &mut SurfaceMesh,
    turned: bool,
    [low, high]: [usize; 2],
    at: impl Fn(usize, usize) -> u32,
) {
    for k in 0..AROUND {
        // Points of the circle that is ahead lie behind those with the same number.
        let ahead = usize::from(turned);
        let (a, b) = (at(low, k), at(low, k + 1));
        let (c, d) = (at(high, k), at(high, k + 1));
        if ahead == 1 {
            mesh.triangles.push([a, b, d]);
            mesh.triangles.push([a, d, c]);
        } else {
            mesh.triangles.push([a, b, c]);
            mesh.triangles.push([b, d, c]);
        }
    }
}
