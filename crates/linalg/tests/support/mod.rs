//! Taylor-Hood elements on a Kuhn-split cube with cubic rigid bodies cut out: a Stokes system without a mesh crate.

mod elements;

use linalg::{Bordered, Csr, Csr3, SaddleSystem, Transfer};
use nalgebra::{DMatrix, Vector3};
use sprs::TriMatI;
use std::collections::BTreeMap;

use elements::{EDGES, divergence, kuhn_tets, mass, stiffness};

/// A body: the cells `low .. high` of the lattice in each direction.
#[derive(Clone, Copy)]
pub struct Body {
    pub low: [usize; 3],
    pub high: [usize; 3],
}

/// A body of `size` cells a side at `low`.
pub fn cube(low: [usize; 3], size: usize) -> Body {
    Body {
        low,
        high: low.map(|l| l + size),
    }
}

/// Two bodies beside each other, an eighth of the cube wide, in a cube of `8 k` cells a side.
pub fn two_bodies(k: usize) -> Stokes {
    let bodies = [[2, 3, 3], [5, 4, 4]].map(|low| cube(low.map(|l| l * k), k));
    Stokes::new(8 * k, &bodies, 8.0)
}

/// One body, a quarter of the cube wide, in a cube of `4 k` cells a side.
pub fn one_body(k: usize) -> Stokes {
    Stokes::new(4 * k, &[cube([k + k / 2; 3], k)], 4.0)
}

/// The assembled system and what multigrid needs of its mesh.
pub struct Stokes {
    pub system: SaddleSystem,
    pub transfer: Transfer,
    /// P1 stiffness matrix of the free vertices.
    pub coarse_stiffness: Csr,
}

/// Where a lattice point belongs.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    Absent,
    Fixed,
    Body(usize),
    Free(usize),
}

impl Stokes {
    /// `cells` a side of a cube of `length`, viscosity 1, no slip outside.
    pub fn new(cells: usize, bodies: &[Body], length: f64) -> Self {
        Self::with_viscosity(cells, bodies, length, 1.0)
    }

    pub fn with_viscosity(cells: usize, bodies: &[Body], length: f64, viscosity: f64) -> Self {
        let h = length / cells as f64;
        let side = 2 * cells + 1;
        let index = |p: [usize; 3]| (p[0] * side + p[1]) * side + p[2];
        let point = |i: usize| [i / (side * side), i / side % side, i % side];
        let position = |i: usize| Vector3::from(point(i).map(|c| 0.5 * h * c as f64));

        let mut tets: Vec<[usize; 10]> = Vec::new();
        for cell in 0..cells.pow(3) {
            let c = [cell / (cells * cells), cell / cells % cells, cell % cells];
            let inside = |b: &Body| (0..3).all(|d| (b.low[d]..b.high[d]).contains(&c[d]));
            if bodies.iter().any(inside) {
                continue;
            }
            tets.extend(kuhn_tets(c).map(|vertices| {
                let mut nodes = [0; 10];
                for (k, v) in vertices.iter().enumerate() {
                    nodes[k] = index(v.map(|x| 2 * x));
                }
                for (e, [a, b]) in EDGES.iter().enumerate() {
                    nodes[4 + e] = index([0, 1, 2].map(|d| vertices[*a][d] + vertices[*b][d]));
                }
                nodes
            }));
        }

        // vertices first, then midside nodes, as in the meshes of this workspace
        let mut places = vec![Place::Absent; side.pow(3)];
        let (mut free, mut pressures) = (0, BTreeMap::new());
        for range in [0..4, 4..10] {
            for &node in tets.iter().flat_map(|t| &t[range.clone()]) {
                let p = point(node);
                if range.start == 0 {
                    let next = pressures.len();
                    pressures.entry(node).or_insert(next);
                }
                if places[node] != Place::Absent {
                    continue;
                }
                let touches =
                    |b: &Body| (0..3).all(|d| (2 * b.low[d]..=2 * b.high[d]).contains(&p[d]));
                places[node] = if p.iter().any(|&c| c == 0 || c == side - 1) {
                    Place::Fixed
                } else if let Some(body) = bodies.iter().position(touches) {
                    Place::Body(body)
                } else {
                    free += 1;
                    Place::Free(free - 1)
                };
            }
        }
        let vertices = (0..side.pow(3))
            .filter(|&i| point(i).iter().all(|c| c % 2 == 0))
            .filter(|&i| matches!(places[i], Place::Free(_)))
            .count();

        let m = 6 * bodies.len();
        let centre = |b: usize| {
            let Body { low, high } = bodies[b];
            Vector3::from([0, 1, 2].map(|d| 0.5 * h * (low[d] + high[d]) as f64))
        };
        // rows of the rigid motion u = U + w x r at a body node: (component, unknown, value)
        let rigid = |b: usize, node: usize| {
            let r = position(node) - centre(b);
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
        for tet in &tets {
            let x = [0, 1, 2, 3].map(|v| position(tet[v]));
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
        for (index, body) in bodies.iter().enumerate() {
            // grad:grad becomes D:D by 2 |B| w.w: see the methods note 1.1
            let volume: f64 = (0..3)
                .map(|d| h * (body.high[d] - body.low[d]) as f64)
                .product();
            for d in 3..6 {
                corner[(6 * index + d, 6 * index + d)] += 2.0 * viscosity * volume;
            }
        }

        // P1 -> P2: lattice points between two vertices take half of each, vertices come first
        let mut edges: BTreeMap<usize, [usize; 2]> = BTreeMap::new();
        for tet in &tets {
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
        let coarse_stiffness = &(&p.transpose_view().to_csr() * &k) * &p;
        let a = Bordered::new(k, c.to_csr(), None, corner).expect("a sound velocity block");
        let b = csr3(np, free, &b);
        let system = SaddleSystem::new(a, b, e.to_csr(), None, q.to_csr()).expect("a sound system");
        let transfer = Transfer::new(p, motion.to_csr()).expect("a sound transfer");
        Stokes {
            system,
            transfer,
            coarse_stiffness,
        }
    }
}

/// Rows of 3-vectors from a sorted map.
pub fn csr3(rows: usize, cols: usize, entries: &BTreeMap<(usize, usize), [f64; 3]>) -> Csr3 {
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
