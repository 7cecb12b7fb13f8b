//! What a shape defines: the keys that describe it, and its geometry.

use std::f64::consts::TAU;
use std::path::Path;

use mesh::Surface;
use mesher::Placed;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use crate::checks::{Checks, check_angle};
use crate::error::SceneError;
use crate::keys::{BodyFile, DEFAULT_AXIS, DEFAULT_ORIENTATION};
use crate::surface_shape::SurfaceFiles;

/// The keys of `bodies[]` that describe a shape; implemented by [`shape_struct`].
pub(crate) trait ShapeFile {
    /// The keys that belong to the shape.
    fn keys() -> &'static [&'static str]
    where
        Self: Sized;

    /// Reads the shape from its keys.
    fn read(keys: &mut ShapeKeys) -> Result<Self, SceneError>
    where
        Self: Sized;

    /// Enters the keys of the shape.
    fn write(&self, file: &mut BodyFile);

    /// Axis of revolution, the x axis of its own coordinates.
    fn axis(&self) -> Option<Vector3<f64>> {
        None
    }

    /// Rotation of its own coordinates into the initial configuration.
    fn orientation(&self) -> UnitQuaternion<f64> {
        // All bodies of revolution are symmetric, so opposite axes need no rotation.
        (self.axis())
            .and_then(|axis| UnitQuaternion::rotation_between(&Vector3::x(), &axis))
            .unwrap_or_else(UnitQuaternion::identity)
    }
}

