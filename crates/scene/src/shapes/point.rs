//! Massless points.

use mesh::Surface;
use nalgebra::{Isometry3, Vector3};

use super::geometry::{Geometry, ShapeFile, ShapeKeys};
use crate::error::SceneError;
use crate::keys::BodyFile;

/// A massless point without a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PointShape;

impl ShapeFile for PointShape {
    fn keys() -> &'static [&'static str] {
        &[]
    }

    fn read(_: &mut ShapeKeys) -> Result<Self, SceneError> {
        Ok(Self)
    }

    fn write(&self, _: &mut BodyFile) {}
}

impl Geometry for PointShape {
    fn lengths(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    fn is_isotropic(&self) -> bool {
        true
    }

    fn bounding_radius(&self) -> f64 {
        0.0
    }

    fn size_radius(&self) -> f64 {
        0.0
    }

    fn volume(&self) -> f64 {
        0.0
    }

    fn support_point(&self, _: &Vector3<f64>) -> Vector3<f64> {
        Vector3::zeros()
    }

    fn transverse_support_distance(&self, _: &Vector3<f64>) -> f64 {
        0.0
    }

    fn surface(&self, _: Isometry3<f64>, _: f64) -> Option<Box<dyn Surface>> {
        None
    }
}
