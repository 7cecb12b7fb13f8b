//! A body around which a mesh is generated.

use crate::Surface;

/// A body around which a mesh is generated.
#[derive(Clone, Copy)]
pub struct MeshedBody<'a> {
    /// Name, which becomes the tag of its facets.
    pub name: &'a str,
    /// Surface, which must be convex.
    pub surface: &'a dyn Surface,
    /// Edge length on the surface.
    ///
    /// Where the surface is strongly curved, edges are at most 0.7 of the smallest radius of
    /// curvature.
    pub size: f64,
}
