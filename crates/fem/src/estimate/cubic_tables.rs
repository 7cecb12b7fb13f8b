//! Element matrices between Taylor-Hood functions and the functions of the next degree.

use std::sync::LazyLock;

use mesh::TET_EDGES;
use nalgebra::Matrix3;

use super::bubbles::{BubblePoint, PER_CELL, rule};
use crate::FemError;
use crate::geometry::{Affine, CellNodes, MapAt};

/// Number of velocity functions of a cell: ten quadratic ones, then the bubbles.
pub(super) const VELOCITIES: usize = 10 + PER_CELL;

/// Number of pressure functions of a cell: four linear ones, then one per edge.
pub(super) const PRESSURES: usize = 4 + 6;

pub(super) type Square = [[f64; 10]; 10];

/// Scalar stiffness of a cell, `∫ ∇φ_i · ∇φ_j`, without the block of the quadratic functions.
///
/// Blocks are stored so that the innermost loop of a product runs over contiguous results.
pub(super) struct Stiffness {
    /// Between bubbles.
    pub bubbles: Square,
    /// From quadratic functions (first index) to bubbles.
    pub from_nodes: Square,
    /// From bubbles (first index) to quadratic functions.
    pub to_nodes: Square,
}

/// What the element matrices of an affine cell depend on.
#[derive(Clone, Copy)]
pub(super) struct AffineCell {
    /// `J^-1 J^-T det J` by the components [`METRIC`].
    metric: [f64; 6],
    /// `J^-T det J`, which maps the components of the reference divergence to velocities.
    pub pull: Matrix3<f64>,
    volume: f64,
}

impl AffineCell {
    /// Reads the geometry of a cell.
    pub fn new(cell: &Affine) -> Self {
        let map = cell.map();
        let metric = map.metric() * map.measure;
        Self {
            metric: METRIC.map(|at| metric[at]),
            pull: map.inverse_transpose() * map.measure,
            volume: cell.volume,
        }
    }

    /// Diagonals: `∫ |∇φ_k|^2` of the bubbles and `∫ ψ_p^2` of the edge pressures.
    pub fn diagonals(&self) -> ([f64; PER_CELL], [f64; 6]) {
        let mut energies = [0.0; PER_CELL];
        for (table, weight) in reference().stiffness.iter().zip(self.metric) {
            for (k, energy) in energies.iter_mut().enumerate() {
                *energy += weight * table.bubbles[k][k];
            }
        }
        // ∫ l_a^2 l_b^2 = 3! 2! 2! / 7! |T|
        (energies, [self.volume / 210.0; 6])
    }
}

impl Stiffness {
    const ZERO: Self = Self {
        bubbles: [[0.0; 10]; 10],
        from_nodes: [[0.0; 10]; 10],
        to_nodes: [[0.0; 10]; 10],
    };

    fn blocks(&self) -> [&Square; 3] {
        [&self.bubbles, &self.from_nodes, &self.to_nodes]
    }

    fn blocks_mut(&mut self) -> [&mut Square; 3] {
        [&mut self.bubbles, &mut self.from_nodes, &mut self.to_nodes]
    }

    /// Stiffness of an affine cell from the tables of the reference cell.
    pub fn affine(cell: &AffineCell) -> Self {
        let mut sum = Self::ZERO;
        for (table, weight) in reference().stiffness.iter().zip(cell.metric) {
            for (sum, table) in sum.blocks_mut().into_iter().zip(table.blocks()) {
                add_scaled(sum, weight, table);
            }
        }
        sum
    }

    /// The block from bubbles to quadratic functions of an affine cell.
    pub fn affine_to_nodes(cell: &AffineCell) -> Square {
        let mut sum = [[0.0; 10]; 10];
        for (table, weight) in reference().stiffness.iter().zip(cell.metric) {
            add_scaled(&mut sum, weight, &table.to_nodes);
        }
        sum
    }

    /// Adds `weight ∇φ_i M ∇φ_j` at a quadrature point.
    fn add(&mut self, point: &BubblePoint, matrix: &Matrix3<f64>, weight: f64) {
        let nodes = point.at.gradients.map(|g| weight * (matrix * g));
        let bubbles = point.gradients.map(|g| weight * (matrix * g));
        for i in 0..10 {
            for j in 0..10 {
                self.bubbles[i][j] += point.gradients[i].dot(&bubbles[j]);
                self.from_nodes[i][j] += point.at.gradients[i].dot(&bubbles[j]);
                self.to_nodes[i][j] += point.gradients[i].dot(&nodes[j]);
            }
        }
    }
}

