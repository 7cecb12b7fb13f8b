//! A second-order tet mesh as mesh files store it.

use crate::topology::EdgeIndex;
use crate::{LinearTets, MeshError, Regions, TET_EDGES, Vec3};

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
        let len = self.points.len();
        let in_range = |what, index, nodes: &[u32]| match nodes.iter().find(|&&v| v as usize >= len)
        {
            Some(&number) => Err(MeshError::OutOfRange {
                what,
                index,
                number: number as usize,
                len,
            }),
            None => Ok(()),
        };
        for (i, tet) in self.tets.iter().enumerate() {
            in_range("tet", i, tet)?;
        }
        for (i, (face, _)) in self.faces.iter().enumerate() {
            in_range("face", i, face)?;
        }
        let corners = |tet: &[u32; 10]| [tet[0], tet[1], tet[2], tet[3]];
        // Vertices keep their order; nodes that are not vertices keep the number `u32::MAX`.
        let mut number = vec![u32::MAX; len];
        for tet in &self.tets {
            for v in corners(tet) {
                number[v as usize] = 0;
            }
        }
        let mut points = Vec::new();
        for (number, point) in number.iter_mut().zip(&self.points) {
            if *number == 0 {
                *number = points.len() as u32;
                points.push(*point);
            }
        }
        let bad = |node: u32, problem| {
            Err(MeshError::BadMidside {
                at: self.points[node as usize].into(),
                problem,
            })
        };
        let tets: Vec<_> = self
            .tets
            .iter()
            .map(|tet| corners(tet).map(|v| number[v as usize]))
            .collect();
        let edges = EdgeIndex::new(points.len(), &tets);
        let mut middle = vec![u32::MAX; edges.len()];
        for (vertices, tet) in tets.iter().zip(&self.tets) {
            for ([i, j], &node) in TET_EDGES.into_iter().zip(&tet[4..]) {
                if number[node as usize] != u32::MAX {
                    return bad(node, "the node is also a vertex");
                }
                if let Some(edge) = edges.find(vertices[i], vertices[j]) {
                    if middle[edge] != u32::MAX && middle[edge] != node {
                        return bad(
                            node,
                            "another cell has a different midside node on this edge",
                        );
                    }
                    middle[edge] = node;
                }
            }
        }
        let mut taken = vec![false; len];
        for &node in &middle {
            if std::mem::replace(&mut taken[node as usize], true) {
                return bad(node, "two edges have the same midside node");
            }
        }
        let mut faces = Vec::new();
        for (face, tag) in &self.faces {
            let [a, b, c, ab, bc, ca] = *face;
            let [x, y, z] = [a, b, c].map(|v| number[v as usize]);
            for (v, old) in [(x, a), (y, b), (z, c)] {
                if v == u32::MAX {
                    return bad(old, "it is a vertex of a face, but not of a cell");
                }
            }
            for (i, j, node) in [(x, y, ab), (y, z, bc), (z, x, ca)] {
                if edges.find(i, j).is_some_and(|edge| middle[edge] != node) {
                    return bad(
                        node,
                        "a face and a cell have different midside nodes on this edge",
                    );
                }
            }
            faces.push(([x, y, z], *tag));
        }
        let middles = middle
            .iter()
            .map(|&node| self.points[node as usize])
            .collect();
        let linear = LinearTets {
            points,
            tets,
            faces,
            tags: self.tags,
            regions: self.regions,
        };
        Ok((linear, middles))
    }
}
