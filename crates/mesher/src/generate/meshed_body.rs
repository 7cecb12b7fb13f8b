//! A body around which a mesh is generated.

use mesh::Surface;

/// A body around which a mesh is generated.
#[derive(Clone, Copy)]
pub struct MeshedBody<'a> {
    /// Name, which becomes the tag of its facets.
    pub name: &'a str,
    /// Surface.
    pub surface: &'a dyn Surface,
    /// Edge length on the surface.
    ///
    /// Edges are shorter where the surface is strongly curved: at most 0.7 of the smaller radius of
    /// curvature, and less in proportion if `size` is less than 0.4 of the radius of the largest
    /// ball inside the body. They are at most 1.2 of this radius, so that opposite sides of a thin
    /// body stay separate.
    pub size: f64,
}
