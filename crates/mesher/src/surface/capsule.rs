//! Cylinders closed by hemispheres.

use super::tube::{Section, intervals, open_tube};
use mesh::{Surface, SurfaceMesh, Vec3};

/// A cylinder along x, closed by hemispheres.
///
/// As a container it represents a tube: it has no sharp edges, and the shape of the ends has little
/// effect on a flow driven by bodies far from them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Capsule {
    /// Centre.
    pub centre: Vec3,
    /// Radius of the cylinder and of the hemispheres, positive.
    pub radius: f64,
    /// Half the length of the cylinder, positive.
    pub half_length: f64,
}

impl Capsule {
    /// The cylinder along x about `centre` with half spheres at its ends.
    pub const fn new(centre: Vec3, radius: f64, half_length: f64) -> Self {
        Self {
            centre,
            radius,
            half_length,
        }
    }

    /// Closest point of the segment between the centres of the hemispheres.
    fn on_axis(&self, point: Vec3) -> Vec3 {
        // not `clamp`, which panics for a length that is negative or NaN
        let along = (point.x - self.centre.x)
            .min(self.half_length)
            .max(-self.half_length);
        self.centre + Vec3::x() * along
    }
}

impl Surface for Capsule {
    fn signed_distance(&self, point: Vec3) -> f64 {
        (point - self.on_axis(point)).norm() - self.radius
    }

    fn closest_point(&self, point: Vec3) -> Vec3 {
        let foot = self.on_axis(point);
        let arm = point - foot;
        let distance = arm.norm();
        // From a point on the axis all radial directions are equally short; one is chosen.
        let direction = if distance > 0.0 {
            arm / distance
        } else {
            Vec3::y()
        };
        foot + self.radius * direction
    }

    fn bounding_ball(&self) -> (Vec3, f64) {
        (self.centre, self.half_length + self.radius)
    }

    fn volume(&self) -> f64 {
        std::f64::consts::PI
            * self.radius.powi(2)
            * (2.0 * self.half_length + 4.0 / 3.0 * self.radius)
    }

    fn is_convex(&self) -> bool {
        true
    }

    fn reach(&self) -> f64 {
        self.radius
    }

    fn triangulation(&self) -> Option<SurfaceMesh> {
        let count = intervals(2.0 * self.half_length, self.radius, 1);
        let sections: Vec<Section> = (0..=count)
            .map(|k| Section {
                centre: self.centre
                    + Vec3::x() * (self.half_length * (2.0 * k as f64 / count as f64 - 1.0)),
                across: [Vec3::y(), Vec3::z()],
            })
            .collect();
        Some(open_tube(self.radius, &sections))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn capsule_distances() {
        let shape = Capsule::new(Vec3::new(1.0, 0.0, 0.0), 2.0, 3.0);
        assert_eq!(shape.signed_distance(Vec3::new(3.0, 0.0, -0.5)), -1.5);
        assert_eq!(shape.signed_distance(Vec3::new(7.0, 4.0, 0.0)), 3.0);
        let foot = shape.closest_point(Vec3::new(-2.0, 0.0, 1.0));
        assert_eq!(foot, Vec3::new(-2.0, 0.0, 2.0));
        assert_eq!(
            shape.closest_point(Vec3::new(5.0, 0.0, 0.0)),
            Vec3::new(6.0, 0.0, 0.0)
        );
    }
}
