//! Closed surfaces in files of their own.

use mesh::Surface;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::geometry::{Geometry, ShapeKeys, placed};
use crate::error::SceneError;
use crate::keys::BodyFile;
use crate::surface_shape::{SurfaceKeys, SurfaceShape};

/// A closed surface from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct FileShape {
    /// The surface about the centre, before the rotation.
    pub shape: SurfaceShape,
    /// Rotation vector, in radians.
    pub orientation: Vector3<f64>,
}

impl Geometry for FileShape {
    fn keys() -> &'static [&'static str] {
        &["file", "surface_kind", "scale", "centre", "orientation"]
    }

    fn read(keys: ShapeKeys) -> Result<Self, SceneError> {
        let file = keys.file;
        let (centre, orientation) = (file.centre.map(Vector3::from), keys.orientation());
        let surface = SurfaceKeys {
            group: &format!("bodies[{}]", keys.number),
            file: &file.file,
            kind: file.surface_kind,
            scale: file.scale,
        };
        Ok(Self {
            shape: keys.surfaces.read(keys.checks, surface)?.about(centre),
            orientation,
        })
    }

    fn write(&self, file: &mut BodyFile) {
        let shape = &self.shape;
        file.file = Some(shape.file.display().to_string());
        (file.surface_kind, file.scale) = (Some(shape.kind), Some(shape.scale));
        file.centre = Some(shape.centre.into());
        file.orientation = Some(self.orientation.into());
    }

    fn lengths(&self) -> Vec<(&'static str, f64)> {
        self.shape.lengths()
    }

    fn orientation(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_scaled_axis(self.orientation)
    }

    fn bounding_radius(&self) -> f64 {
        self.shape.bounding_radius()
    }

    fn size_radius(&self) -> f64 {
        self.shape.size_radius()
    }

    fn volume(&self) -> f64 {
        self.shape.volume()
    }

    fn centroid(&self) -> Vector3<f64> {
        self.shape.surface.centroid()
    }

    fn support_point(&self, n: &Vector3<f64>) -> Vector3<f64> {
        self.shape.surface.farthest(*n)
    }

    fn transverse_support_distance(&self, n: &Vector3<f64>) -> f64 {
        self.shape.surface.largest_distance_from_axis(*n)
    }

    fn surface(&self, pose: Isometry3<f64>, unit: f64) -> Option<Box<dyn Surface>> {
        placed(pose, self.shape.surface.scaled(1.0 / unit))
    }
}
