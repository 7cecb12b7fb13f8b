//! One level of the cycle in single precision: smoother and prolongation.

use std::array::from_fn;

use super::vectors::{Columns, Vectors};
use crate::csr::{Csr32, Rounded, Rows, to_f32};
use crate::node_kernel::{SparseNodes, long_row, padded_row};
use crate::row_blocks::RowBlocks;
use crate::transpose::transpose;
use crate::{Bordered, Prolongation};

/// A level above the coarsest.
///
/// The smoother changes nodes only; the coarsest level solves for border dofs.
pub(super) struct Level {
    k: Rounded,
    c: SparseNodes<f32>,
    /// `C_l^T`, with columns numbered in padded nodes.
    border_rows: Csr32,
    inverse_diagonal: Vec<f32>,
    /// Relaxation factors of the smoothing steps, the same before and after the coarse correction.
    factors: Vec<f32>,
    p: Csr32,
    p_transposed: Csr32,
    q: SparseNodes<f32>,
    /// `Q_l^T`, with columns numbered in padded nodes.
    q_transposed: Csr32,
    blocks: RowBlocks,
    coarse_blocks: RowBlocks,
    border_blocks: RowBlocks,
    pub vectors: Vectors,
}

impl Level {
    /// Rounds `unit` times `operator`, and `prolongation`, to f32.
    pub fn new(
        operator: &Bordered,
        prolongation: &Prolongation,
        diagonal: &[f64],
        unit: f64,
        factors: &[f64],
    ) -> Self {
        let (n, m) = (operator.nodes(), operator.border_len());
        let p_transposed = to_f32(&transpose(prolongation.nodes()), 1.0);
        Level {
            k: Rounded::new(operator.shared_stiffness(), unit),
            c: SparseNodes::new(operator.border(), |v| (v * unit) as f32),
            border_rows: padded_columns(&to_f32(operator.border_rows(), unit)),
            inverse_diagonal: diagonal.iter().map(|d| (d * unit).recip() as f32).collect(),
            factors: factors.iter().map(|w| *w as f32).collect(),
            p: to_f32(prolongation.nodes(), 1.0),
            coarse_blocks: RowBlocks::new(Rows::of(&p_transposed).indptr),
            p_transposed,
            q: SparseNodes::new(prolongation.border(), |v| v as f32),
            q_transposed: padded_columns(&to_f32(&transpose(prolongation.border_left()), 1.0)),
            blocks: operator.node_blocks().clone(),
            border_blocks: operator.border_blocks().clone(),
            vectors: Vectors::new(n, m, operator.constrained_dofs().clone()),
        }
    }

    /// One smoothing step, `x' = x + w D^-1 (b - K x)`: one pass.
    fn sweep<const S: usize>(&mut self, factor: f32) {
        let (k, inverse_diagonal) = (self.k.rows(), &self.inverse_diagonal);
        let Columns {
            b,
            x,
            next,
            constrained,
            ..
        } = self.vectors.columns::<S>();
        self.blocks.for_each(&mut *next, &|i, next| {
            let a = padded_row(k, i, x);
            let step = factor * inverse_diagonal[i];
            for s in 0..S {
                for d in 0..4 {
                    next[s][d] = x[i][s][d] + step * (b[i][s][d] - a[s][d]);
                }
            }
        });
        constrained.clear_columns(next);
        self.vectors.advance();
    }

    /// Smoothing before the coarse correction, from a zero guess.
    ///
    /// The first step needs no pass over the matrix.
    pub fn smooth_from_zero<const S: usize>(&mut self) {
        let (first, inverse_diagonal) = (self.factors[0], &self.inverse_diagonal);
        let Columns { b, x, .. } = self.vectors.columns::<S>();
        self.blocks.for_each(x, &|i, xi| {
            *xi = b[i].map(|b| b.map(|b| first * inverse_diagonal[i] * b));
        });
        for sweep in 1..self.factors.len() {
            self.sweep::<S>(self.factors[sweep]);
        }
    }

