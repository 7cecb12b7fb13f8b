//! Detection of bodies that are translated copies of each other.

use super::geodesic::geodesic_sphere;
use super::meshed_body::MeshedBody;

/// For each body, the first body of which it is a translated copy, or itself.
pub(crate) fn first_copies(bodies: &[MeshedBody<'_>]) -> Vec<usize> {
    let mut firsts: Vec<usize> = Vec::with_capacity(bodies.len());
    for (i, body) in bodies.iter().enumerate() {
        // Comparing with bodies that are not copies themselves is enough.
        let first = (0..i).find(|&j| firsts[j] == j && is_copy(body, &bodies[j]));
        firsts.push(first.unwrap_or(i));
    }
    firsts
}

/// Whether two bodies differ by a translation only, according to the distances of points around
/// them.
fn is_copy(a: &MeshedBody<'_>, b: &MeshedBody<'_>) -> bool {
    let ((_, r_a), (_, r_b)) = (a.surface.bounding_ball(), b.surface.bounding_ball());
    // Tolerance for the rounding of positions, which may be large compared with the radius.
    let largest = a
        .surface
        .centre()
        .norm()
        .max(b.surface.centre().norm())
        .max(r_a);
    let rounding = 64.0 * f64::EPSILON * largest;
    let same = |x: f64, y: f64| (x - y).abs() <= rounding;
    a.size == b.size
        && same(r_a, r_b)
        && geodesic_sphere(0.5).points.iter().all(|d| {
            let arm = 1.5 * r_a * d;
            same(
                a.surface.signed_distance(a.surface.centre() + arm),
                b.surface.signed_distance(b.surface.centre() + arm),
            )
        })
}
