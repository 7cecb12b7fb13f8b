//! Coarse triangulations of tubes with a circular cross-section.

use mesh::{SurfaceMesh, Vec3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Points around a tube: edges of 0.77 radii.
const POINTS_AROUND: usize = 8;

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

    /// Circle of points with the given radius, shifted along the tube, from the first unit vector
    /// on or turned by half a step.
    ///
    /// Points on the axes across the tube are there exactly, so that symmetry planes contain them.
    fn circle(&self, radius: f64, shift: f64, turned: bool) -> Vec<Vec3> {
        let centre = self.centre + shift * self.tangent();
        let [u, v] = self.across;
        let start = if turned { 0.5 } else { 0.0 };
        let point = |k: usize| {
            let angle = 2.0 * PI * (k as f64 + start) / POINTS_AROUND as f64;
            let (sin, cos) = angle.sin_cos();
            let [along, across] = [cos, sin].map(|x| if x.abs() < 1e-15 { 0.0 } else { x });
            centre + radius * (along * u + across * v)
        };
        (0..POINTS_AROUND).map(point).collect()
    }
}

/// Number of intervals of about one radius in a length, at least `least`.
pub(super) fn intervals(length: f64, radius: f64, least: usize) -> usize {
    ((length / radius).ceil() as usize).max(least)
}

/// The tube through the sections, with round ends.
pub(super) fn open_tube(radius: f64, sections: &[Section]) -> SurfaceMesh {
    let (Some(first), Some(last)) = (sections.first(), sections.last()) else {
        return SurfaceMesh::default();
    };
    // Half of each end: a circle at 45 degrees and the pole.
    let diagonal = radius * FRAC_PI_4.cos();
    let mut circles = vec![first.circle(diagonal, -diagonal, true)];
    let inner = sections.iter().enumerate();
    circles.extend(inner.map(|(k, section)| section.circle(radius, 0.0, k % 2 == 1)));
    circles.push(last.circle(diagonal, diagonal, sections.len() % 2 == 1));
    let poles = [
        first.centre - radius * first.tangent(),
        last.centre + radius * last.tangent(),
    ];
    closed_by_poles(poles, circles, Turned::EveryOther)
}

/// The surface through circles of these radii, closed by its poles.
///
/// Its triangles do not cross the planes of the axes across the tube.
pub(super) fn circles_with_poles(poles: [Vec3; 2], sections: &[(Section, f64)]) -> SurfaceMesh {
    let circles = (sections.iter()).map(|(section, radius)| section.circle(*radius, 0.0, false));
    closed_by_poles(poles, circles.collect(), Turned::None)
}

/// The sphere about the x axis with `circles` circles of latitude, stretched to the semi-axes.
pub(super) fn stretched_sphere(semi_axes: Vec3, circles: usize) -> SurfaceMesh {
    let latitudes = (0..circles).map(|k| PI * (k + 1) as f64 / (circles + 1) as f64 - FRAC_PI_2);
    let equator = Section {
        centre: Vec3::zeros(),
        across: [Vec3::y(), Vec3::z()],
    };
    let circles = latitudes
        .enumerate()
        .map(|(k, latitude)| equator.circle(latitude.cos(), latitude.sin(), k % 2 == 0));
    let poles = [-Vec3::x(), Vec3::x()];
    let mut mesh = closed_by_poles(poles, circles.collect(), Turned::EveryOther);
    for p in &mut mesh.points {
        p.component_mul_assign(&semi_axes);
    }
    mesh
}

/// Circles that are turned by half a step.
#[derive(Clone, Copy, PartialEq)]
enum Turned {
    None,
    /// The first one, the third one and so on.
    EveryOther,
}

/// Joins circles and closes both ends.
fn closed_by_poles(
    [start, end]: [Vec3; 2],
    circles: Vec<Vec<Vec3>>,
    turned: Turned,
) -> SurfaceMesh {
    let mut mesh = SurfaceMesh::default();
    let count = circles.len();
    mesh.points.push(start);
    mesh.points.extend(circles.into_iter().flatten());
    mesh.points.push(end);
    let at = |circle: usize, k: usize| (1 + circle * POINTS_AROUND + k % POINTS_AROUND) as u32;
    let pole = mesh.points.len() as u32 - 1;
    for k in 0..POINTS_AROUND {
        mesh.triangles.push([0, at(0, k + 1), at(0, k)]);
        mesh.triangles
            .push([pole, at(count - 1, k), at(count - 1, k + 1)]);
    }
    for circle in 0..count - 1 {
        let is_turned = turned == Turned::EveryOther && circle % 2 == 0;
        join(&mut mesh, is_turned, [circle, circle + 1], at);
    }
    mesh
}

/// The closed tube through an even number of sections.
pub(super) fn closed_tube(radius: f64, sections: &[Section]) -> SurfaceMesh {
    let mut mesh = SurfaceMesh::default();
    for (k, section) in sections.iter().enumerate() {
        mesh.points.extend(section.circle(radius, 0.0, k % 2 == 1));
    }
    let at = |circle: usize, k: usize| (circle * POINTS_AROUND + k % POINTS_AROUND) as u32;
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
    for k in 0..POINTS_AROUND {
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
