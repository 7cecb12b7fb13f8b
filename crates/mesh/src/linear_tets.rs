//! A first-order tet mesh: what the generator makes and what readers read, before edges get their midside nodes.

use crate::Vec3;

/// Vertices, tets and tagged boundary triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LinearTets {
    /// Vertices.
    pub points: Vec<Vec3>,
    /// Tets, positively oriented: `det(x1 - x0, x2 - x0, x3 - x0) > 0`.
    pub tets: Vec<[u32; 4]>,
    /// Boundary triangles, normal out of the fluid, with the index of their tag.
    pub faces: Vec<([u32; 3], u16)>,
    /// Names of the boundary parts.
    pub tags: Vec<String>,
}
