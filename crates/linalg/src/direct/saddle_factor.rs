//! Factors of a shifted saddle-point system, a preconditioner of the system without the shift.

use nalgebra::{DMatrix, DVector};

use super::factor::{Definiteness, Precision, SparseFactor};
use super::nested_dissection;
use crate::csr::{Rows, diagonal};
use crate::node_kernel::long_row;
use crate::product::build_rows;
use crate::schur::SchurFactor;
use crate::vector::{axpy, power_of_two_below};
use crate::{Csr, LinalgError, Preconditioner, PreconditionerKind, SaddleSystem};

/// Right-hand sides solved together: enough for level-3 kernels, with little memory.
const RHS_PER_SOLVE: usize = 6;

/// Factors of `[K (x) I3, B^T; B, -shift diag(M_p)]` with the border eliminated.
///
/// The Schur complement of the border is dense and factorised with pivoting.
///
/// Rows and columns are scaled by powers of two so that diagonals are near one. Factors in f32
/// therefore do not overflow in any system of units.
pub(crate) struct SaddleFactor {
    factor: SparseFactor,
    /// Number of velocity dofs.
    velocity: usize,
    /// Powers of two for the velocity dofs, then for the pressure dofs.
    scales: Vec<f64>,
    /// Solutions of the fluid block for the border columns `[C; E]`, one after another.
    lifted: Vec<f64>,
    /// `C_l^T` and `E_l^T`.
    border_rows: [Csr; 2],
    schur: SchurFactor,
    /// Whether the pressure is determined up to a constant only.
    enclosed: bool,
    fluid: Vec<f64>,
    border: DVector<f64>,
}

impl SaddleFactor {
    /// Orders and factorises the shifted system.
    ///
    /// # Errors
    /// [`LinalgError::Factorisation`] for a singular block or lack of memory.
    pub fn new(
        system: &SaddleSystem,
        shift: f64,
        precision: Precision,
    ) -> Result<Self, LinalgError> {
        let scales = scales(system);
        let order = elimination_order(system)?;
        let matrix = fluid_block(system, shift, &scales);
        let quasi = Definiteness::Quasi;
        let mut factor = SparseFactor::new(
            "fluid block",
            &matrix,
            &order,
            quasi,
            precision,
            RHS_PER_SOLVE,
        )?;
        let (m, size) = (system.border_range().len(), matrix.rows());
        drop(matrix);
        let mut lifted = border_columns(system);
        scale_columns(&mut lifted, &scales);
        factor.solve_in_place(&mut lifted);
        scale_columns(&mut lifted, &scales);
        let a = system.velocity_block();
        let border_rows = [a.border_rows().clone(), system.border_gradient().clone()];
        let velocity = system.velocity_range().len();
        let mut schur: DMatrix<f64> = a.corner().clone();
        for d in 0..m {
            let column = &lifted[size * d..size * (d + 1)];
            for c in 0..m {
                schur[(c, d)] -= border_row(&border_rows, velocity, c, column);
            }
        }
        Ok(SaddleFactor {
            factor,
            velocity,
            scales,
            lifted,
            border_rows,
            schur: SchurFactor::new(schur)?,
            enclosed: is_enclosed(system),
            fluid: vec![0.0; size],
            border: DVector::zeros(m),
        })
    }

    /// Number of nonzeros of the factor.
    pub fn nnz(&self) -> usize {
        self.factor.nnz()
    }

    /// Bytes of the factor.
    pub fn bytes(&self) -> usize {
        self.factor.bytes()
    }

    /// Removes the mean pressure from `z` if it is undetermined.
    pub fn remove_constant(&self, z: &mut [f64]) {
        if self.enclosed {
            let p = &mut z[self.velocity + self.border.len()..];
            let mean = p.iter().sum::<f64>() / p.len() as f64;
            p.iter_mut().for_each(|p| *p -= mean);
        }
    }
}

impl Preconditioner for SaddleFactor {
    fn size(&self) -> usize {
        self.fluid.len() + self.border.len()
    }

    /// Overwrites `z` with the solution of the shifted system for `r`.
    ///
    /// In enclosed flow it has zero mean pressure.
    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        let (split, m) = (self.velocity, self.border.len());
        let t = &mut self.fluid;
        t[..split].copy_from_slice(&r[..split]);
        t[split..].copy_from_slice(&r[split + m..]);
        scale_columns(t, &self.scales);
        self.factor.solve_in_place(t);
        scale_columns(t, &self.scales);
        for (c, v) in self.border.iter_mut().enumerate() {
            *v = r[split + c] - border_row(&self.border_rows, split, c, t);
        }
        self.schur.solve(&mut self.border);
        let columns = self.lifted.chunks_exact(t.len().max(1));
        for (column, v) in columns.zip(self.border.iter()) {
            axpy(-v, column, t);
        }
        z[..split].copy_from_slice(&t[..split]);
        z[split..split + m].copy_from_slice(self.border.as_slice());
        z[split + m..].copy_from_slice(&t[split..]);
        self.remove_constant(z);
    }

    /// Linear up to rounding errors, which the shifted pressure block amplifies to 1e-3 in f32.
    fn kind(&self) -> PreconditionerKind {
        PreconditionerKind::Variable
    }
}

/// The columns `[C; E]`, one after another.
fn border_columns(system: &SaddleSystem) -> Vec<f64> {
    let (velocity, pressure) = (system.velocity_range().len(), system.pressure_range().len());
    let size = velocity + pressure;
    let mut columns = vec![0.0; size * system.border_range().len()];
    let (c, e) = (
        Rows::new(system.velocity_block().border()),
        Rows::new(system.border_divergence()),
    );
    for i in 0..velocity {
        for (col, v) in c.row(i) {
            columns[size * col + i] = v;
        }
    }
    for q in 0..pressure {
        for (col, v) in e.row(q) {
            columns[size * col + velocity + q] = v;
        }
    }
    columns
}

