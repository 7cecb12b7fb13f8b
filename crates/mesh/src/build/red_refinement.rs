//! Uniform refinement of curved meshes.

use std::collections::HashMap;

use super::boundary_nodes::project;
use crate::point_location::quadratic_functions;
use crate::{LinearTets, MeshError, NamedSurface, Regions, TET_EDGES, TetMesh, Vec3};

/// The eight children of a tet, by local nodes of the parent (Bey 1995).
///
/// Four corners, then four tets around the diagonal from the middle of the edge 02 (node 6) to that
/// of 13 (node 8). The rule depends on the vertex order only through the pair of opposite edges 02
/// and 13. In each child the vertices 0 and 2 are exchanged if needed, which keeps its pair: all
/// children are positively oriented.
const CHILDREN: [[usize; 4]; 8] = [
    [0, 4, 6, 7],
    [4, 1, 5, 8],
    [6, 5, 2, 9],
    [7, 8, 9, 3],
    [4, 6, 7, 8],
    [5, 6, 4, 8],
    [6, 7, 8, 9],
    [8, 5, 6, 9],
];

/// The four children of a facet, by its local nodes, with its orientation.
const CHILDREN_OF_FACET: [[usize; 3]; 4] = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];

impl TetMesh {
    /// The mesh with each cell divided into eight (red refinement, Bey 1995).
    ///
    /// The nodes of this mesh become vertices; new midside nodes lie on the quadratic cells.
    /// Without `surfaces` the fluid therefore stays the same, curved boundary included. With
    /// `surfaces` the nodes on the named boundary parts move to the closest points, as in
    /// [`TetMesh::curved`], and the boundary converges to the true one: the volume of a ball with
    /// the fourth power of the edge length. Tags and regions are kept.
    ///
    /// The octahedron inside a cell is divided along the diagonal between the middles of its edges
    /// 02 and 13, and the vertices of the children are ordered such that repeated refinement of a
    /// straight cell gives at most three different shapes: the quality is bounded. Cost: eight
    /// times that of building this mesh.
    ///
    /// ```
    /// use mesh::{LinearTets, TetMesh};
    /// let mesh = TetMesh::straight(LinearTets::cube(1))?;
    /// let fine = mesh.refined(&[])?.refined(&[])?;
    /// assert_eq!((fine.n_cells(), fine.facets().len()), (64 * 6, 16 * 12));
    /// assert!((fine.volume() - 1.0).abs() < 1e-14);
    /// # Ok::<(), mesh::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// [`MeshError::UnknownTag`], [`MeshError::OffSurface`] and [`MeshError::InvertedCell`] as
    /// [`TetMesh::curved`]; [`MeshError::TooLarge`].
    pub fn refined(&self, surfaces: &[NamedSurface]) -> Result<Self, MeshError> {
        let count = CHILDREN.len() * self.n_cells();
        if count > i32::MAX as usize {
            let what = "cells";
            return Err(MeshError::TooLarge { what, count });
        }
        let mut points = self.points.clone();
        for nodes in [0..3, 3..6] {
            project(&mut points, self.facets(), nodes, self.tags(), surfaces)?;
        }
        let mut middles = HashMap::new();
        for (cell, nodes) in self.cells().iter().enumerate() {
            // The edges of straight cells have their midside nodes at midpoints.
            if surfaces.is_empty() && self.is_affine(cell) {
                continue;
            }
            let x = nodes.map(|node| points[node as usize]);
            for [a, b] in CHILDREN
                .iter()
                .flat_map(|child| TET_EDGES.map(|e| e.map(|i| child[i])))
            {
                let (low, high) = (nodes[a].min(nodes[b]), nodes[a].max(nodes[b]));
                middles
                    .entry([low, high])
                    .or_insert_with(|| quadratic_point(&x, 0.5 * (weights(a) + weights(b))));
            }
        }
        let children = |cell: &[u32; 10]| CHILDREN.map(|child| child.map(|node| cell[node]));
        let faces = self.facets().iter().flat_map(|facet| {
            CHILDREN_OF_FACET.map(|child| (child.map(|node| facet.nodes[node]), facet.tag))
        });
        let regions = Regions {
            names: self.regions().names.clone(),
            of_cells: (self.regions().of_cells.iter())
                .flat_map(|&region| [region; CHILDREN.len()])
                .collect(),
        };
        let linear = LinearTets {
            points,
            tets: self.cells().iter().flat_map(children).collect(),
            faces: faces.collect(),
            tags: self.tags().to_vec(),
            regions,
        };
        Self::with_middles(linear, &middles, surfaces)
    }
}

/// Barycentric coordinates of a node of the reference cell.
fn weights(node: usize) -> nalgebra::Vector4<f64> {
    let mut weights = nalgebra::Vector4::zeros();
    match node {
        0..4 => weights[node] = 1.0,
        _ => TET_EDGES[node - 4]
            .iter()
            .for_each(|&end| weights[end] = 0.5),
    }
    weights
}

