//! A part of a mesh, for programs that divide a mesh between processes.

use std::sync::Arc;

use crate::tet_mesh::Topology;
use crate::{Facet, MeshError, Regions, TetMesh, Vec3};

/// Number of a node that is not in the submesh.
const ABSENT: u32 = u32::MAX;

/// Some cells of a mesh as a mesh of their own, in the order of the whole mesh.
///
/// Faces at which the mesh was cut have no facet and no tag; all other properties of a
/// [`TetMesh`] hold.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Submesh {
    /// The cells with their nodes, vertices first, both in ascending order of the whole mesh.
    pub mesh: TetMesh,
    /// Number of each node in the whole mesh, ascending among vertices and among midside nodes.
    pub nodes: Vec<u32>,
}

impl Submesh {
    /// Number in the submesh of a node of the whole mesh; none if it is not in the submesh.
    pub fn number(&self, node: u32) -> Option<u32> {
        // Vertices come before midside nodes in both meshes, each in ascending order.
        let number = self.nodes.binary_search(&node);
        number.ok().map(|number| number as u32)
    }
}

impl TetMesh {
    /// The cells for which `is_kept` holds, with the boundary faces that belong to them.
    ///
    /// Tags keep their numbers, also those without a facet here. Cost: one pass over the mesh.
    ///
    /// ```
    /// use mesh::{LinearTets, TetMesh};
    /// let mesh = TetMesh::straight(LinearTets::cube(2))?;
    /// let half = mesh.submesh(|cell| cell < mesh.n_cells() / 2)?;
    /// assert_eq!(2 * half.mesh.n_cells(), mesh.n_cells());
    /// assert_eq!(half.mesh.points()[0], mesh.points()[half.nodes[0] as usize]);
    /// # Ok::<(), mesh::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// [`MeshError::Empty`] if no cell is kept.
    pub fn submesh(&self, is_kept: impl Fn(usize) -> bool) -> Result<Submesh, MeshError> {
        let kept: Vec<u32> = (0..self.n_cells() as u32)
            .filter(|&cell| is_kept(cell as usize))
            .collect();
        if kept.is_empty() {
            return Err(MeshError::Empty);
        }
        let mut number = vec![ABSENT; self.n_points()];
        for &cell in &kept {
            for &node in &self.cells()[cell as usize] {
                number[node as usize] = 0;
            }
        }
        let nodes: Vec<u32> = (0..self.n_points() as u32)
            .filter(|&node| number[node as usize] != ABSENT)
            .collect();
        for (own, &node) in nodes.iter().enumerate() {
            number[node as usize] = own as u32;
        }
        let mut cell_number = vec![ABSENT; self.n_cells()];
        for (own, &cell) in kept.iter().enumerate() {
            cell_number[cell as usize] = own as u32;
        }
        let facets = self.facets().iter().filter_map(|facet| {
            let cell = cell_number[facet.cell as usize];
            (cell != ABSENT).then(|| Facet {
                nodes: facet.nodes.map(|node| number[node as usize]),
                cell,
                tag: facet.tag,
            })
        });
        let of_cells = &self.regions().of_cells;
        let regions = Regions {
            names: self.regions().names.clone(),
            of_cells: (kept.iter())
                .filter_map(|&cell| of_cells.get(cell as usize).copied())
                .collect(),
        };
        let topology = Topology {
            n_vertices: nodes.partition_point(|&node| (node as usize) < self.n_vertices()),
            cells: (kept.iter())
                .map(|&cell| self.cells()[cell as usize].map(|node| number[node as usize]))
                .collect(),
            facets: facets.collect(),
            tags: self.tags().to_vec(),
            regions,
        };
        let points: Vec<Vec3> = nodes
            .iter()
            .map(|&node| self.points()[node as usize])
            .collect();
        Ok(Submesh {
            // The cells are those of a mesh that was checked.
            mesh: TetMesh {
                points,
                topology: Arc::new(topology),
            },
            nodes,
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::{LinearTets, TetMesh};

    #[test]
    fn cells_keep_their_positions_and_facets_their_tags() {
        let mesh = TetMesh::straight(LinearTets::cube(3)).unwrap();
        let part = mesh.submesh(|cell| cell % 3 == 1).unwrap();
        let cells = (0..mesh.n_cells()).filter(|cell| cell % 3 == 1);
        for (own, cell) in cells.enumerate() {
            assert_eq!(part.mesh.cell_points(own), mesh.cell_points(cell));
        }
        let kept = mesh.facets().iter().filter(|facet| facet.cell % 3 == 1);
        assert_eq!(kept.clone().count(), part.mesh.facets().len());
        for (own, facet) in part.mesh.facets().iter().zip(kept) {
            assert_eq!(own.nodes.map(|node| part.nodes[node as usize]), facet.nodes);
            assert_eq!(own.tag, facet.tag);
        }
        assert!(part.nodes[..part.mesh.n_vertices()].is_sorted());
        assert!(part.nodes[part.mesh.n_vertices()..].is_sorted());
    }

    #[test]
    fn a_submesh_without_cells_is_an_error() {
        let mesh = TetMesh::straight(LinearTets::cube(1)).unwrap();
        assert!(mesh.submesh(|_| false).is_err());
    }
}