/// `sum += weight * table`.
fn add_scaled(sum: &mut Square, weight: f64, table: &Square) {
    for (sum, row) in sum.iter_mut().zip(table) {
        for (sum, value) in sum.iter_mut().zip(row) {
            *sum += weight * value;
        }
    }
}

/// `∫ ψ_p ∂φ_k/∂ξ_d`, without linear pressures times quadratic velocities.
///
/// In both layouts the innermost loop of a product runs over contiguous results.
pub(super) struct Divergence {
    /// By component `d`, velocity `k`, pressure `p`.
    pub by_velocity: [[[f64; PRESSURES]; VELOCITIES]; 3],
    /// By pressure `p`, component `d`, velocity `k`.
    pub by_pressure: [[[f64; VELOCITIES]; 3]; PRESSURES],
}

impl Divergence {
    /// Adds the products at a quadrature point, with the gradients mapped by `map`.
    fn add(&mut self, point: &BubblePoint, weight: f64, map: &Matrix3<f64>) {
        let l = &point.at.barycentric;
        let edges = TET_EDGES.map(|[a, b]| l[a] * l[b]);
        for k in 0..VELOCITIES {
            let gradient = match k {
                0..10 => point.at.gradients[k],
                _ => point.gradients[k - 10],
            };
            let gradient = map * gradient * weight;
            for p in 0..PRESSURES {
                let value = match (p, k) {
                    (0..4, 0..10) => continue,
                    (0..4, _) => l[p],
                    _ => edges[p - 4],
                };
                for d in 0..3 {
                    self.by_velocity[d][k][p] += value * gradient[d];
                    self.by_pressure[p][d][k] += value * gradient[d];
                }
            }
        }
    }

    const ZERO: Self = Self {
        by_velocity: [[[0.0; PRESSURES]; VELOCITIES]; 3],
        by_pressure: [[[0.0; VELOCITIES]; 3]; PRESSURES],
    };
}

/// Components of a symmetric matrix.
const METRIC: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// Integrals over the reference cell.
struct Reference {
    /// Stiffness for each of the components [`METRIC`].
    stiffness: [Stiffness; 6],
    divergence: Divergence,
}

fn reference() -> &'static Reference {
    static REFERENCE: LazyLock<Box<Reference>> = LazyLock::new(|| {
        let mut tables = Box::new(Reference {
            stiffness: [const { Stiffness::ZERO }; 6],
            divergence: Divergence::ZERO,
        });
        for point in rule() {
            for (table, (a, b)) in tables.stiffness.iter_mut().zip(METRIC) {
                let mut unit = Matrix3::zeros();
                (unit[(a, b)], unit[(b, a)]) = (1.0, 1.0);
                table.add(point, &unit, point.at.weight);
            }
            (tables.divergence).add(point, point.at.weight, &Matrix3::identity());
        }
        tables
    });
    &REFERENCE
}

/// Divergence table of the reference cell, for all affine cells.
pub(super) fn reference_divergence() -> &'static Divergence {
    &reference().divergence
}

/// Element matrices of a curved cell, in its physical coordinates.
pub(super) struct CurvedCell {
    pub stiffness: Stiffness,
    pub divergence: Divergence,
    /// `∫ ψ_p^2` of the edge pressures.
    masses: [f64; 6],
}

impl CurvedCell {
    /// Integrates over a cell with the given nodes.
    pub fn new(cell: usize, nodes: &CellNodes) -> Result<Box<Self>, FemError> {
        let mut tables = Box::new(Self {
            stiffness: Stiffness::ZERO,
            divergence: Divergence::ZERO,
            masses: [0.0; 6],
        });
        for point in rule() {
            let map = MapAt::new(cell, nodes, point.at)?;
            let l = &point.at.barycentric;
            for (mass, [a, b]) in tables.masses.iter_mut().zip(TET_EDGES) {
                *mass += map.measure * (l[a] * l[b]).powi(2);
            }
            (tables.stiffness).add(point, &map.metric(), map.measure);
            (tables.divergence).add(point, map.measure, &map.inverse_transpose());
        }
        Ok(tables)
    }

    /// Diagonals: `∫ |∇φ_k|^2` of the bubbles and `∫ ψ_p^2` of the edge pressures.
    pub fn diagonals(&self) -> ([f64; PER_CELL], [f64; 6]) {
        let energies = std::array::from_fn(|k| self.stiffness.bubbles[k][k]);
        (energies, self.masses)
    }
}
