//! Gaps between bodies, and between bodies and walls.

use nalgebra::{Isometry3, Matrix3, Vector3};
use rigid::ExternalLoad;

use crate::body::Body;
use crate::domain::Domain;
use crate::hull_distance::{distance, separation};

/// Gap between two bodies, or between a body and the nearest wall; in a periodic box between the
/// nearest images.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Contact {
    /// One body.
    pub body: usize,
    /// The other body, or the same one for its own periodic image; `None` for the wall.
    pub other: Option<usize>,
    /// Distance between the surfaces, negative if they overlap.
    pub gap: f64,
}

impl Contact {
    /// Whether the surfaces touch or overlap.
    ///
    /// A gap of less than `1e-12 size` is a rounding error and counts as touching, and so does a
    /// gap that is not a number.
    pub fn touches(&self, size: f64) -> bool {
        self.gap.is_nan() || self.gap <= 1e-12 * size
    }
}

/// The smallest gap of a configuration; `None` if there is no pair (one body, no wall and no
/// periodic image).
///
/// Points have no surface and touch nothing. Shapes other than spheres count as their convex hulls,
/// and their gaps are lower bounds. A body without a pose, or with one that is not finite, has a
/// gap that is not a number. Cost: pairs that may be closer than the closest one of those before
/// them along the x axis; in a periodic box all pairs.
pub fn closest_contact(
    bodies: &[Body],
    domain: &Domain,
    poses: &[Isometry3<f64>],
) -> Option<Contact> {
    let solid: Vec<usize> = (0..bodies.len())
        .filter(|&b| bodies[b].bounding_radius() > 0.0)
        .collect();
    let is_placed = |pose: &Isometry3<f64>| pose.to_homogeneous().iter().all(|x| x.is_finite());
    if let Some(&body) = solid
        .iter()
        .find(|&&b| !poses.get(b).is_some_and(is_placed))
    {
        return Some(Contact {
            body,
            other: None,
            gap: f64::NAN,
        });
    }
    // Of equal gaps the first in the order of `contacts`.
    let order = |contact: &Contact| match contact.other {
        None => (contact.body, 0),
        Some(later) => (later, 1 + contact.body),
    };
    // A gap that is not a number is the smallest.
    let size = |gap: f64| if gap.is_nan() { f64::NEG_INFINITY } else { gap };
    let closer = |one: Contact, other: Contact| {
        let gaps = size(other.gap).total_cmp(&size(one.gap));
        match gaps.then(order(&other).cmp(&order(&one))).is_lt() {
            true => other,
            false => one,
        }
    };
    if domain.period().is_some() {
        return contacts(bodies, domain, poses).reduce(closer);
    }
    let centre = |body: usize| poses[body].translation.vector;
    let radius = |body: usize| bodies[body].bounding_radius();
    let of_walls = solid
        .iter()
        .filter_map(|&body| to_wall(bodies, domain, poses, body));
    let mut closest = of_walls.reduce(closer);
    let mut sorted = solid;
    sorted.sort_by(|a, b| centre(*a).x.total_cmp(&centre(*b).x).then(a.cmp(b)));
    let largest = sorted.iter().map(|&body| radius(body)).fold(0.0, f64::max);
    for (place, &body) in sorted.iter().enumerate() {
        for &before in sorted[..place].iter().rev() {
            let apart = centre(body) - centre(before);
            let found = closest.map_or(f64::INFINITY, |closest| closest.gap);
            if apart.x - radius(body) - largest > found {
                break;
            }
            // Bodies are inside the spheres around their centres.
            if apart.norm() - radius(body) - radius(before) <= found {
                let pair = [body.max(before), body.min(before)];
                let contact = between(bodies, domain, poses, pair);
                closest = Some(closest.map_or(contact, |closest| closer(closest, contact)));
            }
        }
    }
    closest
}

/// The gap between a body and the wall; none without a wall.
fn to_wall(
    bodies: &[Body],
    domain: &Domain,
    poses: &[Isometry3<f64>],
    body: usize,
) -> Option<Contact> {
    let gap = domain.clearance(&bodies[body], &poses[body]);
    gap.is_finite().then_some(Contact {
        body,
        other: None,
        gap,
    })
}

/// The gap between two bodies, the later one given first; in a periodic box between the images with
/// the nearest centres.
fn between(
    bodies: &[Body],
    domain: &Domain,
    poses: &[Isometry3<f64>],
    pair: [usize; 2],
) -> Contact {
    let [later, first] = pair.map(|body| poses[body].translation.vector);
    let apart = domain.nearest_image(&(later - first));
    let shapes = pair.map(|body| (&bodies[body].shape, &poses[body].rotation));
    Contact {
        body: pair[1],
        other: Some(pair[0]),
        gap: distance(shapes, &apart),
    }
}

