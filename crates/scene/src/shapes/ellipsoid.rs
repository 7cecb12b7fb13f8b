//! Ellipsoids.

use mesh::Surface;
use nalgebra::{Isometry3, Vector3};

use super::geometry::{BALL, Geometry, MAX_RADIUS_PER_HALF_THICKNESS, placed, shape_struct};

shape_struct! {
    /// An ellipsoid.
    EllipsoidShape {
        /// Semi-axes along x, y and z before the rotation.
        semi_axes: Vector3<f64> = ": an ellipsoid needs its three semi-axes",
        orientation
    }
}

impl Geometry for EllipsoidShape {
    fn lengths(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("semi_axes", self.semi_axes.max()),
            ("semi_axes", self.semi_axes.min()),
        ]
    }

    fn moments_per_mass(&self) -> Option<Vector3<f64>> {
        Some(moments(self.semi_axes))
    }

    fn bounding_radius(&self) -> f64 {
        self.semi_axes.max()
    }

    fn size_radius(&self) -> f64 {
        let (low, high) = (self.semi_axes.min(), self.semi_axes.max());
        (self.semi_axes.sum() - low - high).min(MAX_RADIUS_PER_HALF_THICKNESS * low)
    }

    fn volume(&self) -> f64 {
        BALL * self.semi_axes.product()
    }

    fn support_point(&self, n: &Vector3<f64>) -> Vector3<f64> {
        support_point(self.semi_axes, n)
    }

    fn transverse_support_distance(&self, n: &Vector3<f64>) -> f64 {
        transverse_support_distance(self.semi_axes, n)
    }

    fn surface(&self, pose: Isometry3<f64>, unit: f64) -> Option<Box<dyn Surface>> {
        let semi_axes = self.semi_axes.map(|length| length / unit);
        placed(pose, mesher::Ellipsoid { semi_axes })
    }
}

/// Principal moments of inertia of a homogeneous ellipsoid of unit mass.
pub(super) fn moments(semi_axes: Vector3<f64>) -> Vector3<f64> {
    let squares = semi_axes.component_mul(&semi_axes) / 5.0;
    Vector3::repeat(squares.sum()) - squares
}

/// The point of an ellipsoid farthest along `n`.
pub(super) fn support_point(semi_axes: Vector3<f64>, n: &Vector3<f64>) -> Vector3<f64> {
    let scaled = n.component_mul(&semi_axes);
    let norm = scaled.norm();
    scaled.component_mul(&semi_axes) / if norm > 0.0 { norm } else { 1.0 }
}

/// Largest semi-axis of the shadow along `n`: the larger eigenvalue of its 2 x 2 matrix.
pub(super) fn transverse_support_distance(semi_axes: Vector3<f64>, n: &Vector3<f64>) -> f64 {
    let squares = semi_axes.component_mul(&semi_axes);
    let other = if n.x.abs() < 0.5 {
        Vector3::x()
    } else {
        Vector3::y()
    };
    let u = n.cross(&other).normalize();
    let v = n.cross(&u);
    let entry = |a: &Vector3<f64>, b: &Vector3<f64>| a.component_mul(&squares).dot(b);
    let (uu, uv, vv) = (entry(&u, &u), entry(&u, &v), entry(&v, &v));
    (0.5 * (uu + vv) + (0.5 * (uu - vv)).hypot(uv)).sqrt()
}
