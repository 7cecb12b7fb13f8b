//! One level of the cycle: its smoother and its transfer, in single precision.

use std::mem::swap;

use super::vectors::Vectors;
use crate::csr::{Csr32, Rounded, Rows, to_f32, transpose};
use crate::node_kernel::{Padded, SparseNodes, long_row, padded_row};
use crate::row_blocks::RowBlocks;
use crate::{Bordered, Transfer};

/// A level above the coarsest. The smoother moves nodes only; border unknowns are the coarsest level's business.
pub(super) struct Level {
    k: Rounded,
    c: SparseNodes<f32>,
    /// `C_l^T`, columns counted in padded nodes.
    border_rows: Csr32,
    inverse_diagonal: Vec<f32>,
    /// Relaxation factors of the sweeps, the same before and after the coarse correction.
    factors: Vec<f32>,
    p: Csr32,
    p_transposed: Csr32,
    q: SparseNodes<f32>,
    /// `Q_l^T`, columns counted in padded nodes.
    q_transposed: Csr32,
    blocks: RowBlocks,
    coarse_blocks: RowBlocks,
    border_blocks: RowBlocks,
    pub vectors: Vectors,
    next: Vec<Padded>,
}

impl Level {
    /// Rounds `operator` times `unit` and `transfer`.
    pub fn new(
        operator: &Bordered,
        transfer: &Transfer,
        diagonal: &[f64],
        unit: f64,
        factors: &[f64],
    ) -> Self {
        let (n, m) = (operator.nodes(), operator.border_len());
        let p_transposed = to_f32(&transpose(transfer.nodes()), 1.0);
        Level {
            k: Rounded::new(operator.shared_stiffness(), unit),
            c: SparseNodes::new(operator.border(), |v| (v * unit) as f32),
            border_rows: padded_columns(&to_f32(operator.border_rows(), unit)),
            inverse_diagonal: diagonal.iter().map(|d| (d * unit).recip() as f32).collect(),
            factors: factors.iter().map(|w| *w as f32).collect(),
            p: to_f32(transfer.nodes(), 1.0),
            coarse_blocks: RowBlocks::new(Rows::of(&p_transposed).indptr),
            p_transposed,
            q: SparseNodes::new(transfer.border(), |v| v as f32),
            q_transposed: padded_columns(&to_f32(&transpose(transfer.border_left()), 1.0)),
            blocks: operator.node_blocks().clone(),
            border_blocks: operator.border_blocks().clone(),
            vectors: Vectors::new(n, m),
            next: vec![[0.0; 4]; n],
        }
    }

    /// Smoothing steps on each side of the coarse correction.
    pub fn steps(&self) -> usize {
        self.factors.len()
    }

    /// Bytes of one smoothing step: the matrix, three vectors, the diagonal.
    pub fn sweep_bytes(&self) -> usize {
        let n = self.next.len();
        8 * self.k.rows().entries_len() + n * (8 + 48 + 4)
    }

    /// Bytes of a residual and its restriction.
    pub fn restriction_bytes(&self) -> usize {
        let (n, nc) = (self.next.len(), self.p_transposed.rows());
        let residual = 8 * self.k.rows().entries_len() + n * (8 + 48);
        residual + 8 * self.p.nnz() + 16 * n + 24 * nc
    }

    /// Bytes of a prolongation.
    pub fn prolongation_bytes(&self) -> usize {
        let (n, nc) = (self.next.len(), self.p_transposed.rows());
        8 * self.p.nnz() + n * (8 + 32) + 16 * nc
    }

    /// One smoothing step on whatever the vectors hold.
    pub fn sweep_once(&mut self) {
        let Vectors { b, x, .. } = &self.vectors;
        let (blocks, scale, next) = (&self.blocks, &self.inverse_diagonal, &mut self.next);
        sweep(&self.k, blocks, scale, self.factors[0], b, x, next);
    }