    /// Smoothing after the coarse correction.
    pub fn smooth<const S: usize>(&mut self) {
        let Columns { b, border_x, .. } = self.vectors.columns::<S>();
        // border dofs do not change in the smoothing steps
        self.c.for_each(0..b.len(), |i, d, c, value| {
            for s in 0..S {
                b[i][s][d] -= value * border_x[c][s];
            }
        });
        for sweep in 0..self.factors.len() {
            self.sweep::<S>(self.factors[sweep]);
        }
    }

    /// Restricts the residual of `x` with zero border, in one pass.
    ///
    /// `b_c = P^T r`, and for the border `b_c = r_v + Q_l^T r`.
    pub fn restrict<const S: usize>(&mut self, coarse: &mut Vectors) {
        let Columns {
            b,
            x,
            next: r,
            border_b,
            ..
        } = self.vectors.columns::<S>();
        let coarse = coarse.columns::<S>();
        let (k, p) = (self.k.rows(), Rows::of(&self.p_transposed));
        self.blocks.for_each(r, &|i, ri| {
            let a = padded_row(k, i, x);
            for s in 0..S {
                for d in 0..4 {
                    ri[s][d] = b[i][s][d] - a[s][d];
                }
            }
        });
        self.coarse_blocks
            .for_each(&mut *coarse.b, &|i, bi| *bi = padded_row(p, i, r));
        coarse.constrained.clear_columns(coarse.b);
        let (left, q) = (Rows::of(&self.border_rows), Rows::of(&self.q_transposed));
        self.border_blocks.for_each(coarse.border_b, &|c, bc| {
            let known = long_row(left, c, |j| x[j / 4].map(|x| x[j % 4]));
            let motion = long_row(q, c, |j| r[j / 4].map(|r| r[j % 4]));
            *bc = from_fn(|s| (f64::from(border_b[c][s]) - known[s] + motion[s]) as f32);
        });
    }

    /// `x <- x + P x_c + Q v_c`, `v <- v_c`.
    pub fn prolong<const S: usize>(&mut self, coarse: &mut Vectors) {
        let p = Rows::of(&self.p);
        let Columns { x, border_x, .. } = self.vectors.columns::<S>();
        let coarse = coarse.columns::<S>();
        self.blocks.for_each(x, &|i, xi| {
            let a = padded_row(p, i, coarse.x);
            for s in 0..S {
                for d in 0..4 {
                    xi[s][d] += a[s][d];
                }
            }
        });
        border_x.copy_from_slice(coarse.border_x);
        self.q.for_each(0..x.len(), |i, d, c, value| {
            for s in 0..S {
                x[i][s][d] += value * border_x[c][s];
            }
        });
    }
}

#[cfg(feature = "roofline")]
impl Level {
    /// Number of smoothing steps before and after the coarse correction.
    pub fn steps(&self) -> usize {
        self.factors.len()
    }

    /// Bytes of one smoothing step: the matrix, three vectors, the diagonal.
    pub fn sweep_bytes(&self) -> usize {
        let n = self.vectors.nodes();
        8 * self.k.rows().nnz() + n * (8 + 48 + 4)
    }

    /// Bytes of a residual and its restriction.
    pub fn restriction_bytes(&self) -> usize {
        let (n, nc) = (self.vectors.nodes(), self.p_transposed.rows());
        let residual = 8 * self.k.rows().nnz() + n * (8 + 48);
        residual + 8 * self.p.nnz() + 16 * n + 24 * nc
    }

    /// Bytes of a prolongation.
    pub fn prolongation_bytes(&self) -> usize {
        let (n, nc) = (self.vectors.nodes(), self.p_transposed.rows());
        8 * self.p.nnz() + n * (8 + 32) + 16 * nc
    }

    /// One smoothing step on the present contents of the vectors.
    pub fn sweep_once(&mut self) {
        self.sweep::<1>(self.factors[0]);
    }
}

/// Renumbers columns `3 node + d` as `4 node + d`.
fn padded_columns(rows: &Csr32) -> Csr32 {
    let columns = rows.indices().iter().map(|&c| c / 3 * 4 + c % 3).collect();
    Csr32::new(
        (rows.rows(), rows.cols() / 3 * 4),
        rows.indptr().into_raw_storage().to_vec(),
        columns,
        rows.data().to_vec(),
    )
}
