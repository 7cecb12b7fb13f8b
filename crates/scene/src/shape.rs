//! Shapes of bodies.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::surface_shape::SurfaceShape;
use crate::words::ShapeKind;

/// Shape of a body.
///
/// Bodies of revolution have an `axis`: its direction in the initial configuration, a unit vector.
/// Other shapes have an `orientation`: the rotation vector (radians) that turns their own
/// coordinates into the initial configuration.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A sphere.
    Sphere {
        /// Radius.
        radius: f64,
    },
    /// An ellipsoid.
    Ellipsoid {
        /// Semi-axes along x, y and z before the rotation.
        semi_axes: Vector3<f64>,
        /// Rotation vector, in radians.
        orientation: Vector3<f64>,
    },
    /// A spheroid: prolate if `half_length > radius`, oblate if `half_length < radius`.
    Spheroid {
        /// Radius of the equator.
        radius: f64,
        /// Half of the length along the axis of revolution.
        half_length: f64,
        /// Direction of the axis of revolution in the initial configuration, a unit vector.
        axis: Vector3<f64>,
    },
    /// A cylinder closed by hemispheres.
    Capsule {
        /// Radius of the cylinder and of the hemispheres.
        radius: f64,
        /// Half of the length including the hemispheres, larger than the radius.
        half_length: f64,
        /// Direction of the axis in the initial configuration, a unit vector.
        axis: Vector3<f64>,
    },
    /// A disk with a round rim.
    Disk {
        /// Radius including the rim.
        radius: f64,
        /// Half of the thickness and radius of the rim, smaller than the radius.
        half_length: f64,
        /// Normal of the disk in the initial configuration, a unit vector.
        axis: Vector3<f64>,
    },
    /// A torus.
    Torus {
        /// Radius of the circle in the middle of the tube.
        radius: f64,
        /// Radius of the tube, smaller than the radius of the circle.
        tube_radius: f64,
        /// Axis of revolution in the initial configuration, a unit vector.
        axis: Vector3<f64>,
    },
    /// A tube with round ends along a helix about the x axis, before the rotation.
    ///
    /// The middle of the helix is at `(0, radius, 0)` relative to the position.
    Helix {
        /// Radius of the helix in the middle of the tube.
        radius: f64,
        /// Radius of the tube.
        tube_radius: f64,
        /// Length along the axis per turn: positive if right-handed, negative if left-handed.
        pitch: f64,
        /// Number of turns.
        turns: f64,
        /// Rotation vector, in radians.
        orientation: Vector3<f64>,
    },
    /// A closed surface from a file, or a part of the boundary of the domain's mesh.
    Surface {
        /// The surface about the centre, before the rotation.
        shape: SurfaceShape,
        /// Rotation vector, in radians.
        orientation: Vector3<f64>,
    },
    /// A massless point without a surface.
    Point,
}

impl Shape {
    /// Kind of the shape, as in the scene file.
    pub fn kind(&self) -> ShapeKind {
        match self {
            Self::Sphere { .. } => ShapeKind::Sphere,
            Self::Ellipsoid { .. } => ShapeKind::Ellipsoid,
            Self::Spheroid { .. } => ShapeKind::Spheroid,
            Self::Capsule { .. } => ShapeKind::Capsule,
            Self::Disk { .. } => ShapeKind::Disk,
            Self::Torus { .. } => ShapeKind::Torus,
            Self::Helix { .. } => ShapeKind::Helix,
            Self::Surface { shape, .. } => match shape.part {
                Some(_) => ShapeKind::File,
                None => ShapeKind::Surface,
            },
            Self::Point => ShapeKind::Point,
        }
    }

    /// Whether the shape is a part of the boundary of the domain's mesh, which is used as it is.
    pub fn is_mesh_part(&self) -> bool {
        self.kind() == ShapeKind::File
    }

    /// Whether rotations do not change the shape.
    pub fn is_isotropic(&self) -> bool {
        matches!(self, Self::Sphere { .. } | Self::Point)
    }

    /// Axis of revolution in the initial configuration; `None` for spheres, points and shapes
    /// without such an axis.
    pub fn axis(&self) -> Option<Vector3<f64>> {
        match *self {
            Self::Spheroid { axis, .. }
            | Self::Capsule { axis, .. }
            | Self::Disk { axis, .. }
            | Self::Torus { axis, .. } => Some(axis),
            Self::Sphere { .. }
            | Self::Ellipsoid { .. }
            | Self::Helix { .. }
            | Self::Surface { .. }
            | Self::Point => None,
        }
    }

