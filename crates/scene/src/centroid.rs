//! Centres of volume of shapes: where the weight of a homogeneous body acts.

use std::f64::consts::{PI, TAU};

use nalgebra::{UnitQuaternion, Vector3};

use crate::{Body, Shape};

/// Distance of a centroid from the position, over the radius of the body, that is rounding.
const ROUNDING: f64 = 1e-9;

impl Shape {
    /// Centre of volume in the initial configuration, relative to the position of the body.
    ///
    /// Zero for shapes with a centre of symmetry, and for points. A helix has its centroid on the
    /// line through its position and the middle of its curve: with the curvature `k` of the curve
    /// and a tube of the radius `b` the first moment of a piece is `π b^2 + k π b^4 / 4` outwards
    /// over the radius, because the outer side of a bent tube is longer (Pappus), and the half
    /// balls at the ends have their centroids `3/8 b` beyond the ends.
    ///
    /// ```
    /// # use scene::Shape;
    /// # use nalgebra::Vector3;
    /// let helix = Shape::Helix {
    ///     radius: 1.0,
    ///     tube_radius: 1e-4,
    ///     pitch: 0.0,
    ///     turns: 0.5,
    ///     orientation: Vector3::zeros(),
    /// };
    /// // half a thin ring has its centroid 2 R / π from the centre
    /// assert!((helix.centroid() - Vector3::y() * std::f64::consts::FRAC_2_PI).norm() < 1e-4);
    /// ```
    pub fn centroid(&self) -> Vector3<f64> {
        let own = match self {
            Self::Surface { shape, .. } => shape.surface.centroid(),
            Self::Helix {
                radius,
                tube_radius: b,
                pitch,
                turns,
                ..
            } => {
                let speed = radius.hypot(pitch / TAU);
                let curvature = radius / (speed * speed);
                let (sin, cos) = (PI * turns).sin_cos();
                let of_tube = PI * b * b * (radius + 0.25 * curvature * b * b) * speed * 2.0 * sin;
                let of_end = radius * cos - 0.375 * b * radius / speed * sin;
                let of_ends = 4.0 / 3.0 * PI * b.powi(3) * of_end;
                Vector3::y() * ((of_tube + of_ends) / self.volume())
            }
            _ => return Vector3::zeros(),
        };
        self.orientation() * own
    }
}

impl Body {
    /// Position of the point on which the weight acts relative to the position of the body, in the
    /// initial configuration; `None` if they are the same.
    pub fn weight_arm(&self) -> Option<Vector3<f64>> {
        let arm = self.shape.centroid();
        (arm.norm() > ROUNDING * self.bounding_radius()).then_some(arm)
    }

    /// Torque of the weight about the position of the body after this rotation from the initial
    /// configuration.
    pub fn weight_torque(&self, rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
        let torque = |arm: Vector3<f64>| (rotation * arm).cross(&self.weight);
        self.weight_arm().map_or_else(Vector3::zeros, torque)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The divergence theorem on a fine triangulation: `∫ x dV = ∮ x^2 n / 2 dS`, component-wise.
    #[test]
    fn the_centroid_of_a_helix_is_that_of_the_volume_inside_its_surface() {
        for (turns, pitch) in [(0.6, 1.5), (1.3, -2.0), (2.0, 1.7)] {
            let shape = Shape::Helix {
                radius: 1.0,
                tube_radius: 0.3,
                pitch,
                turns,
                orientation: Vector3::new(0.4, -1.0, 0.7),
            };
            let surface = shape.surface(&nalgebra::Isometry3::identity(), 1.0);
            let surface = surface.expect("a helix has a surface");
            let mesh = surface.triangulation().expect("a triangulation");
            let corners = |triangle: &[u32; 3]| triangle.map(|v| mesh.points[v as usize]);
            let mut triangles: Vec<[Vector3<f64>; 3]> =
                mesh.triangles.iter().map(corners).collect();
            for _ in 0..4 {
                let quarters = |[a, b, c]: [Vector3<f64>; 3]| {
                    let middle = |x: Vector3<f64>, y| surface.closest_point((x + y) * 0.5);
                    let [d, e, f] = [middle(a, b), middle(b, c), middle(c, a)];
                    [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
                };
                triangles = triangles.into_iter().flat_map(quarters).collect();
            }
            let (mut volume, mut moment) = (0.0, Vector3::zeros());
            for [a, b, c] in triangles {
                // The tetrahedron of the triangle and the origin, with its sign.
                let part = a.dot(&b.cross(&c)) / 6.0;
                volume += part;
                moment += (a + b + c) * (part / 4.0);
            }
            let error = (moment / volume - shape.centroid()).norm();
            // 128 facets around the tube lose (2π / 128)^2 / 6 of its volume, 4e-4, everywhere.
            assert!((volume / shape.volume() - 1.0).abs() < 1e-3);
            assert!(error < 1e-4, "{turns} turns: {error:e}");
        }
    }

    #[test]
    fn shapes_with_a_centre_of_symmetry_have_no_arm() {
        let body = Shape::Sphere { radius: 2.0 };
        assert_eq!(body.centroid(), Vector3::zeros());
    }
}
