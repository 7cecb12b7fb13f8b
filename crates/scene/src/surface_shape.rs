//! Closed surfaces from files, as bodies and as domains.

use std::path::PathBuf;

use mesher::TriangulatedSurface;
use nalgebra::Vector3;

use crate::words::SurfaceKind;

/// A closed surface from a file, in the units of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceShape {
    /// The surface: of a body about its centre and before its rotation, of a domain where it is.
    pub surface: TriangulatedSurface,
    /// The file; a relative path was resolved from the folder of the scene file.
    pub file: PathBuf,
    /// How its triangles are understood.
    pub kind: SurfaceKind,
    /// Length of the scene per length of the file.
    pub scale: f64,
    /// The point of the file that is the centre of the body, in coordinates of the file; zero for a
    /// domain.
    pub centre: Vector3<f64>,
    /// Name of the part of the boundary, if the file is the mesh of the domain.
    pub part: Option<String>,
}

impl SurfaceShape {
    /// Radius on which element sizes are based: three times the volume over the area, but at most
    /// 2.5 times the radius of the largest ball inside.
    ///
    /// The first is the radius of a ball, 1.5 radii of a long tube and 3 half thicknesses of a
    /// plate.
    pub fn size_radius(&self) -> f64 {
        use mesh::Surface;
        let surface = &self.surface;
        (3.0 * surface.volume() / surface.area()).min(2.5 * surface.inradius())
    }

    /// Volume inside the surface.
    pub fn volume(&self) -> f64 {
        use mesh::Surface;
        self.surface.volume()
    }

    /// Radius of the ball about the centre that contains the surface.
    pub fn bounding_radius(&self) -> f64 {
        use mesh::Surface;
        self.surface.bounding_ball().1
    }
}
