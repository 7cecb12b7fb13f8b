//! Ellipsoids with three semi-axes.

use super::tube::stretched_sphere;
use mesh::{Surface, SurfaceMesh, Vec3};
use std::f64::consts::PI;

/// Ratio of the longest to the middle semi-axis above which the longest determines the
/// triangulation.
const SLENDER: f64 = 1.5;

/// The ellipsoid about the origin with semi-axes along the coordinate axes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Ellipsoid {
    /// Semi-axes along x, y and z, positive.
    pub semi_axes: Vec3,
}

impl Ellipsoid {
    /// Axes in the order of descending semi-axes.
    fn order(&self) -> [usize; 3] {
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| self.semi_axes[j].total_cmp(&self.semi_axes[i]));
        order
    }

    /// Semi-axes in descending order.
    fn sorted(&self) -> [f64; 3] {
        self.order().map(|axis| self.semi_axes[axis])
    }

    fn is_inside(&self, point: Vec3) -> bool {
        point.component_div(&self.semi_axes).norm_squared() < 1.0
    }
}

/// Closest point to `y` on the ellipsoid with the semi-axes `e`, in descending order; all
/// coordinates of `y` are positive or zero.
///
/// The closest point is `e_i^2 y_i / (e_i^2 - e_n^2 + s)`, where `s > 0` is the root of
/// `sum_i (e_i y_i / (e_i^2 - e_n^2 + s))^2 = 1` (Eberly, "Distance from a point to an ellipsoid").
/// The sum is convex and decreasing, so that Newton's method converges from below.
fn foot(e: &[f64], y: &[f64], x: &mut [f64]) {
    let Some((&shortest, longer)) = e.split_last() else {
        return;
    };
    let last = longer.len();
    let excess = |i: usize| (e[i] - shortest) * (e[i] + shortest);
    if y[last] > 0.0 {
        // Each term alone is at most one at the root.
        let mut s = (0..=last).fold(0.0, |s: f64, i| s.max(e[i] * y[i] - excess(i)));
        for _ in 0..100 {
            let (mut sum, mut slope) = (-1.0, 0.0);
            for i in 0..=last {
                let d = excess(i) + s;
                let term = (e[i] * y[i] / d).powi(2);
                sum += term;
                slope += 2.0 * term / d;
            }
            let step = sum / slope;
            s += step;
            if step.is_nan() || step <= 4.0 * f64::EPSILON * s {
                break;
            }
        }
        for i in 0..=last {
            x[i] = e[i] * e[i] * y[i] / (excess(i) + s);
        }
        return;
    }
    // In the plane across the shortest axis: where the normals from above and below meet before
    // the plane, the closest point is off the plane.
    let in_plane = |i: usize| match y[i] > 0.0 {
        true => e[i] * y[i] / excess(i),
        false => 0.0,
    };
    let sum: f64 = (0..last).map(|i| in_plane(i).powi(2)).sum();
    if sum < 1.0 {
        for i in 0..last {
            x[i] = e[i] * in_plane(i);
        }
        x[last] = shortest * (1.0 - sum).sqrt();
    } else {
        x[last] = 0.0;
        foot(longer, &y[..last], &mut x[..last]);
    }
}

/// Smaller radius of curvature at the point `x` of the ellipsoid with semi-axes `e`.
///
/// With the distance `p` of the tangent plane from the centre, the Gaussian curvature is
/// `p^4 / (a b c)^2` and the sum of both curvatures `p^3 (a^2 + b^2 + c^2 - |x|^2) / (a b c)^2`.
fn curvature_radius(e: &[f64; 3], x: [f64; 3]) -> f64 {
    let (e, x) = (Vec3::from(*e), Vec3::from(x));
    let p = 1.0 / x.component_div(&e.component_mul(&e)).norm();
    let volume = e.product().powi(2);
    let gauss = p.powi(4) / volume;
    let half_sum = 0.5 * p.powi(3) * (e.norm_squared() - x.norm_squared()) / volume;
    let difference = (half_sum * half_sum - gauss).max(0.0).sqrt();
    1.0 / (half_sum + difference)
}

impl Surface for Ellipsoid {
    fn signed_distance(&self, point: Vec3) -> f64 {
        let distance = (point - self.closest_point(point)).norm();
        if self.is_inside(point) {
            -distance
        } else {
            distance
        }
    }

    fn closest_point(&self, point: Vec3) -> Vec3 {
        let order = self.order();
        let mut x = [0.0; 3];
        foot(&self.sorted(), &order.map(|i| point[i].abs()), &mut x);
        let mut closest = Vec3::zeros();
        for (x, axis) in x.into_iter().zip(order) {
            closest[axis] = x.copysign(point[axis]);
        }
        closest
    }

    fn bounding_ball(&self) -> (Vec3, f64) {
        (Vec3::zeros(), self.semi_axes.max())
    }

    fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.semi_axes.product()
    }

    fn is_convex(&self) -> bool {
        true
    }

    /// `c^2 / a` at the ends of the longest semi-axis.
    fn reach(&self) -> f64 {
        let [a, _, c] = self.sorted();
        c * c / a
    }

    fn inradius(&self) -> f64 {
        self.semi_axes.min()
    }

    /// Of the surface, these points count: the closest one, that of the ellipse of the longest and
    /// the middle semi-axes closest to `point`, and the ends of these semi-axes.
    fn curvature_size(&self, point: Vec3, factor: f64, growth: f64) -> f64 {
        let order = self.order();
        let x = Vec3::from(order.map(|axis| point[axis].abs()));
        let e = self.sorted();
        let (mut closest, mut on_ellipse) = ([0.0; 3], [0.0; 3]);
        foot(&e, x.as_slice(), &mut closest);
        foot(&e[..2], &x.as_slice()[..2], &mut on_ellipse[..2]);
        [closest, on_ellipse, [e[0], 0.0, 0.0], [0.0, e[1], 0.0]]
            .into_iter()
            .map(|y| factor * curvature_radius(&e, y) + growth * (x - Vec3::from(y)).norm())
            .fold(f64::INFINITY, f64::min)
    }

    fn triangulation(&self) -> Option<SurfaceMesh> {
        let order = self.order();
        let [a, b, _] = self.sorted();
        if a < SLENDER * b {
            return Some(stretched_sphere(self.semi_axes, 3));
        }
        // Circles across the longest axis, at most about a middle semi-axis apart.
        let circles = (PI * a / b).ceil() as usize;
        let mut mesh = stretched_sphere(Vec3::from(self.sorted()), circles);
        for p in &mut mesh.points {
            let own = *p;
            for (k, axis) in order.into_iter().enumerate() {
                p[axis] = own[k];
            }
        }
        // An odd permutation of the axes turns the triangles over.
        if (order[1] + 3 - order[0]) % 3 == 2 {
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        Some(mesh)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Spheroid;
    use approx::assert_relative_eq;

    #[test]
    fn closest_points_are_on_the_ellipsoid_along_its_normal() {
        for axes in [[3.0, 2.0, 1.0], [1.0, 1.0, 4.0], [0.2, 1.0, 1.0], [1.0; 3]] {
            let shape = Ellipsoid {
                semi_axes: axes.into(),
            };
            for k in 0..300 {
                let k = f64::from(k);
                let mut x =
                    Vec3::new((1.3 * k).sin(), (2.1 * k).cos(), (0.7 * k).sin()) * (0.01 * k);
                // Points in coordinate planes and on axes too.
                x[(k as usize / 3) % 3] *= if (k as usize).is_multiple_of(3) {
                    0.0
                } else {
                    1.0
                };
                x[(k as usize / 7) % 3] *= if (k as usize).is_multiple_of(4) {
                    0.0
                } else {
                    1.0
                };
                let foot = shape.closest_point(x);
                let scaled = foot.component_div(&shape.semi_axes);
                assert_relative_eq!(scaled.norm(), 1.0, epsilon = 1e-13);
                let normal = scaled.component_div(&shape.semi_axes).normalize();
                let arm = x - foot;
                assert!(
                    arm.cross(&normal).norm() < 1e-12 * (1.0 + arm.norm()),
                    "{axes:?} {x}"
                );
                // Not only a stationary point, but the closest one.
                for d in 0..50 {
                    let d = f64::from(d);
                    let other = Vec3::new(d.sin(), (1.7 * d).cos(), (2.3 * d).sin()).normalize();
                    let other = other.component_mul(&shape.semi_axes);
                    assert!((x - other).norm() >= arm.norm() - 1e-12);
                }
            }
        }
    }

    #[test]
    fn an_ellipsoid_with_two_equal_semi_axes_is_a_spheroid() {
        let shape = Ellipsoid {
            semi_axes: Vec3::new(0.5, 2.0, 0.5),
        };
        let spheroid = Spheroid {
            centre: Vec3::zeros(),
            axis: Vec3::y(),
            axial: 2.0,
            equatorial: 0.5,
        };
        assert_relative_eq!(shape.volume(), spheroid.volume());
        assert_relative_eq!(shape.reach(), spheroid.reach());
        for k in 0..200 {
            let k = f64::from(k);
            let x = Vec3::new((1.3 * k).sin(), (2.1 * k).cos(), (0.7 * k).sin()) * (0.01 * k);
            assert_relative_eq!(
                shape.signed_distance(x),
                spheroid.signed_distance(x),
                epsilon = 1e-13
            );
            let [a, b] = [
                shape.curvature_size(x, 0.7, 0.3),
                spheroid.curvature_size(x, 0.7, 0.3),
            ];
            assert!(a <= b + 1e-12 && a >= 0.7 * shape.reach(), "{a} {b}");
        }
    }
}