    /// Rotation of the shape's own coordinates into the initial configuration.
    ///
    /// In their own coordinates, bodies of revolution have the x axis as axis.
    pub fn orientation(&self) -> UnitQuaternion<f64> {
        match *self {
            Self::Ellipsoid { orientation, .. }
            | Self::Helix { orientation, .. }
            | Self::Surface { orientation, .. } => UnitQuaternion::from_scaled_axis(orientation),
            // All bodies of revolution are symmetric, so opposite axes need no rotation.
            _ => (self.axis())
                .and_then(|axis| UnitQuaternion::rotation_between(&Vector3::x(), &axis))
                .unwrap_or_else(UnitQuaternion::identity),
        }
    }

    /// Moments of inertia about the centre of a homogeneous body of unit mass, in the axes of the
    /// initial configuration; `None` for points and for shapes without a formula.
    ///
    /// ```
    /// use scene::Shape;
    /// let sphere = Shape::Sphere { radius: 2.0 };
    /// assert!((sphere.inertia_per_mass().unwrap()[(1, 1)] - 0.4 * 4.0).abs() < 1e-15);
    /// ```
    pub fn inertia_per_mass(&self) -> Option<Matrix3<f64>> {
        let of_semi_axes = |a: Vector3<f64>| {
            let squares = a.component_mul(&a) / 5.0;
            Vector3::repeat(squares.sum()) - squares
        };
        // Moments about the own x axis and about the others.
        let own = match *self {
            Self::Sphere { radius } => of_semi_axes(Vector3::repeat(radius)),
            Self::Ellipsoid { semi_axes, .. } => of_semi_axes(semi_axes),
            Self::Spheroid {
                radius,
                half_length,
                ..
            } => of_semi_axes(Vector3::new(half_length, radius, radius)),
            Self::Capsule {
                radius: r,
                half_length,
                ..
            } => {
                // A cylinder of the half length `h`, and two half balls with their centres of mass
                // 3/8 r beyond its ends.
                let h = half_length - r;
                let (cylinder, ball) = (2.0 * h, 4.0 / 3.0 * r);
                let along = cylinder * r * r / 2.0 + ball * 0.4 * r * r;
                let of_balls = 0.4 * r * r + h * h + 0.75 * h * r;
                let across = cylinder * (r * r / 4.0 + h * h / 3.0) + ball * of_balls;
                Vector3::new(along, across, across) / (cylinder + ball)
            }
            Self::Torus {
                radius,
                tube_radius,
                ..
            } => {
                let (large, small) = (radius * radius, tube_radius * tube_radius);
                let across = large / 2.0 + 0.625 * small;
                Vector3::new(large + 0.75 * small, across, across)
            }
            Self::Disk { .. } | Self::Helix { .. } | Self::Surface { .. } | Self::Point => {
                return None;
            }
        };
        let rotation = self.orientation().to_rotation_matrix();
        Some(rotation * Matrix3::from_diagonal(&own) * rotation.inverse())
    }

    /// Radius of the smallest ball about the centre that contains the body; zero for points.
    pub fn bounding_radius(&self) -> f64 {
        match *self {
            Self::Sphere { radius } | Self::Disk { radius, .. } => radius,
            Self::Ellipsoid { semi_axes, .. } => semi_axes.max(),
            Self::Spheroid {
                radius,
                half_length,
                ..
            } => radius.max(half_length),
            Self::Capsule { half_length, .. } => half_length,
            Self::Torus {
                radius,
                tube_radius,
                ..
            } => radius + tube_radius,
            Self::Helix {
                radius,
                tube_radius,
                pitch,
                turns,
                ..
            } => radius.hypot(0.5 * pitch * turns) + tube_radius,
            Self::Surface { ref shape, .. } => shape.bounding_radius(),
            Self::Point => 0.0,
        }
    }

    /// Radius on which element sizes are based: that of the tube or cylinder of long bodies, and of
    /// the outline of flat ones, but at most 2.5 of half their thickness. Zero for points.
    pub fn size_radius(&self) -> f64 {
        const OF_HALF_THICKNESS: f64 = 2.5;
        match *self {
            Self::Sphere { radius } | Self::Capsule { radius, .. } => radius,
            Self::Spheroid {
                radius,
                half_length,
                ..
            }
            | Self::Disk {
                radius,
                half_length,
                ..
            } => radius.min(OF_HALF_THICKNESS * half_length),
            Self::Ellipsoid { semi_axes, .. } => {
                let (low, high) = (semi_axes.min(), semi_axes.max());
                (semi_axes.sum() - low - high).min(OF_HALF_THICKNESS * low)
            }
            Self::Torus { tube_radius, .. } | Self::Helix { tube_radius, .. } => tube_radius,
            Self::Surface { ref shape, .. } => shape.size_radius(),
            Self::Point => 0.0,
        }
    }

