//! Which bodies touch each other or a wall, at a placement or along a leg of the gait.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use crate::scene::{Body, Domain};

/// The least room between two bodies, or between a body and the wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// One body.
    pub body: usize,
    /// The other, or none for the wall.
    pub other: Option<usize>,
    /// Distance between the surfaces, negative when they overlap.
    pub gap: f64,
}

impl Contact {
    /// Whether the surfaces touch or overlap; `size` is the length whose rounding counts as touching.
    pub fn touches(&self, size: f64) -> bool {
        // A gap that is a rounding error of the positions is no gap.
        self.gap <= 1e-12 * size
    }
}

/// The closest pair of surfaces of a placement; `None` if there is no pair (one body, no wall).
///
/// Points have no surface and touch nothing; gaps of spheroids are seen along the line of centres, where they are smallest at most.
/// Cost: all pairs.
pub fn closest_contact(
    bodies: &[Body],
    domain: &Domain,
    poses: &[Isometry3<f64>],
) -> Option<Contact> {
    let centre = |body: usize| poses[body].translation.vector;
    let solid: Vec<usize> = (0..bodies.len())
        .filter(|&b| bodies[b].bounding_radius() > 0.0)
        .collect();
    let mut closest: Option<Contact> = None;
    let mut take = |contact: Contact| {
        if closest.is_none_or(|found| contact.gap < found.gap) {
            closest = Some(contact);
        }
    };
    for (k, &body) in solid.iter().enumerate() {
        let room = domain.room(&bodies[body], &poses[body]);
        if room.is_finite() {
            take(Contact {
                body,
                other: None,
                gap: room,
            });
        }
        for &other in &solid[..k] {
            let apart = centre(body) - centre(other);
            let pair = [body, other].map(|b| (&bodies[b], &poses[b].rotation));
            take(Contact {
                body: other,
                other: Some(body),
                gap: apart.norm() - reaches(pair, &apart),
            });
        }
    }
    closest
}

/// How far two bodies, with their attitudes, reach towards each other along the line of their centres.
///
/// Distances less this are the gaps of spheres, and at most those of others: the bodies then are on two sides of a plane.
pub(crate) fn reaches(bodies: [(&Body, &UnitQuaternion<f64>); 2], apart: &Vector3<f64>) -> f64 {
    let direction = apart.try_normalize(0.0).unwrap_or_else(Vector3::x);
    bodies
        .iter()
        .map(|(body, attitude)| body.shape.reach(attitude, &direction))
        .sum()
}

/// The `s` in [0, 1] at which two points moving on straight lines at constant speed are closest, and how close.
///
/// The points' difference is `from + s (to - from)`.
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
    fn the_closest_approach_of_two_points_is_found_between_the_ends() {
        let (s, distance) =
            closest_approach(&Vector3::new(-1.0, 2.0, 0.0), &Vector3::new(3.0, 2.0, 0.0));
        assert_eq!((s, distance), (0.25, 2.0));
        let (s, distance) =
            closest_approach(&Vector3::new(10.0, 0.0, 0.0), &Vector3::new(6.0, 0.0, 0.0));
        assert_eq!((s, distance), (1.0, 6.0));
    }
}
