//! A Stokes system of Taylor-Hood elements without a mesh crate.
//!
//! The mesh is a cube divided by Kuhn's rule, with cubic rigid bodies cut out.

pub mod domain;
pub mod elements;

use linalg::{LinearOperator, Prolongation, SaddleSystem};
use nalgebra::Vector3;

use domain::{Domain, Owner};
use elements::{EDGES, kuhn_tets};

/// A body that fills the cells `low .. high` of the grid in each direction.
#[derive(Clone, Copy)]
pub struct Body {
    pub low: [usize; 3],
    pub high: [usize; 3],
}

/// A cubic body with `size` cells per side and its lowest corner at `low`.
pub fn cube(low: [usize; 3], size: usize) -> Body {
    Body {
        low,
        high: low.map(|l| l + size),
    }
}

/// One body, a quarter of the cube wide, in a cube of `4 k` cells per side.
pub fn one_body(k: usize) -> Stokes {
    Stokes::new(4 * k, &[cube([k + k / 2; 3], k)], 4.0)
}

/// The assembled system and the prolongation from P1 to P2 elements.
pub struct Stokes {
    pub system: SaddleSystem,
    pub prolongation: Prolongation,
}

impl Stokes {
    /// A cube of side `length` with `cells` cells per side, no slip on its walls and viscosity 1.
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

        let owner = |node: usize| {
            let p = point(node);
            let touches = |b: &Body| (0..3).all(|d| (2 * b.low[d]..=2 * b.high[d]).contains(&p[d]));
            if p.iter().any(|&c| c == 0 || c == side - 1) {
                Owner::Wall
            } else {
                bodies
                    .iter()
                    .position(touches)
                    .map_or(Owner::Fluid, Owner::Body)
            }
        };
        let middle =
            |b: &Body| Vector3::from([0, 1, 2].map(|d| 0.5 * h * (b.low[d] + b.high[d]) as f64));
        let volume = |b: &Body| (0..3).map(|d| h * (b.high[d] - b.low[d]) as f64).product();
        let points = (0..side.pow(3)).map(position).collect();
        Domain {
            owners: (0..side.pow(3)).map(owner).collect(),
            centres: bodies.iter().map(middle).collect(),
            volumes: bodies.iter().map(volume).collect(),
            points,
            tets,
        }
        .assemble(viscosity)
    }
}

/// A right-hand side of forces and torques on the bodies.
pub fn body_forces(system: &SaddleSystem) -> Vec<f64> {
    let mut b = vec![0.0; system.rows()];
    for (c, v) in b[system.border_range()].iter_mut().enumerate() {
        *v = 1.0 + (c as f64 * 0.7).sin();
    }
    b
}
