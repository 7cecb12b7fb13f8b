//! Element matrices between Taylor-Hood functions and the functions of the next degree.
//!
//! Functions that `cubic_cell.rs` calls for every cell are `inline(always)`.

use std::sync::LazyLock;

use mesh::{TET_EDGES, Vec3};
use nalgebra::Matrix3;

use super::bubbles::{BUBBLES_PER_CELL, BubblePoint, rule};
use crate::FemError;
use crate::geometry::{Affine, CellNodes, MapAt};

pub(super) type Square = [[f64; 10]; 10];

/// Values of the ten quadratic functions of a cell, or of its ten bubbles, by component.
pub(super) type Vectors = [[f64; 10]; 3];

/// Scalar stiffness of a cell, `∫ ∇φ_i · ∇φ_j`, without the block of the quadratic functions.
pub(super) struct Stiffness {
    /// Between bubbles.
    bubbles: Square,
    /// From quadratic functions (first index) to bubbles.
    from_nodes: Square,
}

/// Inverse transpose `J^-T` of the map to an affine cell, and the volume of the cell.
#[derive(Clone, Copy)]
pub(super) struct AffineMap {
    inverse_transpose: Matrix3<f64>,
    volume: f64,
}

impl AffineMap {
    /// Reads the geometry of a cell.
    pub fn new(cell: &Affine) -> Self {
        Self {
            inverse_transpose: cell.map().inverse_transpose(),
            volume: cell.volume,
        }
    }
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
    #[inline(always)]
    pub fn new(map: &AffineMap) -> Self {
        let measure = 6.0 * map.volume;
        let metric = map.inverse_transpose.tr_mul(&map.inverse_transpose) * measure;
        Self {
            metric: METRIC.map(|at| metric[at]),
            pull: map.inverse_transpose * measure,
            volume: map.volume,
        }
    }

    /// Diagonals: `∫ |∇φ_k|^2` of the bubbles and `∫ ψ_p^2` of the edge pressures.
    pub fn diagonals(&self) -> ([f64; BUBBLES_PER_CELL], [f64; 6]) {
        let mut energies = [0.0; BUBBLES_PER_CELL];
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
    };

    /// Stiffness of an affine cell from the tables of the reference cell.
    #[inline(always)]
    pub fn affine(cell: &AffineCell) -> Self {
        let mut sum = Self::ZERO;
        for (table, weight) in reference().stiffness.iter().zip(cell.metric) {
            add_scaled(&mut sum.bubbles, weight, &table.bubbles);
            add_scaled(&mut sum.from_nodes, weight, &table.from_nodes);
        }
        sum
    }

    /// The block between quadratic functions and bubbles alone, all else zero.
    #[inline(always)]
    pub fn affine_between_nodes_and_bubbles(cell: &AffineCell) -> Self {
        let mut sum = Self::ZERO;
        for (table, weight) in reference().stiffness.iter().zip(cell.metric) {
            add_scaled(&mut sum.from_nodes, weight, &table.from_nodes);
        }
        sum
    }

    /// Adds the rows of the bubbles of a product.
    #[inline(always)]
    pub fn add_to_bubbles(&self, nodes: &Vectors, bubbles: &Vectors, sums: &mut Vectors) {
        add_product(&self.bubbles, bubbles, sums);
        add_product(&self.from_nodes, nodes, sums);
    }

    /// Adds the rows of the quadratic functions of a product with bubbles.
    #[inline(always)]
    pub fn add_to_nodes(&self, bubbles: &Vectors, sums: &mut Vectors) {
        let mut to_nodes = [[0.0; 10]; 10];
        for (i, row) in self.from_nodes.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                to_nodes[j][i] = *value;
            }
        }
        add_product(&to_nodes, bubbles, sums);
    }

    /// Adds `weight ∇φ_i M ∇φ_j` at a quadrature point.
    fn add(&mut self, point: &BubblePoint, matrix: &Matrix3<f64>, weight: f64) {
        let bubbles = point.gradients.map(|g| weight * (matrix * g));
        for i in 0..10 {
            for j in 0..10 {
                self.bubbles[i][j] += point.gradients[i].dot(&bubbles[j]);
                self.from_nodes[i][j] += point.at.gradients[i].dot(&bubbles[j]);
            }
        }
    }
}

/// `sums += matrix^T values` for each component.
///
/// The components are in the inner loop, so that sums that follow each other are independent.
#[inline(always)]
fn add_product(matrix: &Square, values: &Vectors, sums: &mut Vectors) {
    for (k, row) in matrix.iter().enumerate() {
        for (sums, values) in sums.iter_mut().zip(values) {
            add(sums, values[k], row);
        }
    }
}

/// `sums += factor * values`.
#[inline(always)]
fn add<const N: usize>(sums: &mut [f64; N], factor: f64, values: &[f64; N]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += factor * value;
    }
}