/// Defines the struct of a shape with [`ShapeFile`].
///
/// Each field is the key of `bodies[]` of this name, with the end of the message "... is missing".
/// The last one is `axis` for bodies of revolution, `orientation` for other shapes, or missing.
macro_rules! shape_struct {
    (
        $(#[$doc:meta])+
        $name:ident {
            $( $(#[$meaning:meta])+ $key:ident: $ty:ty = $why:literal, )+
            $($placed:ident)?
        }
    ) => {
        $(#[$doc])+
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name {
            $( $(#[$meaning])+ pub $key: $ty, )+
            $(
                #[doc = shape_struct!(@meaning $placed)]
                pub $placed: nalgebra::Vector3<f64>,
            )?
        }

        impl $crate::shapes::geometry::ShapeFile for $name {
            fn keys() -> &'static [&'static str] {
                shape_struct!(@keys $($placed)?; $($key),+)
            }

            fn read(
                keys: &mut $crate::shapes::geometry::ShapeKeys,
            ) -> Result<Self, $crate::error::SceneError> {
                Ok(Self {
                    $( $key: keys.required(stringify!($key), keys.file.$key, $why)?.into(), )+
                    $( $placed: keys.$placed()?, )?
                })
            }

            fn write(&self, file: &mut $crate::keys::BodyFile) {
                $( file.$key = Some(self.$key.into()); )+
                $( file.$placed = Some(self.$placed.into()); )?
            }

            $( shape_struct!(@placed $placed); )?
        }
    };
    (@keys axis; $($key:ident),+) => { &[$(stringify!($key),)+ "axis", "orientation"] };
    (@keys $($placed:ident)?; $($key:ident),+) => {
        &[$(stringify!($key),)+ $(stringify!($placed))?]
    };
    (@meaning axis) => { "Direction of the axis in the initial configuration, a unit vector." };
    (@meaning orientation) => { "Rotation vector into the initial configuration, in radians." };
    (@placed axis) => {
        fn axis(&self) -> Option<nalgebra::Vector3<f64>> {
            Some(self.axis)
        }
    };
    (@placed orientation) => {
        fn orientation(&self) -> nalgebra::UnitQuaternion<f64> {
            nalgebra::UnitQuaternion::from_scaled_axis(self.orientation)
        }
    };
}

pub(super) use shape_struct;

/// A support point as a function of the unit vector along which it is farthest.
pub(crate) type Support<'a> = dyn Fn(&Vector3<f64>) -> Vector3<f64> + 'a;

/// A shape of bodies.
///
/// Its own coordinates have the centre of the body as origin; [`ShapeFile::orientation`] rotates
/// them into the initial configuration. Functions without `own` in their description are about the
/// axes of the initial configuration.
pub(crate) trait Geometry: ShapeFile {
    /// The key and the bound of a length that the proportions do not allow.
    fn problem(&self) -> Option<(&'static str, String)> {
        None
    }

    /// The lengths of the shape with their keys.
    fn lengths(&self) -> Vec<(&'static str, f64)>;

    /// Whether rotations do not change the shape.
    fn is_isotropic(&self) -> bool {
        false
    }

    /// Principal moments of inertia of a homogeneous body of unit mass about its own axes; `None`
    /// without a formula.
    fn moments_per_mass(&self) -> Option<Vector3<f64>> {
        None
    }

    /// Radius of the smallest ball about the centre that contains the body.
    fn bounding_radius(&self) -> f64;

    /// Radius on which element sizes are based.
    fn size_radius(&self) -> f64;

    /// Volume.
    fn volume(&self) -> f64;

    /// Centre of volume in its own coordinates.
    fn centroid(&self) -> Vector3<f64> {
        Vector3::zeros()
    }

    /// Points in the middle of a tube with its radius there; empty for other shapes.
    fn centreline(&self) -> Vec<(Vector3<f64>, f64)> {
        Vec::new()
    }

    /// The point farthest along the unit vector `n`, both in its own coordinates.
    fn support_point(&self, n: &Vector3<f64>) -> Vector3<f64>;

    /// [`Geometry::support_point`] as a function, for many unit vectors.
    fn support(&self) -> Box<Support<'_>> {
        Box::new(move |n| self.support_point(n))
    }

    /// Support distance along a unit vector after a rotation, if there is a shorter way than by the
    /// support point.
    fn support_distance(
        &self,
        _rotation: &UnitQuaternion<f64>,
        _direction: &Vector3<f64>,
    ) -> Option<f64> {
        None
    }

    /// Largest support distance over all directions perpendicular to the unit vector `n`, in its
    /// own coordinates, or an upper bound.
    fn transverse_support_distance(&self, n: &Vector3<f64>) -> f64;

    /// The surface with its own coordinates at `pose` and lengths divided by `unit`; `None` without
    /// a surface.
    fn surface(&self, pose: Isometry3<f64>, unit: f64) -> Option<Box<dyn Surface>>;
}

/// The keys of a body from which a shape is read.
pub(crate) struct ShapeKeys<'a> {
    pub checks: &'a Checks<'a>,
    /// Number of the body.
    pub number: usize,
    pub file: &'a BodyFile,
    /// The mesh of the domain, if it has one.
    pub mesh: Option<&'a Path>,
    pub surfaces: &'a mut SurfaceFiles,
}

impl ShapeKeys<'_> {
    /// Path of a key of the body.
    pub fn path(&self, key: &str) -> String {
        format!("bodies[{}].{key}", self.number)
    }

    /// The value of a key that must be present; `why` completes the sentence "... is missing".
    pub fn required<T>(&self, key: &str, value: Option<T>, why: &str) -> Result<T, SceneError> {
        self.checks.required(&self.path(key), value, why)
    }

    /// The rotation vector.
    pub fn orientation(&self) -> Result<Vector3<f64>, SceneError> {
        let rotation = Vector3::from(self.file.orientation.unwrap_or(DEFAULT_ORIENTATION));
        check_angle(self.checks, &self.path("orientation"), rotation.norm())?;
        Ok(rotation)
    }

    /// The axis of a body of revolution: given, or the x axis turned by the orientation.
    pub fn axis(&self) -> Result<Vector3<f64>, SceneError> {
        match (self.file.axis, self.file.orientation) {
            (Some(_), Some(_)) => Err(self.checks.bad_value(
                &self.path("orientation"),
                "is given beside axis, and either determines the other; remove one of them",
            )),
            (None, Some(_)) => {
                let rotation = UnitQuaternion::from_scaled_axis(self.orientation()?);
                Ok(rotation * Vector3::from(DEFAULT_AXIS))
            }
            (axis, None) => unit_axis(axis.unwrap_or(DEFAULT_AXIS)).ok_or_else(|| {
                let problem = "must not be zero: it is a direction";
                self.checks.bad_value(&self.path("axis"), problem)
            }),
        }
    }
}

/// The direction of a vector; `None` for zero.
fn unit_axis(axis: [f64; 3]) -> Option<Vector3<f64>> {
    let axis = Vector3::from(axis);
    let unit = axis.try_normalize(0.0)?;
    // A written unit vector reads back to the last bit, without a second normalisation.
    let is_unit = (axis.norm() - 1.0).abs() <= 2.0 * f64::EPSILON;
    Some(if is_unit { axis } else { unit })
}

/// A surface at a pose.
pub(super) fn placed<S: Surface + 'static>(
    pose: Isometry3<f64>,
    shape: S,
) -> Option<Box<dyn Surface>> {
    Some(Box::new(Placed { shape, pose }))
}

/// The size radius of flat bodies is at most this multiple of half their thickness.
pub(super) const MAX_RADIUS_PER_HALF_THICKNESS: f64 = 2.5;

/// Volume of the unit ball.
pub(super) const BALL: f64 = 4.0 / 3.0 * std::f64::consts::PI;

/// Direction of `n` across the x axis; any such direction if it is along the axis.
pub(super) fn outwards(n: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(0.0, n.y, n.z)
        .try_normalize(0.0)
        .unwrap_or_else(Vector3::y)
}

/// Points of the helix with a tube of the radius `tube`, closer to each other than this radius.
pub(super) fn helix_points(
    orientation: &UnitQuaternion<f64>,
    [radius, tube, pitch, turns]: [f64; 4],
) -> Vec<(Vector3<f64>, f64)> {
    let length = TAU.mul_add(radius, pitch.abs()) * turns;
    // A few thousand points are enough for any picture.
    let count = (2.0 * length / tube).clamp(48.0, 4096.0).ceil();
    let at = |k: f64| {
        let t = turns * (k / count - 0.5);
        let (sin, cos) = (TAU * t).sin_cos();
        let point = Vector3::new(pitch * t, radius * cos, radius * sin);
        (orientation * point, tube)
    };
    (0..=count as usize).map(|k| at(k as f64)).collect()
}
