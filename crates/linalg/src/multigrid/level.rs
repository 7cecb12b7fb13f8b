//! One level of the cycle in single precision: its vectors, the smoother and the prolongation.

use std::array::from_fn;

use crate::constrained_dofs::ConstrainedDofs;
use crate::csr::{Csr32, Rounded, Rows, empty, to_blocks, to_f32};
use crate::node_kernel::{Blocks32, NodeMatrix, NodeRows, Padded, SparseNodes, long_row};
use crate::row_blocks::RowBlocks;
use crate::transpose::transpose;
use crate::{Bordered, Csr, Prolongation};

use super::incomplete_lu::IncompleteLu;

/// How the matrices of a level act on the three components of a node.
pub(super) trait Components {
    /// The matrix of the level.
    type Matrix: NodeMatrix;
    /// The prolongation and its transpose.
    type Transfer: NodeMatrix;
    /// The reciprocal diagonal of the smoother at a node.
    type Damping: Copy + Sync;

    /// `factor` times the reciprocal diagonal, for each component.
    fn step(factor: f32, damping: Self::Damping) -> Padded;
}

/// One scalar matrix for all three components.
pub(super) struct Alike;

impl Components for Alike {
    type Matrix = Rounded;
    type Transfer = Csr32;
    type Damping = f32;

    #[inline(always)]
    fn step(factor: f32, damping: f32) -> Padded {
        [factor * damping; 4]
    }
}

/// Blocks of 3 x 3.
pub(super) struct Coupled;

impl Components for Coupled {
    type Matrix = Blocks32;
    type Transfer = Blocks32;
    type Damping = Padded;

    #[inline(always)]
    fn step(factor: f32, damping: Padded) -> Padded {
        damping.map(|damping| factor * damping)
    }
}

/// A level above the coarsest.
///
/// The smoother changes nodes only; the coarsest level solves for border dofs.
pub(super) struct Level<C: Components> {
    k: C::Matrix,
    c: SparseNodes<f32>,
    /// `C_l^T`, with columns numbered in padded nodes.
    border_rows: Csr32,
    inverse_diagonal: Vec<C::Damping>,
    /// The smoother in place of Jacobi steps, one step before and after the coarse correction.
    factors_of_convection: Option<IncompleteLu>,
    /// Relaxation factors of the smoothing steps, the same before and after the coarse correction.
    pub factors: Vec<f32>,
    p: C::Transfer,
    p_transposed: C::Transfer,
    q: SparseNodes<f32>,
    /// `Q_l^T`, with columns numbered in padded nodes.
    q_transposed: Csr32,
    blocks: RowBlocks,
    coarse_blocks: RowBlocks,
    border_blocks: RowBlocks,
    pub vectors: Vectors,
}

impl Level<Alike> {
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
            factors_of_convection: None,
            factors: factors.iter().map(|w| *w as f32).collect(),
            p: to_f32(prolongation.nodes(), 1.0),
            coarse_blocks: RowBlocks::new(Rows::new(&p_transposed).indptr),
            p_transposed,
            q: SparseNodes::new(prolongation.border(), |v| v as f32),
            q_transposed: padded_columns(&to_f32(&transpose(prolongation.border_left()), 1.0)),
            blocks: operator.node_blocks().clone(),
            border_blocks: operator.border_blocks().clone(),
            vectors: Vectors::new(n, m, operator.constrained_dofs().clone()),
        }
    }

    /// The same with a step by these factors in place of Jacobi steps.
    pub fn with_factors(mut self, factors: Option<IncompleteLu>) -> Self {
        self.factors_of_convection = factors;
        self
    }
}