/// The gaps of all pairs of bodies, of all bodies and the wall, and of all bodies and their own
/// periodic images, in a fixed order.
///
/// In a periodic box pairs are those of the images with the nearest centres: exact for spheres.
/// Points have no surface and are left out. Shapes other than spheres count as their convex hulls,
/// and their gaps are lower bounds. Bodies without a pose are left out.
pub fn contacts<'a>(
    bodies: &'a [Body],
    domain: &'a Domain,
    poses: &'a [Isometry3<f64>],
) -> impl Iterator<Item = Contact> + 'a {
    let solid: Vec<usize> = (0..bodies.len().min(poses.len()))
        .filter(|&b| bodies[b].bounding_radius() > 0.0)
        .collect();
    (0..solid.len()).flat_map(move |k| {
        let body = solid[k];
        let pairs: Vec<Contact> = (solid[..k].iter())
            .map(|&other| between(bodies, domain, poses, [body, other]))
            .collect();
        let own_image = domain.period().map(|size| {
            let own = (&bodies[body].shape, &poses[body].rotation);
            let edges = Matrix3::from_diagonal(&size);
            let gaps = edges
                .column_iter()
                .map(|edge| distance([own; 2], &edge.into_owned()));
            Contact {
                body,
                other: Some(body),
                gap: gaps.fold(f64::INFINITY, f64::min),
            }
        });
        let to_wall = to_wall(bodies, domain, poses, body);
        to_wall.into_iter().chain(pairs).chain(own_image)
    })
}

/// A short-range repulsion between surfaces that nearly touch.
///
/// In a gap `h`, the force on each of two bodies is
///
/// ```text
/// F = strength / (exp(h / range) - 1)
/// ```
///
/// away from the other one along the line of the closest points of their convex hulls, and the same
/// on a body away from a wall (Brady & Bossis 1985, J. Fluid Mech. 155, with `range = 1/τ` and
/// `strength = F_0 τ`). Torques are those of the forces at these points. Surfaces that touch get no
/// finite force. In a periodic box all images within 37 ranges repel each other.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Repulsion {
    /// Length over which the force decays.
    pub range: f64,
    /// Force at the gap `range ln 2`.
    pub strength: f64,
}

/// Gaps in units of the range at which the repulsion is below rounding, `e^-37`.
const MAX_RANGES: f64 = 37.0;

impl Repulsion {
    /// The force in a gap, not negative.
    ///
    /// ```
    /// use scene::Scene;
    /// let text = "contact = { range = 0.1, strength = 3 }\n\
    ///     bodies = [{ name = \"a\", radius = 1, position = [0, 0, 0] }]";
    /// let repulsion = *Scene::parse(text)?.repulsion().unwrap();
    /// assert!((repulsion.force(0.1 * 2.0_f64.ln()) - 3.0).abs() < 1e-14);
    /// # Ok::<(), scene::SceneError>(())
    /// ```
    pub fn force(&self, gap: f64) -> f64 {
        self.strength / (gap / self.range).exp_m1().max(0.0)
    }

    /// Adds the forces and torques at these poses to the loads of all bodies.
    pub(crate) fn add_to(
        &self,
        loads: &mut [ExternalLoad],
        bodies: &[Body],
        domain: &Domain,
        poses: &[Isometry3<f64>],
    ) {
        let solid: Vec<usize> = (0..bodies.len().min(poses.len()))
            .filter(|&body| bodies[body].bounding_radius() > 0.0)
            .collect();
        // A force at the point of the surface that is farthest against its direction.
        let mut push = |body: usize, gap: f64, direction: Vector3<f64>| {
            let force = self.force(gap) * direction;
            let (shape, rotation) = (&bodies[body].shape, &poses[body].rotation);
            let arm = shape.support_point(rotation, &-direction);
            loads[body].force += force;
            loads[body].torque += arm.cross(&force);
        };
        for (k, &body) in solid.iter().enumerate() {
            for (gap, normal) in domain.wall_gaps(&bodies[body], &poses[body]) {
                push(body, gap, normal);
            }
            for &other in &solid[..k] {
                let apart = poses[body].translation.vector - poses[other].translation.vector;
                let radii = bodies[body].bounding_radius() + bodies[other].bounding_radius();
                let pair = [body, other].map(|b| (&bodies[b].shape, &poses[b].rotation));
                let reach = radii + MAX_RANGES * self.range;
                for shift in domain.shifts_within(&apart, reach) {
                    let apart = apart - shift;
                    if apart.norm() > reach && domain.period().is_some() {
                        continue;
                    }
                    let (gap, normal) = separation(pair, &apart);
                    push(body, gap, normal);
                    push(other, gap, -normal);
                }
            }
        }
    }
}

/// Parameter `s` in `[0, 1]` at which `|from + s (to - from)|` is smallest, and this minimum.
///
/// `from` and `to` are the differences of two points that move at constant velocities.
pub(crate) fn closest_approach(from: &Vector3<f64>, to: &Vector3<f64>) -> (f64, f64) {
    let change = to - from;
    let squared = change.norm_squared();
    let s = if squared > 0.0 {
        (-from.dot(&change) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (s, (from + s * change).norm())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closest_approach_is_inside_the_interval_or_at_its_end() {
        let (s, distance) =
            closest_approach(&Vector3::new(-1.0, 2.0, 0.0), &Vector3::new(3.0, 2.0, 0.0));
        assert_eq!((s, distance), (0.25, 2.0));
        let (s, distance) =
            closest_approach(&Vector3::new(10.0, 0.0, 0.0), &Vector3::new(6.0, 0.0, 0.0));
        assert_eq!((s, distance), (1.0, 6.0));
    }
}
