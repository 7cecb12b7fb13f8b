//! A second-order tet mesh as mesh files store it.

use crate::topology::EdgeIndex;
use crate::{LinearTets, MeshError, Regions, TET_EDGES, Vec3, used_points};

/// Nodes, 10-node tets and tagged 6-node boundary triangles, in any numbering and orientation.
///
/// [`TetMesh::quadratic`](crate::TetMesh::quadratic) turns it into a mesh with vertices numbered
/// first. Nodes that belong to no cell are ignored.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct QuadraticTets {
    /// All nodes, vertices and midside nodes mixed.
    pub points: Vec<Vec3>,
    /// Four vertices, then the midside nodes of [`TET_EDGES`].
    pub tets: Vec<[u32; 10]>,
    /// Three vertices, then the midside nodes of edges 01, 12, 20, with the index of the tag.
    pub faces: Vec<([u32; 6], u16)>,
    /// Names of the boundary parts.
    pub tags: Vec<String>,
    /// Named parts of the volume.
    pub regions: Regions,
}

impl QuadraticTets {
    /// The straight tets between the vertices, and the midside node of every edge in the numbering
    /// of [`EdgeIndex`].
    ///
    /// # Errors
    /// [`MeshError::OutOfRange`]; [`MeshError::BadMidside`] if an edge has two midside nodes or a
    /// node is both vertex and midside node.
    pub(crate) fn split(self) -> Result<(LinearTets, Vec<Vec3>), MeshError> {
        self.check_range()?;
        let corners = |tet: &[u32; 10]| [tet[0], tet[1], tet[2], tet[3]];
        let vertices = self.tets.iter().flat_map(corners);
        let (points, number) = used_points(&self.points, vertices);
        let tets: Vec<[u32; 4]> = (self.tets.iter())
            .map(|tet| corners(tet).map(|v| number[v as usize]))
            .collect();
        let edges = EdgeIndex::new(points.len(), &tets);
        let middle = self.middles(&tets, &number, &edges)?;
        let faces = self.straight_faces(&number, &edges, &middle)?;
        let middles = middle.iter().map(|&node| self.points[node as usize]);
        let middles = middles.collect();
        let linear = LinearTets {
            points,
            tets,
            faces,
            tags: self.tags,
            regions: self.regions,
        };
        Ok((linear, middles))
    }

    /// Checks that all nodes of cells and faces exist.
    fn check_range(&self) -> Result<(), MeshError> {
        let len = self.points.len();
        let cells = (self.tets.iter().enumerate()).map(|(i, tet)| ("tet", i, &tet[..]));
        let faces = (self.faces.iter().enumerate()).map(|(i, (face, _))| ("face", i, &face[..]));
        for (what, index, nodes) in cells.chain(faces) {
            if let Some(&number) = nodes.iter().find(|&&v| v as usize >= len) {
                return Err(MeshError::OutOfRange {
                    what,
                    index,
                    number: number as usize,
                    len,
                });
            }
        }
        Ok(())
    }

    /// The midside node of every edge of the cells, whose vertices are `tets`.
    ///
    /// Nodes that are not vertices have the `number` `u32::MAX`.
    fn middles(
        &self,
        tets: &[[u32; 4]],
        number: &[u32],
        edges: &EdgeIndex,
    ) -> Result<Vec<u32>, MeshError> {
        let mut middle = vec![u32::MAX; edges.len()];
        for (vertices, tet) in tets.iter().zip(&self.tets) {
            for ([i, j], &node) in TET_EDGES.into_iter().zip(&tet[4..]) {
                if number[node as usize] != u32::MAX {
                    return Err(self.bad_midside(node, "the node is also a vertex"));
                }
                if let Some(edge) = edges.find(vertices[i], vertices[j]) {
                    if middle[edge] != u32::MAX && middle[edge] != node {
                        let problem = "another cell has a different midside node on this edge";
                        return Err(self.bad_midside(node, problem));
                    }
                    middle[edge] = node;
                }
            }
        }
        let mut taken = vec![false; self.points.len()];
        for &node in &middle {
            if std::mem::replace(&mut taken[node as usize], true) {
                return Err(self.bad_midside(node, "two edges have the same midside node"));
            }
        }
        Ok(middle)
    }

    /// The faces between the vertices; their midside nodes must be those of the cells.
    fn straight_faces(
        &self,
        number: &[u32],
        edges: &EdgeIndex,
        middle: &[u32],
    ) -> Result<Vec<([u32; 3], u16)>, MeshError> {
        let face = |(face, tag): &([u32; 6], u16)| {
            let [a, b, c, ab, bc, ca] = *face;
            let [x, y, z] = [a, b, c].map(|v| number[v as usize]);
            if let Some((_, old)) = [(x, a), (y, b), (z, c)]
                .into_iter()
                .find(|v| v.0 == u32::MAX)
            {
                return Err(self.bad_midside(old, "it is a vertex of a face, but not of a cell"));
            }
            for (i, j, node) in [(x, y, ab), (y, z, bc), (z, x, ca)] {
                if edges.find(i, j).is_some_and(|edge| middle[edge] != node) {
                    let problem = "a face and a cell have different midside nodes on this edge";
                    return Err(self.bad_midside(node, problem));
                }
            }
            Ok(([x, y, z], *tag))
        };
        self.faces.iter().map(face).collect()
    }

    fn bad_midside(&self, node: u32, problem: &'static str) -> MeshError {
        MeshError::BadMidside {
            at: self.points[node as usize].into(),
            problem,
        }
    }
}