    /// The sweeps before the coarse correction, from a zero guess: the first needs no pass over the matrix.
    pub fn smooth_from_zero(&mut self) {
        let (first, rest) = (self.factors[0], &self.factors[1..]);
        let Vectors { b, x, .. } = &mut self.vectors;
        let inverse_diagonal = &self.inverse_diagonal;
        self.blocks.for_each(x, &|i, xi| {
            *xi = b[i].map(|bi| first * inverse_diagonal[i] * bi);
        });
        for &factor in rest {
            sweep(
                &self.k,
                &self.blocks,
                inverse_diagonal,
                factor,
                b,
                x,
                &mut self.next,
            );
            swap(x, &mut self.next);
        }
    }

    /// The sweeps after the coarse correction.
    pub fn smooth(&mut self) {
        let Vectors { b, x, border_x, .. } = &mut self.vectors;
        // border unknowns do not change in the sweeps
        self.c
            .for_each(0..b.len(), border_x, |i, d, a| b[i][d] -= a);
        for &factor in &self.factors {
            sweep(
                &self.k,
                &self.blocks,
                &self.inverse_diagonal,
                factor,
                b,
                x,
                &mut self.next,
            );
            swap(x, &mut self.next);
        }
    }

    /// The residual of `x` with zero border, restricted: `b_c = P^T r`, `border b_c = r_v + Q_l^T r`. One pass.
    pub fn restrict(&mut self, coarse: &mut Vectors) {
        let Vectors { b, x, border_b, .. } = &self.vectors;
        let (k, p) = (self.k.rows(), Rows::of(&self.p_transposed));
        self.blocks.for_each(&mut self.next, &|i, ri| {
            let a = padded_row(k, i, x);
            for d in 0..4 {
                ri[d] = b[i][d] - a[d];
            }
        });
        let r = &self.next;
        self.coarse_blocks
            .for_each(&mut coarse.b, &|i, bi| *bi = padded_row(p, i, r));
        let (left, q) = (Rows::of(&self.border_rows), Rows::of(&self.q_transposed));
        self.border_blocks.for_each(&mut coarse.border_b, &|c, bc| {
            let known = long_row(left, c, x.as_flattened());
            let motion = long_row(q, c, r.as_flattened());
            *bc = (f64::from(border_b[c]) - known + motion) as f32;
        });
    }

    /// `x <- x + P x_c + Q v_c`, `v <- v_c`.
    pub fn prolong(&mut self, coarse: &Vectors) {
        let p = Rows::of(&self.p);
        let Vectors { x, border_x, .. } = &mut self.vectors;
        self.blocks.for_each(x, &|i, xi| {
            let a = padded_row(p, i, &coarse.x);
            for d in 0..4 {
                xi[d] += a[d];
            }
        });
        border_x.copy_from_slice(&coarse.border_x);
        self.q
            .for_each(0..x.len(), border_x, |i, d, a| x[i][d] += a);
    }
}

/// `x' = x + w D^-1 (b - K x)`: one pass.
fn sweep(
    k: &Rounded,
    blocks: &RowBlocks,
    inverse_diagonal: &[f32],
    factor: f32,
    b: &[Padded],
    x: &[Padded],
    next: &mut [Padded],
) {
    let k = k.rows();
    blocks.for_each(next, &|i, yi| {
        let a = padded_row(k, i, x);
        let step = factor * inverse_diagonal[i];
        for d in 0..4 {
            yi[d] = x[i][d] + step * (b[i][d] - a[d]);
        }
    });
}

/// Columns `3 node + d` become `4 node + d`.
fn padded_columns(rows: &Csr32) -> Csr32 {
    let columns = rows.indices().iter().map(|&c| c / 3 * 4 + c % 3).collect();
    Csr32::new(
        (rows.rows(), rows.cols() / 3 * 4),
        rows.indptr().into_raw_storage().to_vec(),
        columns,
        rows.data().to_vec(),
    )
}
