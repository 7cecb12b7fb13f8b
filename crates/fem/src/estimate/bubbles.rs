//! Cubic bubble functions of a mesh: numbering, and gradients on the reference tetrahedron.

use std::collections::HashMap;
use std::sync::LazyLock;

use mesh::{Grouped, TET_EDGES, TetMesh, Vec3};
use nalgebra::Matrix3;

use crate::FemError;
use crate::quadrature::{CellPoint, degree_5};

/// Number of bubbles of a cell.
///
/// One per edge, in the order of [`TET_EDGES`], then one per face, opposite vertex 0 to 3.
pub(super) const BUBBLES_PER_CELL: usize = 10;

/// Largest number of cells whose four faces each can be numbered in 32 bits.
const MAX_CELLS: usize = 1 << 29;

/// Cubic bubbles: `l_a l_b (l_a - l_b)` on each edge and `l_a l_b l_c` on each face.
///
/// They extend the quadratic elements to cubic ones. The bubble of an edge is odd and oriented from
/// the vertex with the lower number to the other, so that all cells around the edge agree on its
/// sign. Edges are numbered like the midside nodes of the mesh, faces after them.
pub(super) struct Bubbles {
    /// Numbers of the face bubbles of each cell.
    faces: Vec<[u32; 4]>,
    /// Constrained components of each bubble, one bit per component.
    ///
    /// All components are constrained on the boundary, where the velocity is prescribed, and the
    /// normal one on symmetry planes.
    constrained: Vec<u8>,
    n_vertices: u32,
    n_edges: usize,
}

impl Bubbles {
    /// Numbers the bubbles of `mesh`. Cost: one sort of its faces.
    pub fn new(mesh: &TetMesh) -> Result<Self, FemError> {
        let cells = mesh.cells();
        if cells.len() > MAX_CELLS {
            return Err(FemError::TooLarge {
                what: "the number of cells",
                found: cells.len(),
                limit: MAX_CELLS,
            });
        }
        // Faces are sorted by their smallest vertex, then by the other two.
        let sides = || {
            let all = cells.iter().enumerate();
            all.flat_map(|(cell, nodes)| {
                [0, 1, 2, 3].map(|opposite| {
                    let mut key = corners(opposite).map(|v| nodes[v]);
                    key.sort_unstable();
                    let number = 4 * cell as u32 + opposite as u32;
                    (key[0], ([key[1], key[2]], number))
                })
            })
        };
        let mut sides = Grouped::new(mesh.n_vertices(), sides);

        let n_edges = mesh.n_points() - mesh.n_vertices();
        let on_symmetry_planes = on_symmetry_planes(mesh);
        let mut faces = vec![[0; 4]; cells.len()];
        let mut constrained = vec![0; n_edges];
        for vertex in 0..mesh.n_vertices() as u32 {
            let around = sides.of_mut(vertex);
            around.sort_unstable();
            for shared in around.chunk_by(|a, b| a.0 == b.0) {
                let number = constrained.len() as u32;
                let [second, third] = shared[0].0;
                constrained.push(match shared.len() {
                    1 => on_symmetry_planes
                        .get(&[vertex, second, third])
                        .copied()
                        .unwrap_or(ALL_COMPONENTS),
                    _ => 0,
                });
                for &(_, side) in shared {
                    faces[side as usize / 4][side as usize % 4] = number;
                }
            }
        }
        let n_vertices = mesh.n_vertices();
        for facet in mesh.facets() {
            let components = normal_component(mesh, facet.tag).unwrap_or(ALL_COMPONENTS);
            for &node in &facet.nodes[3..] {
                constrained[node as usize - n_vertices] |= components;
            }
        }
        Ok(Self {
            faces,
            constrained,
            n_vertices: n_vertices as u32,
            n_edges,
        })
    }

    /// Number of bubbles, including those on the boundary.
    pub fn len(&self) -> usize {
        self.constrained.len()
    }

