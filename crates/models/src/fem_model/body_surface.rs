//! The surfaces of bodies in a configuration, in scaled units.

use mesh::{Capsule, Disk, Ellipsoid, Helix, Placed, Sphere, Surface, Torus};
use nalgebra::{Isometry3, Vector3};
use scene::Shape;

use crate::units::Scale;

/// The surface of a body at a pose; `None` for a point.
///
/// The pose is in scaled units, relative to the initial configuration.
pub fn body_surface(
    shape: &Shape,
    scale: &Scale,
    pose: &Isometry3<f64>,
) -> Option<Box<dyn Surface>> {
    let pose = Isometry3::from_parts(pose.translation, pose.rotation * shape.orientation());
    let length = |length: f64| scale.length(length);
    Some(match *shape {
        // Rotations do not change it.
        Shape::Sphere { radius } => Box::new(Sphere {
            centre: pose.translation.vector,
            radius: length(radius),
        }),
        Shape::Ellipsoid { semi_axes, .. } => placed(pose, ellipsoid(scale, semi_axes)),
        Shape::Spheroid {
            radius,
            half_length,
            ..
        } => placed(
            pose,
            ellipsoid(scale, Vector3::new(half_length, radius, radius)),
        ),
        Shape::Capsule {
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
        Shape::Disk {
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
        Shape::Torus {
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
        Shape::Helix {
            radius,
            tube_radius,
            pitch,
            turns,
            ..
        } => placed(
            pose,
            Helix::new(length(radius), length(pitch), turns, length(tube_radius)),
        ),
        Shape::Point => return None,
    })
}

fn ellipsoid(scale: &Scale, semi_axes: Vector3<f64>) -> Ellipsoid {
    Ellipsoid {
        semi_axes: semi_axes.map(|length| scale.length(length)),
    }
}

fn placed<S: Surface + 'static>(pose: Isometry3<f64>, shape: S) -> Box<dyn Surface> {
    Box::new(Placed { shape, pose })
}