/// `(C_l^T u + E_l^T p)_c` of a fluid vector `[u; p]`.
fn border_row(rows: &[Csr; 2], velocity: usize, c: usize, fluid: &[f64]) -> f64 {
    let (u, p) = fluid.split_at(velocity);
    let [nodes] = long_row(Rows::new(&rows[0]), c, |j| [u[j]]);
    let [pressures] = long_row(Rows::new(&rows[1]), c, |q| [p[q]]);
    nodes + pressures
}

fn scale_columns(columns: &mut [f64], scales: &[f64]) {
    for column in columns.chunks_exact_mut(scales.len().max(1)) {
        for (v, s) in column.iter_mut().zip(scales) {
            *v *= s;
        }
    }
}

/// Scaling factors: about `K_ii^-1/2` for the velocities of node i, `M_p,qq^-1/2` for pressure q.
///
/// The Schur complement equals `M_p` up to a factor of six.
fn scales(system: &SaddleSystem) -> Vec<f64> {
    let inverse_root = |d: &f64| power_of_two_below(d.sqrt().recip());
    let k = diagonal(system.velocity_block().stiffness());
    let mass = diagonal(system.pressure_mass());
    let velocity = k.iter().flat_map(|d| [inverse_root(d); 3]);
    velocity.chain(mass.iter().map(inverse_root)).collect()
}

/// `D [K (x) I3, B^T; B, -shift diag(M_p)] D` for `D = diag(scales)`.
fn fluid_block(system: &SaddleSystem, shift: f64, scales: &[f64]) -> Csr {
    let a = system.velocity_block();
    let (k, b, bt) = (
        Rows::new(a.stiffness()),
        Rows::new(system.divergence()),
        Rows::new(system.gradient()),
    );
    let mass = diagonal(system.pressure_mass());
    let velocity = 3 * a.nodes();
    let size = velocity + mass.len();
    build_rows(size, size, |i, row| {
        let mut add = |j: usize, v: f64| row.add(j, scales[i] * v * scales[j]);
        if i < velocity {
            let d = i % 3;
            for (j, v) in k.row(i / 3) {
                add(3 * j + d, v);
            }
            for (q, w) in bt.row(i / 3) {
                add(velocity + q, w[d]);
            }
        } else {
            let q = i - velocity;
            for (j, w) in b.row(q) {
                for (d, v) in w.iter().enumerate() {
                    add(3 * j + d, *v);
                }
            }
            add(i, -shift * mass[q]);
        }
    })
}

/// Neighbours of each velocity node (three dofs), then of each pressure (one dof).
///
/// The pressures are numbered after the `n` nodes.
pub(crate) fn adjacency(system: &SaddleSystem) -> Vec<Vec<u32>> {
    let a = system.velocity_block();
    let n = a.nodes();
    let (k, b, bt) = (
        Rows::new(a.stiffness()),
        Rows::new(system.divergence()),
        Rows::new(system.gradient()),
    );
    let node = |i: usize| {
        let velocities = k.row(i).map(|(j, _)| j as u32);
        let others = velocities.filter(move |&j| j as usize != i);
        others
            .chain(bt.row(i).map(|(q, _)| (n + q) as u32))
            .collect()
    };
    let pressure = |q: usize| b.row(q).map(|(j, _)| j as u32).collect();
    let pressures = system.pressure_range().len();
    (0..n)
        .map(node)
        .chain((0..pressures).map(pressure))
        .collect()
}

/// Number of dofs of each vertex of [`adjacency`].
pub(crate) fn weights(system: &SaddleSystem) -> Vec<u32> {
    let (n, np) = (
        system.velocity_block().nodes(),
        system.pressure_range().len(),
    );
    (0..n + np).map(|v| if v < n { 3 } else { 1 }).collect()
}

/// Elimination order of the dofs: nested dissection of the graph of nodes and pressures.
///
/// With 283 000 dofs the factor has 484 million nonzeros and takes 2.4e12 operations. Merging each
/// pressure with a node increases these two numbers by 12 % and 24 %. Trying four separators per
/// cut decreases them by 4 % and 9 %, but the ordering takes as much time as this saves.
fn elimination_order(system: &SaddleSystem) -> Result<Vec<usize>, LinalgError> {
    let n = system.velocity_block().nodes();
    let mut order = Vec::with_capacity(system.velocity_range().len());
    for vertex in nested_dissection(&adjacency(system), &weights(system))? {
        if vertex < n {
            order.extend(3 * vertex..3 * vertex + 3);
        } else {
            order.push(2 * n + vertex);
        }
    }
    Ok(order)
}

/// Whether `[B^T; E_l^T] 1 = 0` to rounding, so that a constant pressure is undetermined.
fn is_enclosed(system: &SaddleSystem) -> bool {
    let (bt, et) = (
        Rows::new(system.gradient()),
        Rows::new(system.border_gradient()),
    );
    // a sum of k terms of size s is zero up to k epsilon s; 1e-10 also allows for rounding in the
    // terms
    let vanishes = |terms: &mut dyn Iterator<Item = f64>| {
        let (mut sum, mut size) = (0.0, 0.0);
        for t in terms {
            sum += t;
            size += t.abs();
        }
        f64::abs(sum) <= 1e-10 * size
    };
    (0..system.velocity_block().nodes())
        .all(|i| (0..3).all(|d| vanishes(&mut bt.row(i).map(|(_, w)| w[d]))))
        && (0..et.indptr.len() - 1).all(|c| vanishes(&mut et.row(c).map(|(_, w)| w)))
}