    /// Number of cells.
    pub fn n_cells(&self) -> usize {
        self.faces.len()
    }

    /// Number of edges.
    pub fn n_edges(&self) -> usize {
        self.n_edges
    }

    /// Numbers of the face bubbles of a cell.
    pub fn faces(&self, cell: usize) -> [u32; 4] {
        self.faces[cell]
    }

    /// Whether `mesh` has as many cells, nodes and vertices as the mesh of these bubbles.
    pub fn fits(&self, mesh: &TetMesh) -> bool {
        mesh.n_cells() == self.n_cells()
            && mesh.n_vertices() == self.n_vertices as usize
            && mesh.n_points() == self.n_vertices as usize + self.n_edges
    }

    /// `value` with zeros in the constrained components of a bubble.
    pub fn without_constrained(&self, bubble: usize, mut value: Vec3) -> Vec3 {
        for axis in (0..3).filter(|axis| self.constrained[bubble] >> axis & 1 == 1) {
            value[axis] = 0.0;
        }
        value
    }

    /// Numbers of the bubbles of a cell with the given nodes.
    pub fn of_cell(&self, cell: usize, nodes: &[u32; 10]) -> [usize; BUBBLES_PER_CELL] {
        std::array::from_fn(|k| {
            let number = match k {
                0..6 => nodes[4 + k] - self.n_vertices,
                _ => self.faces[cell][k - 6],
            };
            number as usize
        })
    }
}

/// All components.
const ALL_COMPONENTS: u8 = 0b111;

/// Bit of the component normal to a symmetry plane; `None` for other parts of the boundary.
fn normal_component(mesh: &TetMesh, tag: u16) -> Option<u8> {
    mesh.symmetry_plane_axis(tag).map(|axis| 1 << axis)
}

/// Normal components of the faces on symmetry planes, by their sorted vertices.
fn on_symmetry_planes(mesh: &TetMesh) -> HashMap<[u32; 3], u8> {
    let face = |facet: &mesh::Facet| {
        let [a, b, c, ..] = facet.nodes;
        let mut key = [a, b, c];
        key.sort_unstable();
        Some((key, normal_component(mesh, facet.tag)?))
    };
    mesh.facets().iter().filter_map(face).collect()
}

/// Signs of the bubbles of a cell: `-1` for an edge whose first local vertex has the higher number.
pub(super) fn signs(nodes: &[u32; 10]) -> [f64; BUBBLES_PER_CELL] {
    std::array::from_fn(|k| match TET_EDGES.get(k) {
        Some(&[a, b]) if nodes[a] > nodes[b] => -1.0,
        _ => 1.0,
    })
}

/// Vertices of the face opposite a vertex.
fn corners(opposite: usize) -> [usize; 3] {
    std::array::from_fn(|k| (opposite + 1 + k) % 4)
}

/// Quadrature point with the gradients of the bubbles in reference coordinates.
pub(super) struct BubblePoint {
    pub at: &'static CellPoint,
    pub gradients: [Vec3; BUBBLES_PER_CELL],
}

/// Number of points of [`rule`].
pub(super) const RULE_POINTS: usize = 14;

/// Rule of 14 points and degree 5.
///
/// Exact for the residuals (degree 3) and energies (degree 4) of the bubbles of affine cells.
pub(super) fn rule() -> &'static [BubblePoint] {
    static RULE: LazyLock<Vec<BubblePoint>> = LazyLock::new(|| {
        degree_5()
            .iter()
            .map(|at| BubblePoint {
                at,
                gradients: gradients(at.barycentric),
            })
            .collect()
    });
    &RULE
}

/// Integrals over the reference tetrahedron for affine cells.
pub(super) struct Integrals {
    /// `∫ l_m ∇φ_k`, with the gradient in reference coordinates.
    pub moments: [[Vec3; 4]; BUBBLES_PER_CELL],
    /// `∫ ∇φ_k ∇φ_k^T`, with the gradients in reference coordinates.
    pub squares: [Matrix3<f64>; BUBBLES_PER_CELL],
}

