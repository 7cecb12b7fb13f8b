//! The surfaces of shapes at a pose, as the mesh generator knows them.

use mesh::Surface;
use mesher::{Capsule, Disk, Ellipsoid, Helix, Placed, Sphere, Torus};
use nalgebra::{Isometry3, Vector3};

use crate::shape::Shape;

impl Shape {
    /// The surface of a body at a pose; `None` for a point.
    ///
    /// Lengths are divided by `unit`; the pose is in these scaled units and relative to the initial
    /// configuration.
    pub fn surface(&self, pose: &Isometry3<f64>, unit: f64) -> Option<Box<dyn Surface>> {
        let pose = Isometry3::from_parts(pose.translation, pose.rotation * self.orientation());
        let length = |length: f64| length / unit;
        let ellipsoid = |semi_axes: Vector3<f64>| Ellipsoid {
            semi_axes: semi_axes.map(length),
        };
        Some(match *self {
            // Rotations do not change it.
            Self::Sphere { radius } => Box::new(Sphere {
                centre: pose.translation.vector,
                radius: length(radius),
            }),
            Self::Ellipsoid { semi_axes, .. } => placed(pose, ellipsoid(semi_axes)),
            Self::Spheroid {
                radius,
                half_length,
                ..
            } => placed(pose, ellipsoid(Vector3::new(half_length, radius, radius))),
            Self::Capsule {
                radius,
                half_length,
                ..
            } => placed(
                pose,
                Capsule {
                    centre: Vector3::zeros(),
                    radius: length(radius),
                    half_length: length(half_length - radius),
                },
            ),
            Self::Disk {
                radius,
                half_length,
                ..
            } => placed(
                pose,
                Disk {
                    radius: length(radius),
                    half_thickness: length(half_length),
                },
            ),
            Self::Torus {
                radius,
                tube_radius,
                ..
            } => placed(
                pose,
                Torus {
                    radius: length(radius),
                    tube: length(tube_radius),
                },
            ),
            Self::Helix {
                radius,
                tube_radius,
                pitch,
                turns,
                ..
            } => placed(
                pose,
                Helix::new(length(radius), length(pitch), turns, length(tube_radius)),
            ),
            Self::Surface { ref shape, .. } => placed(pose, shape.surface.scaled(1.0 / unit)),
            Self::Point => return None,
        })
    }
}

fn placed<S: Surface + 'static>(pose: Isometry3<f64>, shape: S) -> Box<dyn Surface> {
    Box::new(Placed { shape, pose })
}