impl Level<Coupled> {
    /// Rounds `unit` times `k` and `prolongation` to f32; three interleaved dofs per node.
    pub fn coupled(
        k: &Csr,
        prolongation: &Csr,
        diagonal: &[f64],
        unit: f64,
        factors: &[f64],
    ) -> Self {
        let n = k.rows() / 3;
        let blocks = |matrix: &Csr, unit: f64| {
            to_blocks(matrix, |block| {
                // stored by columns
                from_fn(|c| {
                    from_fn(|d| {
                        if d < 3 {
                            (block[d][c] * unit) as f32
                        } else {
                            0.0
                        }
                    })
                })
            })
        };
        let (k, p_transposed) = (blocks(k, unit), blocks(&transpose(prolongation), 1.0));
        let reciprocal = |d: &[f64; 3]| {
            let [x, y, z] = d.map(|d| (d * unit).recip() as f32);
            [x, y, z, 0.0]
        };
        Level {
            c: SparseNodes::new(&empty(3 * n, 0), |_| 0.0),
            border_rows: empty(0, 4 * n),
            inverse_diagonal: diagonal.as_chunks().0.iter().map(reciprocal).collect(),
            factors_of_convection: None,
            factors: factors.iter().map(|w| *w as f32).collect(),
            p: blocks(prolongation, 1.0),
            coarse_blocks: RowBlocks::new(Rows::new(&p_transposed).indptr),
            p_transposed,
            q: SparseNodes::new(&empty(3 * n, 0), |_| 0.0),
            q_transposed: empty(0, 4 * n),
            blocks: RowBlocks::new(Rows::new(&k).indptr),
            border_blocks: RowBlocks::new(&[0]),
            vectors: Vectors::new(n, 0, ConstrainedDofs::default()),
            k,
        }
    }
}

