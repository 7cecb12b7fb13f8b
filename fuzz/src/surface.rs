//! Surfaces in STL, OBJ and Gmsh files.

use mesh::{SurfaceFormat, SurfaceMesh};
use mesher::{TriangleKind, TriangulatedSurface};

/// Reads the bytes in each format, and makes the closed surface that they describe.
pub fn read(bytes: &[u8]) {
    for format in [SurfaceFormat::Stl, SurfaceFormat::Obj, SurfaceFormat::Msh] {
        if let Ok(surface) = SurfaceMesh::parse("fuzzed", bytes, format) {
            drop(TriangulatedSurface::new(
                "fuzzed",
                surface,
                TriangleKind::Faceted,
            ));
        }
    }
}
