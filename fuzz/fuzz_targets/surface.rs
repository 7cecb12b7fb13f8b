//! Any bytes are a surface in each format or refused, and so is the closed surface they describe.
#![no_main]

use libfuzzer_sys::fuzz_target;
use mesh::{SurfaceFormat, SurfaceMesh};
use mesher::{TriangleKind, TriangulatedSurface};

fuzz_target!(|bytes: &[u8]| {
    for format in [SurfaceFormat::Stl, SurfaceFormat::Obj, SurfaceFormat::Msh] {
        if let Ok(surface) = SurfaceMesh::parse("fuzzed", bytes, format) {
            drop(TriangulatedSurface::new(
                "fuzzed",
                surface,
                TriangleKind::Faceted,
            ));
        }
    }
});
