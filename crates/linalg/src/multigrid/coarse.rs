//! The exact solver on the coarsest level.

use std::borrow::Cow;
use std::iter;

use nalgebra::DVector;

use super::coarse_factor::CoarseFactor;
use super::{BorderInverse, MultigridParams, vectors::Vectors};
use crate::csr::Rows;
use crate::node_kernel::long_row;
use crate::schur::SchurFactor;
use crate::{Bordered, Csr, LinalgError, LinearOperator};

/// Solves with `[K (x) I3, C; C_l^T, M]`: factors of `K`, and a Schur complement of the border.
///
/// The Schur complement is dense and factorised with pivoting.
///
/// If components are constrained, each component has its own factor of `K`, without its constrained
/// dofs.
///
/// ```text
/// W = (K (x) I3)^-1 C       S = M - C_l^T W
/// t = (K (x) I3)^-1 b_u     v = S^-1 (b_v - C_l^T t)     u = t - W v
/// ```
///
/// Only `K` must be definite: pivoting admits borders with constraints and nonsymmetric ones.
pub(super) struct CoarseSolver {
    /// One factor for all components, or one for each.
    factors: Vec<CoarseFactor>,
    border_rows: Csr,
    /// `W`, column by column, each interleaved by node.
    lifted: Vec<f64>,
    schur: SchurFactor,
    /// Whether the map computed by `solve` is symmetric positive definite.
    pub definite: bool,
    pub vectors: Vectors,
    components: Vec<f64>,
    interleaved: Vec<f64>,
    border: DVector<f64>,
}

impl CoarseSolver {
    /// Factorises `unit` times `operator`.
    pub fn new(
        operator: &Bordered,
        unit: f64,
        params: &MultigridParams,
    ) -> Result<Self, LinalgError> {
        let (n, m) = (operator.nodes(), operator.border_len());
        let k = operator.stiffness().map(|v| v * unit);
        let k = shift_diagonal(k, params.coarsest_shift);
        let constrained = operator.constrained_dofs();
        let mut factors = if constrained.is_empty() {
            CoarseFactor::all(&k, iter::once(Cow::Borrowed(&k)), 3)?
        } else {
            let pinned = (0..3).map(|d| Cow::Owned(constrained.pinned(&k, d)));
            CoarseFactor::all(&k, pinned, 1)?
        };
        let border_rows = operator.border_rows().map(|v| v * unit);
        let mut lifted = vec![0.0; 3 * n * m];
        let border = Rows::of(operator.border());
        for i in 0..3 * n {
            for (c, v) in border.row(i) {
                lifted[3 * n * c + i] = v * unit;
            }
        }
        let mut components = vec![0.0; 3 * n];
        for column in lifted.chunks_exact_mut((3 * n).max(1)) {
            separate(column, &mut components);
            solve_components(&mut factors, &mut components);
            interleave(&components, column);
        }
        let mut schur = operator.corner() * unit;
        for d in 0..m {
            let column = &lifted[3 * n * d..3 * n * (d + 1)];
            for c in 0..m {
                let [product] = long_row(Rows::of(&border_rows), c, |j| [column[j]]);
                schur[(c, d)] -= product;
            }
        }
        let symmetric = operator.is_symmetric();
        let absolute = symmetric && params.border == BorderInverse::Absolute;
        let definite = absolute || symmetric && schur.clone().cholesky().is_some();
        let schur = if absolute {
            SchurFactor::absolute(schur)?
        } else {
            SchurFactor::new(schur)?
        };
        Ok(CoarseSolver {
            factors,
            border_rows,
            lifted,
            schur,
            definite,
            vectors: Vectors::new(n, m, constrained.clone()),
            components,
            interleaved: vec![0.0; 3 * n],
            border: DVector::zeros(m),
        })
    }

    /// Solves for the right-hand sides in `vectors`.
    ///
    /// One by one: the factor is small and stays in the cache.
    pub fn solve<const S: usize>(&mut self) {
        for s in 0..S {
            self.solve_column::<S>(s);
        }
    }

    fn solve_column<const S: usize>(&mut self, s: usize) {
        let size = self.interleaved.len();
        let vectors = self.vectors.columns::<S>();
        let interleaved = self.interleaved.as_chunks_mut::<3>().0;
        for (t, b) in interleaved.iter_mut().zip(vectors.b) {
            let b = b[s];
            *t = [b[0], b[1], b[2]].map(f64::from);
        }
        separate(&self.interleaved, &mut self.components);
        solve_components(&mut self.factors, &mut self.components);
        interleave(&self.components, &mut self.interleaved);
        for (c, v) in self.border.iter_mut().enumerate() {
            let [known] = long_row(Rows::of(&self.border_rows), c, |j| [self.interleaved[j]]);
            *v = f64::from(vectors.border_b[c][s]) - known;
        }
        self.schur.solve(&mut self.border);
        for (c, v) in self.border.iter().enumerate() {
            vectors.border_x[c][s] = *v as f32;
            let column = &self.lifted[size * c..size * (c + 1)];
            for (t, w) in self.interleaved.iter_mut().zip(column) {
                *t -= w * v;
            }
        }
        for (x, t) in vectors
            .x
            .iter_mut()
            .zip(self.interleaved.as_chunks::<3>().0)
        {
            x[s] = [t[0] as f32, t[1] as f32, t[2] as f32, 0.0];
        }
    }
}

/// `(K (x) I3)^-1` of three columns, one after the other.
fn solve_components(factors: &mut [CoarseFactor], columns: &mut [f64]) {
    let each = columns.len() / factors.len();
    for (factor, part) in factors
        .iter_mut()
        .zip(columns.chunks_exact_mut(each.max(1)))
    {
        factor.solve_in_place(part);
    }
}

/// `K + shift diag(K)`.
fn shift_diagonal(mut k: Csr, shift: f64) -> Csr {
    if shift > 0.0 {
        for (i, mut row) in k.outer_iterator_mut().enumerate() {
            for (j, value) in row.iter_mut() {
                if i == j {
                    *value += shift * *value;
                }
            }
        }
    }
    k
}

/// Converts one triple per node to three columns.
fn separate(interleaved: &[f64], components: &mut [f64]) {
    let n = components.len() / 3;
    for (i, triple) in interleaved.as_chunks::<3>().0.iter().enumerate() {
        for d in 0..3 {
            components[n * d + i] = triple[d];
        }
    }
}

/// Converts three columns to one triple per node.
fn interleave(components: &[f64], interleaved: &mut [f64]) {
    let n = components.len() / 3;
    for (i, triple) in interleaved.as_chunks_mut::<3>().0.iter_mut().enumerate() {
        for d in 0..3 {
            triple[d] = components[n * d + i];
        }
    }
}