impl<C: Components> Level<C> {
    /// One smoothing step, `x' = x + w D^-1 (b - K x)`: one pass.
    pub fn sweep<const S: usize>(&mut self, factor: f32) {
        let (k, inverse_diagonal) = (self.k.rows(), &self.inverse_diagonal);
        let Columns {
            b,
            x,
            next,
            constrained,
            ..
        } = self.vectors.columns::<S>();
        self.blocks.for_each(&mut *next, &|i, next| {
            let a = k.padded_row(i, x);
            let step = C::step(factor, inverse_diagonal[i]);
            for s in 0..S {
                for d in 0..4 {
                    next[s][d] = x[i][s][d] + step[d] * (b[i][s][d] - a[s][d]);
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
        if let Some(factors) = &self.factors_of_convection {
            let Columns { b, x, .. } = self.vectors.columns::<S>();
            x.copy_from_slice(b);
            return factors.solve(x);
        }
        let (first, inverse_diagonal) = (self.factors[0], &self.inverse_diagonal);
        let Columns { b, x, .. } = self.vectors.columns::<S>();
        self.blocks.for_each(x, &|i, xi| {
            let step = C::step(first, inverse_diagonal[i]);
            *xi = b[i].map(|b| from_fn(|d| step[d] * b[d]));
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
        if self.factors_of_convection.is_some() {
            return self.step_by_factors::<S>();
        }
        for sweep in 0..self.factors.len() {
            self.sweep::<S>(self.factors[sweep]);
        }
    }

    /// `x' = x + (L U)^-1 (b - K x)`.
    fn step_by_factors<const S: usize>(&mut self) {
        let Some(factors) = &self.factors_of_convection else {
            return;
        };
        let Columns { b, x, next, .. } = self.vectors.columns::<S>();
        let k = self.k.rows();
        self.blocks.for_each(&mut *next, &|i, r| {
            let a = k.padded_row(i, x);
            for s in 0..S {
                for d in 0..4 {
                    r[s][d] = b[i][s][d] - a[s][d];
                }
            }
        });
        factors.solve(next);
        self.blocks.for_each(x, &|i, x| {
            for s in 0..S {
                for d in 0..4 {
                    x[s][d] += next[i][s][d];
                }
            }
        });
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
        let (k, p) = (self.k.rows(), self.p_transposed.rows());
        self.blocks.for_each(r, &|i, ri| {
            let a = k.padded_row(i, x);
            for s in 0..S {
                for d in 0..4 {
                    ri[s][d] = b[i][s][d] - a[s][d];
                }
            }
        });
        self.coarse_blocks
            .for_each(&mut *coarse.b, &|i, bi| *bi = p.padded_row(i, r));
        coarse.constrained.clear_columns(coarse.b);
        let (left, q) = (Rows::new(&self.border_rows), Rows::new(&self.q_transposed));
        self.border_blocks.for_each(coarse.border_b, &|c, bc| {
            let known = long_row(left, c, |j| x[j / 4].map(|x| x[j % 4]));
            let motion = long_row(q, c, |j| r[j / 4].map(|r| r[j % 4]));
            *bc = from_fn(|s| (f64::from(border_b[c][s]) - known[s] + motion[s]) as f32);
        });
    }

    /// `x <- x + P x_c + Q v_c`, `v <- v_c`.
    pub fn prolong<const S: usize>(&mut self, coarse: &mut Vectors) {
        let p = self.p.rows();
        let Columns { x, border_x, .. } = self.vectors.columns::<S>();
        let coarse = coarse.columns::<S>();
        self.blocks.for_each(x, &|i, xi| {
            let a = p.padded_row(i, coarse.x);
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

/// The vectors `b` and `x` of one level, nodes and border, in the precision of the cycle.
///
/// The `S` columns of a node or border dof are adjacent in memory.
pub(super) struct Vectors {
    nodes: usize,
    border: usize,
    b: Vec<Padded>,
    x: Vec<Padded>,
    /// The next `x` of a smoothing step, or a residual.
    next: Vec<Padded>,
    border_b: Vec<f32>,
    border_x: Vec<f32>,
    /// Components that are zero in `b` and in `x`.
    constrained: ConstrainedDofs,
}

/// [`Vectors`] of `S` columns.
pub(super) struct Columns<'a, const S: usize> {
    pub b: &'a mut [[Padded; S]],
    pub x: &'a mut [[Padded; S]],
    pub next: &'a mut [[Padded; S]],
    pub border_b: &'a mut [[f32; S]],
    pub border_x: &'a mut [[f32; S]],
    pub constrained: &'a ConstrainedDofs,
}

impl Vectors {
    pub fn new(nodes: usize, border: usize, constrained: ConstrainedDofs) -> Self {
        let mut vectors = Vectors {
            nodes,
            border,
            b: Vec::new(),
            x: Vec::new(),
            next: Vec::new(),
            border_b: Vec::new(),
            border_x: Vec::new(),
            constrained,
        };
        vectors.widen(1);
        vectors
    }

    /// Enlarges the buffers for `columns` columns; they never shrink.
    pub fn widen(&mut self, columns: usize) {
        let (nodes, border) = (self.nodes * columns, self.border * columns);
        for nodal in [&mut self.b, &mut self.x, &mut self.next] {
            nodal.resize(nodal.len().max(nodes), [0.0; 4]);
        }
        for border_vector in [&mut self.border_b, &mut self.border_x] {
            border_vector.resize(border_vector.len().max(border), 0.0);
        }
    }

    /// Number of border dofs of the level.
    pub fn border(&self) -> usize {
        self.border
    }

    /// The first `S` columns, for which [`widen`](Vectors::widen) was called.
    pub fn columns<const S: usize>(&mut self) -> Columns<'_, S> {
        let (n, m) = (self.nodes, self.border);
        Columns {
            b: &mut self.b.as_chunks_mut().0[..n],
            x: &mut self.x.as_chunks_mut().0[..n],
            next: &mut self.next.as_chunks_mut().0[..n],
            border_b: &mut self.border_b.as_chunks_mut().0[..m],
            border_x: &mut self.border_x.as_chunks_mut().0[..m],
            constrained: &self.constrained,
        }
    }

    /// Makes the result of a smoothing step the new `x`.
    pub fn advance(&mut self) {
        std::mem::swap(&mut self.x, &mut self.next);
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
