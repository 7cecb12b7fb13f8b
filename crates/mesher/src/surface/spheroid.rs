//! Ellipsoids of revolution.

use mesh::{Surface, Vec3};

/// The spheroid with semi-axis `axial` along the unit vector `axis` and `equatorial` across it.
///
/// Prolate if `axial > equatorial`, oblate if `axial < equatorial`, a sphere if they are equal.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Spheroid {
    /// Centre.
    pub centre: Vec3,
    /// Direction of the symmetry axis, a unit vector.
    pub axis: Vec3,
    /// Half the length along the axis, positive.
    pub axial: f64,
    /// Radius of the equator, positive.
    pub equatorial: f64,
}

impl Spheroid {
    /// Cylindrical coordinates of a point: axial coordinate, distance from the axis, radial
    /// direction.
    fn cylindrical(&self, point: Vec3) -> (f64, f64, Vec3) {
        let arm = point - self.centre;
        let z = arm.dot(&self.axis);
        let across = arm - z * self.axis;
        let r = across.norm();
        // On the axis the radial direction is not unique; one is chosen.
        let out = if r > 0.0 {
            across / r
        } else {
            let other = if self.axis.x.abs() < 0.5 {
                Vec3::x()
            } else {
                Vec3::y()
            };
            self.axis.cross(&other).normalize()
        };
        (z, r, out)
    }

    /// Closest point of the ellipse `(z/axial)^2 + (r/equatorial)^2 = 1`, `r >= 0`, to `(z, r)`.
    ///
    /// With `e >= f` the semi-axes and `(y0, y1)` the coordinates along them, the closest point is
    /// `(e^2 y0 / (t + e^2), f^2 y1 / (t + f^2))`, where `t` is the only root above `-f^2` of
    /// `(e y0 / (t + e^2))^2 + (f y1 / (t + f^2))^2 = 1` (Eberly, "Distance from a point to an
    /// ellipse").
    fn foot(&self, z: f64, r: f64) -> (f64, f64) {
        let prolate = self.axial >= self.equatorial;
        let (e, f, y0, y1) = if prolate {
            (self.axial, self.equatorial, z.abs(), r)
        } else {
            (self.equatorial, self.axial, r, z.abs())
        };
        let (x0, x1) = if y1 > 0.0 {
            let excess =
                |t: f64| (e * y0 / (t + e * e)).powi(2) + (f * y1 / (t + f * f)).powi(2) - 1.0;
            let mut low = -f * f + f * y1;
            let mut high = -f * f + (e * y0).hypot(f * y1);
            // Bisection down to the last bit; the loop ends earlier when the bracket cannot shrink.
            for _ in 0..2 * f64::MANTISSA_DIGITS {
                let t = 0.5 * (low + high);
                if t <= low || t >= high {
                    break;
                }
                if excess(t) > 0.0 {
                    low = t;
                } else {
                    high = t;
                }
            }
            let t = 0.5 * (low + high);
            (e * e * y0 / (t + e * e), f * f * y1 / (t + f * f))
        } else if e > f && y0 < (e * e - f * f) / e {
            // On the long axis between the centres of curvature of the tips, the closest points lie
            // on the sides, not at the tips.
            let x0 = e * e * y0 / (e * e - f * f);
            (x0, f * (1.0 - (x0 / e).powi(2)).max(0.0).sqrt())
        } else {
            (e, 0.0)
        };
        let (z_foot, r_foot) = if prolate { (x0, x1) } else { (x1, x0) };
        (z_foot.copysign(z), r_foot)
    }
}

impl Surface for Spheroid {
    fn signed_distance(&self, point: Vec3) -> f64 {
        let (z, r, _) = self.cylindrical(point);
        let (z_foot, r_foot) = self.foot(z, r);
        let inside = (z / self.axial).hypot(r / self.equatorial) < 1.0;
        let distance = (z - z_foot).hypot(r - r_foot);
        if inside { -distance } else { distance }
    }

    fn closest_point(&self, point: Vec3) -> Vec3 {
        let (z, r, out) = self.cylindrical(point);
        let (z_foot, r_foot) = self.foot(z, r);
        self.centre + z_foot * self.axis + r_foot * out
    }

    fn bounding_ball(&self) -> (Vec3, f64) {
        (self.centre, self.axial.max(self.equatorial))
    }

    fn volume(&self) -> f64 {
        4.0 / 3.0 * std::f64::consts::PI * self.axial * self.equatorial * self.equatorial
    }

    fn is_convex(&self) -> bool {
        true
    }

    fn reach(&self) -> f64 {
        // b^2 / a at the tips of a prolate spheroid; a^2 / b at the rim of an oblate one, in planes
        // through the axis.
        let (long, short) = (
            self.axial.max(self.equatorial),
            self.axial.min(self.equatorial),
        );
        short * short / long
    }

    fn inradius(&self) -> f64 {
        self.axial.min(self.equatorial)
    }

    fn curvature_size(&self, point: Vec3, factor: f64, growth: f64) -> f64 {
        let (z, r, _) = self.cylindrical(point);
        let to_sharpest = if self.axial > self.equatorial {
            (z.abs() - self.axial).hypot(r)
        } else if self.axial < self.equatorial {
            z.hypot(r - self.equatorial)
        } else {
            0.0
        };
        let distance = self.signed_distance(point).max(0.0);
        factor * self.reach() + growth * to_sharpest.max(distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn spheroid(axial: f64, equatorial: f64) -> Spheroid {
        Spheroid {
            centre: Vec3::new(0.3, -0.2, 0.1),
            axis: Vec3::new(1.0, 2.0, 2.0) / 3.0,
            axial,
            equatorial,
        }
    }

    #[test]
    fn closest_points_are_on_the_spheroid_along_its_normal() {
        for shape in [spheroid(3.0, 1.0), spheroid(0.4, 1.5), spheroid(1.0, 1.0)] {
            for k in 0..200 {
                let k = f64::from(k);
                let x = shape.centre
                    + Vec3::new((1.3 * k).sin(), (2.1 * k).cos(), (0.7 * k).sin()) * (0.02 * k);
                let foot = shape.closest_point(x);
                let (z, r, out) = shape.cylindrical(foot);
                assert_relative_eq!(
                    (z / shape.axial).hypot(r / shape.equatorial),
                    1.0,
                    epsilon = 1e-13
                );
                let normal =
                    z / shape.axial.powi(2) * shape.axis + r / shape.equatorial.powi(2) * out;
                let arm = x - foot;
                assert!(arm.cross(&normal.normalize()).norm() < 1e-12 * (1.0 + arm.norm()));
                assert_relative_eq!(shape.signed_distance(x).abs(), arm.norm(), epsilon = 1e-13);
            }
        }
    }

    #[test]
    fn depth_of_the_centre_is_the_shorter_semi_axis() {
        for shape in [spheroid(3.0, 1.0), spheroid(0.4, 1.5)] {
            let short = shape.axial.min(shape.equatorial);
            assert_relative_eq!(shape.signed_distance(shape.centre), -short, epsilon = 1e-14);
        }
    }
}
