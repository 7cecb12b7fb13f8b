//! Edges and faces of a set of tets, and which tets share them.

use crate::linear_tets::TET_FACES;
use crate::{Grouped, MeshError, TET_EDGES, Vec3};

/// All edges of a mesh, numbered by lower, then by upper vertex.
pub(crate) struct EdgeIndex {
    /// The edges with lower vertex `v` are `start[v]..start[v + 1]`.
    start: Vec<usize>,
    /// Upper vertex of each edge, ascending among the edges of one lower vertex.
    upper: Vec<u32>,
}

impl EdgeIndex {
    /// Numbers the edges of `tets`. Cost: O(n log valence).
    pub(crate) fn new(n_vertices: usize, tets: &[[u32; 4]]) -> Self {
        let pairs = || {
            tets.iter()
                .flat_map(|tet| TET_EDGES.map(|[a, b]| (tet[a].min(tet[b]), tet[a].max(tet[b]))))
        };
        let mut grouped = Grouped::new(n_vertices, pairs);
        let (mut start, mut upper) = (vec![0], Vec::new());
        for v in 0..n_vertices as u32 {
            let above = grouped.of_mut(v);
            above.sort_unstable();
            upper.extend(above.chunk_by(|a, b| a == b).map(|equal| equal[0]));
            start.push(upper.len());
        }
        Self { start, upper }
    }

    /// Number of edges.
    pub(crate) fn len(&self) -> usize {
        self.upper.len()
    }

    /// Number of the edge between `a` and `b`, in either order, if a tet has it.
    pub(crate) fn find(&self, a: u32, b: u32) -> Option<usize> {
        let low = a.min(b) as usize;
        let range = self.start[low]..self.start[low + 1];
        let at = self.upper[range.clone()].binary_search(&a.max(b)).ok()?;
        Some(range.start + at)
    }

    /// The edges in the order of their numbers, each with its lower vertex first.
    pub(crate) fn iter(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        (0..self.start.len() - 1).flat_map(|v| {
            self.upper[self.start[v]..self.start[v + 1]]
                .iter()
                .map(move |&w| [v as u32, w])
        })
    }
}

/// A face that belongs to exactly one tet.
#[derive(Clone, Copy)]
pub(crate) struct BoundaryFace {
    /// Vertices; the normal points out of the fluid.
    pub(crate) vertices: [u32; 3],
    pub(crate) cell: u32,
    pub(crate) tag: u16,
}

/// The two higher vertices of a face, the index of the tet or tagged face, and the local face of
/// the tet or [`TAGGED_FACE`].
type FaceEntry = ([u32; 2], u32, u8);

/// Marks a [`FaceEntry`] of a tagged face; smaller numbers are local faces of a tet.
const TAGGED_FACE: u8 = 4;

/// Matches the boundary faces of `tets` (positively oriented) with the tagged `faces`, one to one.
///
/// # Errors
/// [`MeshError::NotOnBoundary`] for a tagged face that is not a boundary face,
/// [`MeshError::UntaggedFace`], [`MeshError::FaceTaggedTwice`], and
/// [`MeshError::NonManifoldFace`] where three or more tets share a face.
pub(crate) fn match_boundary(
    points: &[Vec3],
    tets: &[[u32; 4]],
    faces: &[([u32; 3], u16)],
    tags: &[String],
) -> Result<Vec<BoundaryFace>, MeshError> {
    let key = |[a, b, c]: [u32; 3], owner: u32, side: u8| -> (u32, FaceEntry) {
        let mut v = [a, b, c];
        v.sort_unstable();
        (v[0], ([v[1], v[2]], owner, side))
    };
    let entries = || {
        let of_tets = tets.iter().enumerate().flat_map(move |(cell, tet)| {
            [0, 1, 2, 3].map(|f| key(TET_FACES[f].map(|i| tet[i]), cell as u32, f as u8))
        });
        let tagged = faces.iter().enumerate();
        of_tets.chain(tagged.map(move |(i, (face, _))| key(*face, i as u32, TAGGED_FACE)))
    };
    let mut entries = Grouped::new(points.len(), entries);
    let mut boundary = Vec::with_capacity(faces.len());
    for low in 0..points.len() as u32 {
        let around = entries.of_mut(low);
        // Within a group of equal faces the tets come before the tagged faces.
        around.sort_unstable_by_key(|&(upper, owner, side)| (upper, side == TAGGED_FACE, owner));
        for group in around.chunk_by(|a, b| a.0 == b.0) {
            let n_tets = group.iter().filter(|entry| entry.2 != TAGGED_FACE).count();
            let (of_tets, tagged) = group.split_at(n_tets);
            let [b, c] = group[0].0;
            let corners = [low, b, c].map(|v| points[v as usize]);
            let at = (corners[0] + corners[1] + corners[2]) / 3.0;
            let tag_name = |entry: &FaceEntry| tags[faces[entry.1 as usize].1 as usize].clone();
            match (of_tets, tagged) {
                ([_, _, _, ..], _) => {
                    return Err(MeshError::NonManifoldFace {
                        cells: n_tets,
                        at: at.into(),
                    });
                }
                ([_, _], []) => {}
                ([_], []) => return Err(MeshError::UntaggedFace { at: at.into() }),
                ([(_, cell, side)], [face]) => boundary.push(BoundaryFace {
                    vertices: TET_FACES[*side as usize].map(|i| tets[*cell as usize][i]),
                    cell: *cell,
                    tag: faces[face.1 as usize].1,
                }),
                ([_], [first, second, ..]) => {
                    return Err(MeshError::FaceTaggedTwice {
                        first: tag_name(first),
                        second: tag_name(second),
                        at: at.into(),
                    });
                }
                (_, [first, ..]) => {
                    return Err(MeshError::NotOnBoundary {
                        tag: tag_name(first),
                        cells: n_tets,
                        at: at.into(),
                    });
                }
                ([], []) => {}
            }
        }
    }
    Ok(boundary)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_numbered_by_lower_then_upper_vertex() {
        let edges = EdgeIndex::new(5, &[[3, 1, 0, 2], [4, 1, 3, 2]]);
        let all: Vec<_> = edges.iter().collect();
        let expected = [
            [0, 1],
            [0, 2],
            [0, 3],
            [1, 2],
            [1, 3],
            [1, 4],
            [2, 3],
            [2, 4],
            [3, 4],
        ];
        assert_eq!(all, expected);
        assert_eq!(edges.find(3, 1), Some(4));
        assert_eq!(edges.find(0, 4), None);
        assert_eq!(edges.len(), 9);
    }
}
