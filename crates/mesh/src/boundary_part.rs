//! Parts of the boundary of a mesh as surfaces.

use crate::{Facet, MeshError, SurfaceMesh, TetMesh};
use std::collections::HashMap;

/// Distance of a midside node from the middle of its edge, relative to the edge, above which a part
/// is curved. Midside nodes of straight edges are written with six digits or more.
const CURVED: f64 = 1e-5;

impl TetMesh {
    /// The facets of a boundary part as triangles that face into the fluid: out of a body.
    ///
    /// Facets of a curved part become four triangles each, with their midside nodes as vertices.
    /// The second value is whether the part is curved.
    ///
    /// # Errors
    /// [`MeshError::UnknownTag`].
    pub fn boundary_part(&self, name: &str) -> Result<(SurfaceMesh, bool), MeshError> {
        let tag = self.tag(name)?;
        let facets = || self.facets().iter().filter(|facet| facet.tag == tag);
        let at = |node: u32| self.points()[node as usize];
        let bends = |facet: &Facet| {
            let [a, b, c, ab, bc, ca] = facet.nodes;
            [[a, b, ab], [b, c, bc], [c, a, ca]]
                .into_iter()
                .any(|[a, b, middle]| {
                    let [a, b, middle] = [a, b, middle].map(at);
                    (middle - 0.5 * (a + b)).norm() > CURVED * (b - a).norm()
                })
        };
        let is_curved = facets().any(bends);
        let mut mesh = SurfaceMesh::default();
        let mut numbers = HashMap::new();
        for facet in facets() {
            let [a, b, c, ab, bc, ca] = facet.nodes;
            let triangles = match is_curved {
                true => vec![[a, ca, ab], [ab, bc, b], [ca, c, bc], [ab, ca, bc]],
                false => vec![[a, c, b]],
            };
            mesh.triangles.extend(triangles.into_iter().map(|triangle| {
                triangle.map(|node| {
                    *numbers.entry(node).or_insert_with(|| {
                        mesh.points.push(at(node));
                        mesh.points.len() as u32 - 1
                    })
                })
            }));
        }
        Ok((mesh, is_curved))
    }
}
