//! Parts of the boundary of the domain's mesh.

use mesh::Surface;
use nalgebra::{Isometry3, Vector3};

use super::geometry::{Geometry, ShapeKeys, placed};
use crate::error::SceneError;
use crate::keys::BodyFile;
use crate::surface_shape::SurfaceShape;

/// A part of the boundary of the domain's mesh, as it is.
#[derive(Clone, Debug, PartialEq)]
pub struct PartShape {
    /// The surface about the centre.
    pub shape: SurfaceShape,
}

impl Geometry for PartShape {
    fn keys() -> &'static [&'static str] {
        &[]
    }

    fn read(keys: ShapeKeys) -> Result<Self, SceneError> {
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

    fn lengths(&self) -> Vec<(&'static str, f64)> {
        self.shape.lengths()
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
