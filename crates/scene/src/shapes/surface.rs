//! Bodies with the surface of a file: a file of their own, or a part of the domain's mesh.

use mesh::Surface;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::geometry::{Geometry, ShapeFile, ShapeKeys, placed};
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

/// A part of the boundary of the domain's mesh, as it is.
#[derive(Clone, Debug, PartialEq)]
pub struct PartShape {
    /// The surface about the centre.
    pub shape: SurfaceShape,
}

impl ShapeFile for FileShape {
    fn keys() -> &'static [&'static str] {
        &["file", "surface_kind", "scale", "centre", "orientation"]
    }

    fn read(keys: &mut ShapeKeys) -> Result<Self, SceneError> {
        let file = keys.file;
        let surface = SurfaceKeys {
            group: &format!("bodies[{}]", keys.number),
            file: &file.file,
            kind: file.surface_kind,
            scale: file.scale,
        };
        let shape = keys.surfaces.read(keys.checks, surface)?;
        Ok(Self {
            shape: shape.about(file.centre.map(Vector3::from)),
            orientation: keys.orientation()?,
        })
    }

    fn write(&self, file: &mut BodyFile) {
        let shape = &self.shape;
        file.file = Some(shape.file.display().to_string());
        (file.surface_kind, file.scale) = (Some(shape.kind), Some(shape.scale));
        file.centre = Some(shape.centre.into());
        file.orientation = Some(self.orientation.into());
    }

    fn orientation(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_scaled_axis(self.orientation)
    }
}

impl ShapeFile for PartShape {
    fn keys() -> &'static [&'static str] {
        &[]
    }

    fn read(keys: &mut ShapeKeys) -> Result<Self, SceneError> {
        let Some(mesh) = keys.mesh else {
            let problem = "\"file\" is a part of the boundary of a mesh: it belongs to \
                           domain.kind = \"mesh\"; use shape = \"surface\" elsewhere";
            return Err(keys.checks.bad_value(&keys.path("shape"), problem));
        };
        let tag = keys.path("surface");
        let why = ": name the part of the mesh's boundary that is this body";
        let part = keys.required("surface", keys.file.surface.as_deref(), why)?;
        let shape = keys.surfaces.mesh_part(keys.checks, mesh, part, &tag)?;
        Ok(Self {
            shape: shape.about(keys.file.position.map(Vector3::from)),
        })
    }

    fn write(&self, _: &mut BodyFile) {}
}

/// Shapes whose geometry is that of a triangulated surface.
trait Triangulated {
    fn shape(&self) -> &SurfaceShape;
}

impl Triangulated for FileShape {
    fn shape(&self) -> &SurfaceShape {
        &self.shape
    }
}

impl Triangulated for PartShape {
    fn shape(&self) -> &SurfaceShape {
        &self.shape
    }
}

impl<T: Triangulated + ShapeFile> Geometry for T {
    fn lengths(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("file", self.bounding_radius()),
            ("file", self.size_radius()),
        ]
    }

    fn bounding_radius(&self) -> f64 {
        self.shape().bounding_radius()
    }

    fn size_radius(&self) -> f64 {
        self.shape().size_radius()
    }

    fn volume(&self) -> f64 {
        self.shape().volume()
    }

    fn centroid(&self) -> Vector3<f64> {
        self.shape().surface.centroid()
    }

    fn support_point(&self, n: &Vector3<f64>) -> Vector3<f64> {
        self.shape().surface.farthest(*n)
    }

    fn transverse_support_distance(&self, n: &Vector3<f64>) -> f64 {
        self.shape().surface.largest_distance_from_axis(*n)
    }

    fn surface(&self, pose: Isometry3<f64>, unit: f64) -> Option<Box<dyn Surface>> {
        placed(pose, self.shape().surface.scaled(1.0 / unit))
    }
}
