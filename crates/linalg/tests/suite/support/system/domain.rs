//! Assembly of a bordered Stokes system from straight ten-node tetrahedra.

use std::collections::BTreeMap;

use linalg::{Bordered, Csr, Csr3, Prolongation, SaddleSystem};
use nalgebra::{DMatrix, Vector3};
use sprs::TriMatI;

use super::Stokes;
use super::elements::{EDGES, divergence, mass, stiffness};

/// The part of the domain on which a point lies.
#[derive(Clone, Copy, PartialEq)]
pub enum Owner {
    Wall,
    Body(usize),
    Fluid,
}

/// A mesh with rigid bodies; points that no tetrahedron uses are ignored.
pub struct Domain {
    pub points: Vec<Vector3<f64>>,
    /// Four vertices, then the midside nodes of [`EDGES`].
    pub tets: Vec<[usize; 10]>,
    pub owners: Vec<Owner>,
    pub centres: Vec<Vector3<f64>>,
    pub volumes: Vec<f64>,
}

/// Location of a point's dofs.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    Absent,
    Fixed,
    Body(usize),
    Free(usize),
}

impl Domain {
    /// Assembles the system, with the rigid motions of the bodies as border.
    ///
    /// Three translations and three rotations per body.
    pub fn assemble(&self, viscosity: f64) -> Stokes {
        let (tets, points) = (&self.tets, &self.points);
        // vertices first, then midside nodes, as in the meshes of this workspace
        let mut places = vec![Place::Absent; points.len()];
        let (mut free, mut vertices) = (0, 0);
        let mut pressures = BTreeMap::new();
        for range in [0..4, 4..10] {
            for &node in tets.iter().flat_map(|t| &t[range.clone()]) {
                if range.start == 0 {
                    let next = pressures.len();
                    pressures.entry(node).or_insert(next);
                }
                if places[node] == Place::Absent {
                    places[node] = match self.owners[node] {
                        Owner::Wall => Place::Fixed,
                        Owner::Body(body) => Place::Body(body),
                        Owner::Fluid => {
                            free += 1;
                            Place::Free(free - 1)
                        }
                    };
                }
            }
            if range.start == 0 {
                vertices = free;
            }
        }

        let m = 6 * self.centres.len();
        // rows of the rigid motion u = U + w × r at a body node: (component, dof, value)
        let rigid = |b: usize, node: usize| {
            let r = points[node] - self.centres[b];
            let mut entries: Vec<(usize, usize, f64)> = Vec::new();
            for d in 0..3 {
                entries.push((d, 6 * b + d, 1.0));
                let turn = Vector3::ith(d, 1.0).cross(&r);
                entries.extend((0..3).map(|e| (e, 6 * b + 3 + d, turn[e])));
            }
            entries.retain(|e| e.2 != 0.0);
            entries
        };

        let np = pressures.len();
        let mut k = TriMatI::<f64, u32>::new((free, free));
        let mut c = TriMatI::<f64, u32>::new((3 * free, m));
        let mut corner = DMatrix::zeros(m, m);
        let mut b: BTreeMap<(usize, usize), [f64; 3]> = BTreeMap::new();
        let mut e = TriMatI::<f64, u32>::new((np, m));
        let mut q = TriMatI::<f64, u32>::new((np, np));
        for tet in tets {
            let x = [0, 1, 2, 3].map(|v| points[tet[v]]);
            let (ke, be, me) = (stiffness(&x), divergence(&x), mass(&x));
            for (i, &ni) in tet.iter().enumerate() {
                for (j, &nj) in tet.iter().enumerate() {
                    let v = viscosity * ke[i][j];
                    match (places[ni], places[nj]) {
                        (Place::Free(i), Place::Free(j)) => k.add_triplet(i, j, v),
                        (Place::Free(i), Place::Body(body)) => {
                            for (d, col, w) in rigid(body, nj) {
                                c.add_triplet(3 * i + d, col, v * w);
                            }
                        }
                        (Place::Body(bi), Place::Body(bj)) => {
                            for (d, row, wi) in rigid(bi, ni) {
                                for (f, col, wj) in rigid(bj, nj) {
                                    if d == f {
                                        corner[(row, col)] += wi * v * wj;
                                    }
                                }
                            }
                        }
                        _ => {}
                    }
                }
                for row in 0..4 {
                    let p = pressures[&tet[row]];
                    match places[ni] {
                        Place::Free(j) => {
                            let entry = b.entry((p, j)).or_default();
                            (0..3).for_each(|d| entry[d] += be[row][i][d]);
                        }
                        Place::Body(body) => {
                            for (d, col, w) in rigid(body, ni) {
                                e.add_triplet(p, col, be[row][i][d] * w);
                            }
                        }
                        _ => {}
                    }
                }
            }
            for i in 0..4 {
                for j in 0..4 {
                    let value = me[i][j] / viscosity;
                    q.add_triplet(pressures[&tet[i]], pressures[&tet[j]], value);
                }
            }
        }
        for (index, volume) in self.volumes.iter().enumerate() {
            // ∇u:∇v becomes 2 D:D by the term 2 |B| w·w
            for d in 3..6 {
                corner[(6 * index + d, 6 * index + d)] += 2.0 * viscosity * volume;
            }
        }

        // P1 -> P2: midside nodes take half of each end; vertices come first
        let mut edges: BTreeMap<usize, [usize; 2]> = BTreeMap::new();
        for tet in tets {
            for (e, [a, b]) in EDGES.iter().enumerate() {
                edges.insert(tet[4 + e], [tet[*a], tet[*b]]);
            }
        }
        let mut p = TriMatI::<f64, u32>::new((free, vertices));
        let mut motion = TriMatI::<f64, u32>::new((3 * free, m));
        for (node, place) in places.iter().enumerate() {
            let Place::Free(i) = *place else { continue };
            let Some(ends) = edges.get(&node) else {
                p.add_triplet(i, i, 1.0);
                continue;
            };
            for &end in ends {
                match places[end] {
                    Place::Free(j) => p.add_triplet(i, j, 0.5),
                    Place::Body(body) => {
                        for (d, col, w) in rigid(body, end) {
                            motion.add_triplet(3 * i + d, col, 0.5 * w);
                        }
                    }
                    _ => {}
                }
            }
        }

        let k: Csr = k.to_csr();
        let p: Csr = p.to_csr();
        let a = Bordered::new(k, c.to_csr(), None, corner).expect("a sound velocity block");
        let b = csr3(np, free, &b);
        let system = SaddleSystem::new(a, b, e.to_csr(), None, q.to_csr()).expect("a sound system");
        let prolongation = Prolongation::new(p, motion.to_csr()).expect("a sound prolongation");
        Stokes {
            system,
            prolongation,
        }
    }
}

/// Rows of 3-vectors from a sorted map.
fn csr3(rows: usize, cols: usize, entries: &BTreeMap<(usize, usize), [f64; 3]>) -> Csr3 {
    let mut indptr = vec![0; rows + 1];
    for (row, _) in entries.keys() {
        indptr[row + 1] += 1;
    }
    for i in 0..rows {
        indptr[i + 1] += indptr[i];
    }
    let columns = entries.keys().map(|&(_, col)| col as u32).collect();
    Csr3::new(
        (rows, cols),
        indptr,
        columns,
        entries.values().copied().collect(),
    )
}