/// `sum += weight * table`.
#[inline(always)]
fn add_scaled(sum: &mut Square, weight: f64, table: &Square) {
    for (sum, row) in sum.iter_mut().zip(table) {
        add(sum, weight, row);
    }
}

/// `∫ ψ_p ∂φ_k/∂ξ_d` of ten velocities `k` and `P` pressures `p`.
///
/// For the reference cell in two layouts, because the innermost loop of a product then runs over
/// contiguous results. Of the few curved cells one layout takes half the memory.
pub(super) struct Coupling<const P: usize> {
    /// By component `d`, velocity `k`, pressure `p`.
    by_velocity: Option<Box<ByVelocity<P>>>,
    /// By pressure `p`, component `d`, velocity `k`.
    by_pressure: [[[f64; 10]; 3]; P],
}

type ByVelocity<const P: usize> = [[[f64; P]; 10]; 3];

impl<const P: usize> Coupling<P> {
    const ZERO: Self = Self {
        by_velocity: None,
        by_pressure: [[[0.0; 10]; 3]; P],
    };

    /// Adds the second layout.
    fn store_by_velocity(&mut self) {
        let mut by_velocity = Box::new([[[0.0; P]; 10]; 3]);
        for (p, table) in self.by_pressure.iter().enumerate() {
            for (d, values) in table.iter().enumerate() {
                for (k, value) in values.iter().enumerate() {
                    by_velocity[d][k][p] = *value;
                }
            }
        }
        self.by_velocity = Some(by_velocity);
    }

    /// Adds the products of pressures with gradients at a quadrature point.
    fn add(&mut self, pressures: [f64; P], gradients: &[Vec3; 10]) {
        for (k, gradient) in gradients.iter().enumerate() {
            for (p, value) in pressures.into_iter().enumerate() {
                for d in 0..3 {
                    self.by_pressure[p][d][k] += value * gradient[d];
                }
            }
        }
    }

    /// Minus the divergence of velocities with the components `d`, as rows of pressures.
    #[inline(always)]
    pub fn minus_divergence(&self, velocities: &Vectors) -> [f64; P] {
        let mut sums = [[0.0; P]; 3];
        match &self.by_velocity {
            Some(by_velocity) => {
                for k in 0..10 {
                    for ((sums, values), table) in
                        sums.iter_mut().zip(velocities).zip(by_velocity.iter())
                    {
                        add(sums, values[k], &table[k]);
                    }
                }
            }
            None => {
                for (p, table) in self.by_pressure.iter().enumerate() {
                    for ((sums, values), table) in sums.iter_mut().zip(velocities).zip(table) {
                        for (value, entry) in values.iter().zip(table) {
                            sums[p] += value * entry;
                        }
                    }
                }
            }
        }
        let mut rows = [0.0; P];
        for sums in &sums {
            add(&mut rows, -1.0, sums);
        }
        rows
    }

    /// Adds the products with pressures to rows of velocities, by component `d`.
    #[inline(always)]
    pub fn add_gradient(&self, pressures: &[f64; P], rows: &mut Vectors) {
        for (&value, table) in pressures.iter().zip(&self.by_pressure) {
            for (rows, table) in rows.iter_mut().zip(table) {
                add(rows, value, table);
            }
        }
    }
}

/// Couplings of velocities and pressures, but for quadratic velocities with linear pressures.
pub(super) struct Divergence {
    /// Of bubbles and linear pressures.
    pub linear: Coupling<4>,
    /// Of bubbles and the pressures of edges.
    pub edges: Coupling<6>,
    /// Of quadratic velocities and the pressures of edges.
    pub from_nodes: Coupling<6>,
}

impl Divergence {
    const ZERO: Self = Self {
        linear: Coupling::ZERO,
        edges: Coupling::ZERO,
        from_nodes: Coupling::ZERO,
    };

    /// Adds the products at a quadrature point, with the gradients mapped by `map`.
    fn add(&mut self, point: &BubblePoint, weight: f64, map: &Matrix3<f64>) {
        let l = &point.at.barycentric;
        let edges = TET_EDGES.map(|[a, b]| l[a] * l[b]);
        let nodes = point.at.gradients.map(|g| map * g * weight);
        let bubbles = point.gradients.map(|g| map * g * weight);
        self.linear.add(*l, &bubbles);
        self.edges.add(edges, &bubbles);
        self.from_nodes.add(edges, &nodes);
    }
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
        tables.divergence.linear.store_by_velocity();
        tables.divergence.edges.store_by_velocity();
        tables.divergence.from_nodes.store_by_velocity();
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
    pub fn diagonals(&self) -> ([f64; BUBBLES_PER_CELL], [f64; 6]) {
        let energies = std::array::from_fn(|k| self.stiffness.bubbles[k][k]);
        (energies, self.masses)
    }
}
