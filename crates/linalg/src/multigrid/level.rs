//! One level of the cycle: its smoother and its transfer, in single precision.

use super::vectors::Vectors;
use crate::chebyshev::quadratic_smoother;
use crate::csr::{Csr32, Rows, to_f32, transpose};
use crate::node_kernel::{NodeRows, long_row};
use crate::row_blocks::RowBlocks;
use crate::{Bordered, Transfer};

/// A level above the coarsest. The smoother moves nodes only; border unknowns are the coarsest level's business.
pub(super) struct Level {
    k: Csr32,
    c: Csr32,
    /// `C_l^T`.
    border_rows: Csr32,
    inverse_diagonal: Vec<f32>,
    c0: f32,
    c1: f32,
    p: Csr32,
    p_transposed: Csr32,
    q: Csr32,
    q_transposed: Csr32,
    blocks: RowBlocks,
    coarse_blocks: RowBlocks,
    border_blocks: RowBlocks,
    pub vectors: Vectors,
    z: Vec<[f32; 3]>,
    no_border: Vec<f32>,
}

impl Level {
    /// Rounds `operator` times `unit` and `transfer`; `upper` bounds the spectrum of `D^-1 K`.
    pub fn new(
        operator: &Bordered,
        transfer: &Transfer,
        diagonal: &[f64],
        unit: f64,
        upper: f64,
        range: f64,
    ) -> Self {
        let (n, m) = (operator.nodes(), operator.border_len());
        let (c0, c1) = quadratic_smoother(upper, range);
        let p_transposed = to_f32(&transpose(transfer.nodes()), 1.0);
        Level {
            k: to_f32(operator.stiffness(), unit),
            c: to_f32(operator.border(), unit),
            border_rows: to_f32(operator.border_rows(), unit),
            inverse_diagonal: diagonal.iter().map(|d| (d * unit).recip() as f32).collect(),
            c0: c0 as f32,
            c1: c1 as f32,
            p: to_f32(transfer.nodes(), 1.0),
            coarse_blocks: RowBlocks::new(Rows::of(&p_transposed).indptr),
            p_transposed,
            q: to_f32(transfer.border(), 1.0),
            q_transposed: to_f32(&transpose(transfer.border_left()), 1.0),
            blocks: operator.node_blocks().clone(),
            border_blocks: operator.border_blocks().clone(),
            vectors: Vectors::new(n, m),
            z: vec![[0.0; 3]; n],
            no_border: vec![0.0; m],
        }
    }

    /// `x <- (c0 - c1 D^-1 K) D^-1 b`: the smoother from a zero guess. One pass.
    pub fn smooth_from_zero(&mut self) {
        let Vectors { b, x, .. } = &mut self.vectors;
        let inverse_diagonal = &self.inverse_diagonal;
        self.blocks.for_each(&mut self.z, &|i, zi| {
            *zi = b[i].map(|bi| inverse_diagonal[i] * bi);
        });
        let (z, c0, c1) = (&self.z, self.c0, self.c1);
        let rows = NodeRows {
            k: Rows::of(&self.k),
            c: Rows::of(&self.c),
            blocks: &self.blocks,
        };
        rows.for_each(z, &self.no_border, x, |i, a, xi| {
            for d in 0..3 {
                xi[d] = c0 * z[i][d] - c1 * inverse_diagonal[i] * a[d];
            }
        });
    }

    /// `x <- x + (c0 - c1 D^-1 K) D^-1 (b - K x - C v)`. Two passes.
    pub fn smooth(&mut self) {
        let Vectors { b, x, border_x, .. } = &mut self.vectors;
        let (inverse_diagonal, c0, c1) = (&self.inverse_diagonal, self.c0, self.c1);
        let rows = NodeRows {
            k: Rows::of(&self.k),
            c: Rows::of(&self.c),
            blocks: &self.blocks,
        };
        rows.for_each(x, border_x, &mut self.z, |i, a, zi| {
            for d in 0..3 {
                zi[d] = inverse_diagonal[i] * (b[i][d] - a[d]);
            }
        });
        let z = &self.z;
        rows.for_each(z, &self.no_border, x, |i, a, xi| {
            for d in 0..3 {
                xi[d] += c0 * z[i][d] - c1 * inverse_diagonal[i] * a[d];
            }
        });
    }

    /// The residual of `x` with zero border, restricted: `b_c = P^T r`, `border b_c = r_v + Q_l^T r`. One pass.
    pub fn restrict(&mut self, coarse: &mut Vectors) {
        let Vectors { b, x, border_b, .. } = &self.vectors;
        let rows = NodeRows {
            k: Rows::of(&self.k),
            c: Rows::of(&self.c),
            blocks: &self.blocks,
        };
        rows.for_each(x, &self.no_border, &mut self.z, |i, a, ri| {
            for d in 0..3 {
                ri[d] = b[i][d] - a[d];
            }
        });
        let r = &self.z;
        let p = Rows::of(&self.p_transposed);
        self.coarse_blocks.for_each(&mut coarse.b, &|i, bi| {
            let mut sum = [0.0; 3];
            for (j, w) in p.row(i) {
                for d in 0..3 {
                    sum[d] += w * r[j][d];
                }
            }
            *bi = sum;
        });
        let (left, q) = (Rows::of(&self.border_rows), Rows::of(&self.q_transposed));
        self.border_blocks.for_each(&mut coarse.border_b, &|c, bc| {
            let known = long_row(left, c, x.as_flattened());
            let motion = long_row(q, c, r.as_flattened());
            *bc = (f64::from(border_b[c]) - known + motion) as f32;
        });
    }

    /// `x <- x + P x_c + Q v_c`, `v <- v_c`.
    pub fn prolong(&mut self, coarse: &Vectors) {
        let (p, q) = (Rows::of(&self.p), Rows::of(&self.q));
        self.blocks.for_each(&mut self.vectors.x, &|i, xi| {
            for (j, w) in p.row(i) {
                for d in 0..3 {
                    xi[d] += w * coarse.x[j][d];
                }
            }
            if q.indptr[3 * i] < q.indptr[3 * i + 3] {
                for d in 0..3 {
                    for (c, w) in q.row(3 * i + d) {
                        xi[d] += w * coarse.border_x[c];
                    }
                }
            }
        });
        self.vectors.border_x.copy_from_slice(&coarse.border_x);
    }
}
