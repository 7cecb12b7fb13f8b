//! Smooth closed surfaces of bodies and containers.

use crate::Vec3;

/// A smooth closed surface: what the generator and the curving of midside nodes need to know of a shape.
///
/// Distances are negative inside the shape and positive outside it, for bodies and containers alike.
pub trait Surface: Sync {
    /// Signed distance from `point` to the surface, negative inside the shape.
    fn signed_distance(&self, point: Vec3) -> f64;

    /// The point of the surface closest to `point`.
    fn closest_point(&self, point: Vec3) -> Vec3;

    /// Centre and radius of a ball that contains the shape.
    fn bounding_ball(&self) -> (Vec3, f64);

    /// A point inside the shape from which every point of the surface can be seen.
    fn centre(&self) -> Vec3 {
        self.bounding_ball().0
    }

    /// Volume enclosed by the surface.
    fn volume(&self) -> f64;

    /// Smallest radius of curvature, which bounds the element size that can follow the surface.
    fn smallest_curvature_radius(&self) -> f64;

    /// Distance to the nearest place of the surface where it is curved most; elements may grow with it.
    ///
    /// Zero, the default, stands for a surface that is curved alike everywhere.
    fn distance_to_sharpest(&self, _point: Vec3) -> f64 {
        0.0
    }
}

/// The sphere `|x - centre| = radius`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre.
    pub centre: Vec3,
    /// Radius, positive.
    pub radius: f64,
}

impl Surface for Sphere {
    fn signed_distance(&self, point: Vec3) -> f64 {
        (point - self.centre).norm() - self.radius
    }

    fn closest_point(&self, point: Vec3) -> Vec3 {
        let arm = point - self.centre;
        let distance = arm.norm();
        // The centre is equally far from every point: any of them is closest.
        let direction = if distance > 0.0 {
            arm / distance
        } else {
            Vec3::x()
        };
        self.centre + self.radius * direction
    }

    fn bounding_ball(&self) -> (Vec3, f64) {
        (self.centre, self.radius)
    }

    fn volume(&self) -> f64 {
        4.0 / 3.0 * std::f64::consts::PI * self.radius.powi(3)
    }

    fn smallest_curvature_radius(&self) -> f64 {
        self.radius
    }
}

/// The spheroid with semi-axis `axial` along the unit vector `axis` and `equatorial` across it.
///
/// Prolate for `axial > equatorial`, oblate for less, a sphere when they are equal.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// Axial coordinate, distance from the axis, and the direction away from the axis of a point.
    fn cylindrical(&self, point: Vec3) -> (f64, f64, Vec3) {
        let arm = point - self.centre;
        let z = arm.dot(&self.axis);
        let across = arm - z * self.axis;
        let r = across.norm();
        // On the axis every direction across it serves.
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
    /// With e >= f the larger and smaller semi-axis, the foot is `(e^2 y0 / (t + e^2), f^2 y1 / (t + f^2))` at the only root
    /// above `-f^2` of `(e y0 / (t + e^2))^2 + (f y1 / (t + f^2))^2 = 1` (Eberly, "Distance from a point to an ellipse").
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
            // Bisection: to the last bit after as many halvings as a f64 has bits, from a bracket of a few units.
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
            // Between the centres of curvature of the tips the long axis is closer to the sides.
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

    fn smallest_curvature_radius(&self) -> f64 {
        // b^2 / a at prolate tips; a^2 / b around the oblate rim, in the plane of the axis.
        let (long, short) = (
            self.axial.max(self.equatorial),
            self.axial.min(self.equatorial),
        );
        short * short / long
    }

    fn distance_to_sharpest(&self, point: Vec3) -> f64 {
        let (z, r, _) = self.cylindrical(point);
        if self.axial > self.equatorial {
            (z.abs() - self.axial).hypot(r)
        } else if self.axial < self.equatorial {
            z.hypot(r - self.equatorial)
        } else {
            0.0
        }
    }
}

/// The surface of the box `min <= x <= max`, sides along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxSurface {
    /// Lower corner.
    pub min: Vec3,
    /// Upper corner, above `min` in each coordinate.
    pub max: Vec3,
}

impl Surface for BoxSurface {
    fn signed_distance(&self, point: Vec3) -> f64 {
        // How far outside each pair of faces the point is, negative between them.
        let beyond = (self.min - point).sup(&(point - self.max));
        let outside = beyond.map(|b| b.max(0.0)).norm();
        outside + beyond.max().min(0.0)
    }

    fn closest_point(&self, point: Vec3) -> Vec3 {
        let mut foot = point.sup(&self.min).inf(&self.max);
        if foot == point {
            // Inside: out through the nearest face, whose coordinate is met exactly.
            let depth = (point - self.min).inf(&(self.max - point));
            let axis = depth.imin();
            let upper = self.max[axis] - point[axis] < point[axis] - self.min[axis];
            foot[axis] = if upper {
                self.max[axis]
            } else {
                self.min[axis]
            };
        }
        foot
    }

    fn bounding_ball(&self) -> (Vec3, f64) {
        let half = 0.5 * (self.max - self.min);
        (self.min + half, half.norm())
    }

    fn volume(&self) -> f64 {
        (self.max - self.min).product()
    }

    /// Zero: the edges are sharp.
    fn smallest_curvature_radius(&self) -> f64 {
        0.0
    }
}

/// A cylinder about the line through `centre` along x, closed by hemispheres.
///
/// A tube without the edges that flat ends would have: inside, a flow that is driven by bodies far from the ends hardly knows them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// Centre.
    pub centre: Vec3,
    /// Radius of the cylinder and of the hemispheres, positive.
    pub radius: f64,
    /// Half the length of the cylinder, positive.
    pub half_length: f64,
}

impl Capsule {
    /// The closest point of the axis, between the centres of the hemispheres.
    fn on_axis(&self, point: Vec3) -> Vec3 {
        let along = (point.x - self.centre.x).clamp(-self.half_length, self.half_length);
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
        // All directions across the axis are equally far from a point on it.
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

    fn smallest_curvature_radius(&self) -> f64 {
        self.radius
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
    fn feet_on_a_spheroid_are_perpendicular_and_on_it() {
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
    fn centre_of_a_spheroid_is_the_short_axis_inside() {
        for shape in [spheroid(3.0, 1.0), spheroid(0.4, 1.5)] {
            let short = shape.axial.min(shape.equatorial);
            assert_relative_eq!(shape.signed_distance(shape.centre), -short, epsilon = 1e-14);
        }
    }

    #[test]
    fn box_distances() {
        let shape = BoxSurface {
            min: Vec3::zeros(),
            max: Vec3::new(1.0, 2.0, 3.0),
        };
        assert_eq!(shape.signed_distance(Vec3::new(0.5, 0.9, 1.0)), -0.5);
        assert_eq!(shape.signed_distance(Vec3::new(4.0, 6.0, 1.0)), 5.0);
        assert_eq!(shape.closest_point(Vec3::new(0.5, 1.9, 1.0)).y, 2.0);
        assert_eq!(
            shape.closest_point(Vec3::new(0.5, 5.0, 7.0)),
            Vec3::new(0.5, 2.0, 3.0)
        );
        assert_eq!(shape.volume(), 6.0);
    }

    #[test]
    fn capsule_distances() {
        let shape = Capsule {
            centre: Vec3::new(1.0, 0.0, 0.0),
            radius: 2.0,
            half_length: 3.0,
        };
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