/// The point of a quadratic cell with these barycentric coordinates.
fn quadratic_point(x: &[Vec3; 10], l: nalgebra::Vector4<f64>) -> Vec3 {
    let shapes = quadratic_functions(&l.into());
    shapes.into_iter().zip(x).map(|(shape, x)| shape * x).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Surface;

    /// One tet whose faces have four tags.
    fn tet(points: [Vec3; 4]) -> TetMesh {
        let faces = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
        let numbered = faces.iter().zip(0..);
        TetMesh::straight(LinearTets {
            points: points.to_vec(),
            tets: vec![[0, 1, 2, 3]],
            faces: numbered.map(|(face, tag)| (*face, tag)).collect(),
            tags: ["a", "b", "c", "d"].map(String::from).to_vec(),
            regions: Regions {
                names: vec!["inside".into()],
                of_cells: vec![0],
            },
        })
        .unwrap()
    }

    /// Edge lengths of a cell in ascending order, relative to the edges of the coarsest mesh.
    fn shape(mesh: &TetMesh, cell: usize, level: i32) -> [i64; 6] {
        let x = mesh.cell_vertices(cell);
        let mut lengths = TET_EDGES.map(|[i, j]| (x[i] - x[j]).norm() * 2f64.powi(level));
        lengths.sort_unstable_by(f64::total_cmp);
        lengths.map(|length| (length * 1e9).round() as i64)
    }

    #[test]
    fn repeated_refinement_gives_three_shapes_at_most() {
        for points in [
            [
                [0.0, 0.0, 0.0],
                [1.1, 0.1, 0.0],
                [0.3, 0.9, 0.2],
                [0.2, 0.1, 0.7],
            ],
            [
                [0.0, 0.0, 0.0],
                [2.0, 0.3, 0.1],
                [1.8, 0.9, -0.2],
                [0.1, 0.5, 0.4],
            ],
        ] {
            let mut mesh = tet(points.map(Vec3::from));
            let mut shapes = std::collections::BTreeSet::from([shape(&mesh, 0, 0)]);
            let (volume, mut last) = (mesh.volume(), f64::INFINITY);
            for level in 1..=4 {
                mesh = mesh.refined(&[]).unwrap();
                let cells = 0..mesh.n_cells();
                shapes.extend(cells.map(|cell| shape(&mesh, cell, level)));
                assert!(shapes.len() <= 3, "level {level}: {} shapes", shapes.len());
                assert!((mesh.volume() / volume - 1.0).abs() < 1e-13);
                let quality = mesh.quality().min_quality;
                // All three shapes occur from the second level on.
                assert!(level < 3 || (quality / last - 1.0).abs() < 1e-9);
                last = quality;
                for tag in 0..4 {
                    let facets = mesh.facets().iter().filter(|facet| facet.tag == tag);
                    assert_eq!(facets.count(), 4_usize.pow(level as u32));
                }
                assert_eq!(mesh.regions().of_cells, vec![0; mesh.n_cells()]);
            }
            assert_eq!(shapes.len(), 3);
        }
    }

    struct UnitSphere;

    impl Surface for UnitSphere {
        fn signed_distance(&self, point: Vec3) -> f64 {
            point.norm() - 1.0
        }
        fn closest_point(&self, point: Vec3) -> Vec3 {
            point.normalize()
        }
        fn bounding_ball(&self) -> (Vec3, f64) {
            (Vec3::zeros(), 1.0)
        }
        fn volume(&self) -> f64 {
            4.0 / 3.0 * std::f64::consts::PI
        }
        fn is_convex(&self) -> bool {
            true
        }
        fn reach(&self) -> f64 {
            1.0
        }
    }

    /// A ball of eight tets around its centre.
    fn ball() -> TetMesh {
        let (x, y, z) = (Vec3::x(), Vec3::y(), Vec3::z());
        let mut tets = LinearTets {
            points: vec![Vec3::zeros(), x, -x, y, -y, z, -z],
            tags: vec!["wall".into()],
            ..LinearTets::default()
        };
        for a in [1, 2] {
            for b in [3, 4] {
                for c in [5, 6] {
                    tets.tets.push([0, a, b, c]);
                    tets.faces.push(([a, b, c], 0));
                }
            }
        }
        TetMesh::curved(tets, &[("wall", &UnitSphere)]).unwrap()
    }

    /// Without the surface the curved cells are divided exactly; with it the volume of a ball has
    /// the order 4, of quadratic edges on a surface whose nodes are exact.
    #[test]
    fn curved_boundaries_are_kept_or_followed() {
        let coarse = ball();
        let same = coarse.refined(&[]).unwrap().refined(&[]).unwrap();
        assert!((same.volume() / coarse.volume() - 1.0).abs() < 1e-13);
        let mut mesh = coarse;
        let mut errors = Vec::new();
        for _ in 0..3 {
            mesh = mesh.refined(&[("wall", &UnitSphere)]).unwrap();
            errors.push((mesh.volume() / UnitSphere.volume() - 1.0).abs());
            for node in mesh.nodes_on(0) {
                assert!((mesh.points()[node as usize].norm() - 1.0).abs() < 1e-15);
            }
            // Measured: 0.37 at each level.
            assert!(mesh.quality().min_jacobian > 0.2, "{:?}", mesh.quality());
        }
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((3.6..4.4).contains(&order), "{errors:?}");
        }
    }

    #[test]
    fn straight_meshes_follow_a_surface_that_is_given() {
        let points = ball().points()[..7].to_vec();
        let straight = TetMesh::straight(LinearTets {
            points,
            tets: ball()
                .cells()
                .iter()
                .map(|c| [c[0], c[1], c[2], c[3]])
                .collect(),
            faces: (ball().facets().iter())
                .map(|f| ([f.nodes[0], f.nodes[1], f.nodes[2]], 0))
                .collect(),
            tags: vec!["wall".into()],
            regions: Regions::default(),
        });
        let fine = straight.unwrap().refined(&[("wall", &UnitSphere)]).unwrap();
        let same = ball().refined(&[("wall", &UnitSphere)]).unwrap();
        assert!((fine.volume() - same.volume()).abs() < 1e-13);
        let unknown = ball().refined(&[("nothing", &UnitSphere)]);
        assert!(matches!(unknown, Err(MeshError::UnknownTag { .. })));
    }
}