/// Integrals of the bubbles, computed once.
pub(super) fn integrals() -> &'static Integrals {
    static INTEGRALS: LazyLock<Integrals> = LazyLock::new(|| {
        let mut sums = Integrals {
            moments: [[Vec3::zeros(); 4]; BUBBLES_PER_CELL],
            squares: [Matrix3::zeros(); BUBBLES_PER_CELL],
        };
        for BubblePoint { at, gradients } in rule() {
            for (k, g) in gradients.iter().enumerate() {
                sums.squares[k] += at.weight * g * g.transpose();
                for m in 0..4 {
                    sums.moments[k][m] += at.weight * at.barycentric[m] * g;
                }
            }
        }
        sums
    });
    &INTEGRALS
}

/// Gradients of the bubbles in reference coordinates.
fn gradients(l: [f64; 4]) -> [Vec3; BUBBLES_PER_CELL] {
    std::array::from_fn(|k| {
        let mut d = [0.0; 4];
        if let Some(&[a, b]) = TET_EDGES.get(k) {
            // l_a^2 l_b - l_a l_b^2
            d[a] = 2.0 * l[a] * l[b] - l[b] * l[b];
            d[b] = l[a] * l[a] - 2.0 * l[a] * l[b];
        } else {
            let [a, b, c] = corners(k - TET_EDGES.len());
            (d[a], d[b], d[c]) = (l[b] * l[c], l[a] * l[c], l[a] * l[b]);
        }
        // The reference coordinates are ξ_k = l_(k+1), and l_0 = 1 - sum_k ξ_k.
        Vec3::new(d[1] - d[0], d[2] - d[0], d[3] - d[0])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::LinearTets;

    #[test]
    fn gradients_are_the_derivatives() {
        let value = |l: [f64; 4], k: usize| match TET_EDGES.get(k) {
            Some(&[a, b]) => l[a] * l[b] * (l[a] - l[b]),
            None => corners(k - 6).iter().map(|&v| l[v]).product(),
        };
        let l = [0.15, 0.37, 0.28, 0.2];
        // The error of central differences of cubics is proportional to the square of the step.
        let step = 1e-4;
        let gradients = gradients(l);
        for k in 0..BUBBLES_PER_CELL {
            for axis in 0..3 {
                let at = |sign: f64| {
                    let mut m = l;
                    m[axis + 1] += sign * step;
                    m[0] -= sign * step;
                    value(m, k)
                };
                let difference = (at(1.0) - at(-1.0)) / (2.0 * step);
                assert!((difference - gradients[k][axis]).abs() < 1e-7);
            }
        }
    }

    #[test]
    fn neighbouring_cells_share_the_bubbles_of_edges_and_faces() {
        let mesh = TetMesh::straight(LinearTets::cube(2)).unwrap();
        let bubbles = Bubbles::new(&mesh).unwrap();
        let (cells, facets) = (mesh.cells().len(), mesh.facets().len());
        let edges = mesh.n_points() - mesh.n_vertices();
        assert_eq!(bubbles.len(), edges + (4 * cells + facets) / 2);
        let mut seen = vec![0; bubbles.len()];
        for (cell, nodes) in mesh.cells().iter().enumerate() {
            for bubble in bubbles.of_cell(cell, nodes) {
                seen[bubble] += 1;
            }
        }
        for bubble in edges..bubbles.len() {
            assert_eq!(
                seen[bubble],
                if bubbles.constrained[bubble] == ALL_COMPONENTS {
                    1
                } else {
                    2
                }
            );
        }
        // A closed surface of triangles has three edges per two triangles.
        let boundary_edges = (0..edges)
            .filter(|&e| bubbles.constrained[e] == ALL_COMPONENTS)
            .count();
        assert_eq!(2 * boundary_edges, 3 * facets);
    }
}