    /// Points in the middle of the tube of a torus or helix, in the initial configuration relative
    /// to the position; they are closer to each other than a tube radius. Empty for other shapes.
    pub fn centreline(&self) -> Vec<Vector3<f64>> {
        let (radius, tube, pitch, turns) = match *self {
            Self::Torus {
                radius,
                tube_radius,
                ..
            } => (radius, tube_radius, 0.0, 1.0),
            Self::Helix {
                radius,
                tube_radius,
                pitch,
                turns,
                ..
            } => (radius, tube_radius, pitch, turns),
            _ => return Vec::new(),
        };
        let length = TAU.mul_add(radius, pitch.abs()) * turns;
        // A few thousand points are enough for any picture.
        let count = (2.0 * length / tube).clamp(48.0, 4096.0).ceil();
        let orientation = self.orientation();
        let at = |k: f64| {
            let t = turns * (k / count - 0.5);
            let (sin, cos) = (TAU * t).sin_cos();
            orientation * Vector3::new(pitch * t, radius * cos, radius * sin)
        };
        (0..=count as usize).map(|k| at(k as f64)).collect()
    }

    /// Volume; zero for points.
    ///
    /// That of a disk, whose rim is half of a torus, by Pappus' theorem. A helix is a tube along
    /// its curve with half balls at the ends.
    pub fn volume(&self) -> f64 {
        let ball = 4.0 / 3.0 * PI;
        match *self {
            Self::Sphere { radius } => ball * radius.powi(3),
            Self::Ellipsoid { semi_axes, .. } => ball * semi_axes.product(),
            Self::Spheroid {
                radius,
                half_length,
                ..
            } => ball * radius * radius * half_length,
            Self::Capsule {
                radius,
                half_length,
                ..
            } => ball * radius.powi(3) + TAU * radius * radius * (half_length - radius),
            Self::Disk {
                radius,
                half_length: h,
                ..
            } => {
                // A cylinder of the radius c with half a circle of the radius h turned around it.
                let c = radius - h;
                TAU * h * c * c + PI * PI * c * h * h + ball * h.powi(3)
            }
            Self::Torus {
                radius,
                tube_radius,
                ..
            } => TAU * PI * radius * tube_radius * tube_radius,
            Self::Helix {
                radius,
                tube_radius,
                pitch,
                turns,
                ..
            } => {
                let length = turns * (TAU * radius).hypot(pitch);
                PI * tube_radius * tube_radius * length + ball * tube_radius.powi(3)
            }
            Self::Surface { ref shape, .. } => shape.volume(),
            Self::Point => 0.0,
        }
    }

    /// Mean of the extents along three axes, halved: a radius for rough models.
    pub fn mean_radius(&self) -> f64 {
        let unit = UnitQuaternion::identity();
        // Opposite directions for a helix, which is not symmetric.
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| self.orientation() * axis);
        let extents = axes.iter().flat_map(|axis| [*axis, -*axis]);
        extents
            .map(|n| self.support_distance(&unit, &n))
            .sum::<f64>()
            / 6.0
    }

    /// The lengths of the shape with their keys.
    pub fn lengths(&self) -> Vec<(&'static str, f64)> {
        match *self {
            Self::Sphere { radius } => vec![("radius", radius)],
            Self::Ellipsoid { semi_axes, .. } => {
                vec![
                    ("semi_axes", semi_axes.max()),
                    ("semi_axes", semi_axes.min()),
                ]
            }
            Self::Spheroid {
                radius,
                half_length,
                ..
            }
            | Self::Capsule {
                radius,
                half_length,
                ..
            }
            | Self::Disk {
                radius,
                half_length,
                ..
            } => vec![("radius", radius), ("half_length", half_length)],
            Self::Torus {
                radius,
                tube_radius,
                ..
            } => vec![("radius", radius), ("tube_radius", tube_radius)],
            Self::Helix {
                radius,
                tube_radius,
                pitch,
                turns,
                ..
            } => vec![
                ("radius", radius),
                ("tube_radius", tube_radius),
                ("pitch", pitch.abs() * turns.max(1.0)),
            ],
            Self::Surface { ref shape, .. } => {
                vec![
                    ("file", shape.bounding_radius()),
                    ("file", shape.size_radius()),
                ]
            }
            Self::Point => Vec::new(),
        }
    }
}
