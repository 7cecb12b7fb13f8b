//! The exact solver on the coarsest level.

use nalgebra::DVector;

use super::{BorderInverse, vectors::Vectors};
use crate::csr::Rows;
use crate::direct::{Definiteness, Graph, Precision, SchurFactor, SparseFactor};
use crate::node_kernel::long_row;
use crate::{Bordered, Csr, LinalgError, LinearOperator};

/// `[K (x) I3, C; C_l^T, M]` solved by one factor of `K` and a dense, pivoted Schur complement of the border.
///
/// Where components are held each has a factor of its own, of `K` with what is held left out.
///
/// `S = M - C_l^T W`, `W = (K (x) I3)^-1 C`; `v = S^-1 (b_v - C_l^T t)`, `u = t - W v`, `t = (K (x) I3)^-1 b_u`. Only `K` need be
/// definite: pivoting admits borders with constraints and nonsymmetric ones.
pub(super) struct CoarseSolver {
    /// One for all components, or one for each.
    factors: Vec<SparseFactor>,
    border_rows: Csr,
    /// `W`, column by column, each interleaved by node.
    lifted: Vec<f64>,
    schur: SchurFactor,
    /// Whether what `solve` applies is symmetric positive definite.
    pub definite: bool,
    pub vectors: Vectors,
    components: Vec<f64>,
    interleaved: Vec<f64>,
    border: DVector<f64>,
}

impl CoarseSolver {
    /// Factorises `operator` times `unit`.
    pub fn new(
        operator: &Bordered,
        unit: f64,
        inverse: BorderInverse,
    ) -> Result<Self, LinalgError> {
        let (n, m) = (operator.nodes(), operator.border_len());
        let k = operator.stiffness().map(|v| v * unit);
        let order = Graph::new(&adjacency(&k), &vec![1; n])?.nested_dissection()?;
        let factorise = |k: &Csr, columns| {
            let (definite, double) = (Definiteness::Positive, Precision::Double);
            SparseFactor::new(
                "coarsest stiffness matrix",
                k,
                &order,
                definite,
                double,
                columns,
            )
        };
        let constrained = operator.constrained_dofs();
        let mut factors = if constrained.is_empty() {
            vec![factorise(&k, 3)?]
        } else {
            let factors = (0..3).map(|d| factorise(&constrained.pinned(&k, d), 1));
            factors.collect::<Result<_, _>>()?
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
        let absolute = symmetric && inverse == BorderInverse::Absolute;
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

    /// Solves for the right-hand sides in `vectors`, one by one: the factor is small, and kept near.
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
fn solve_components(factors: &mut [SparseFactor], columns: &mut [f64]) {
    let each = columns.len() / factors.len();
    for (factor, part) in factors
        .iter_mut()
        .zip(columns.chunks_exact_mut(each.max(1)))
    {
        factor.solve_in_place(part);
    }
}

/// Neighbours of each row, without the diagonal.
fn adjacency(k: &Csr) -> Vec<Vec<u32>> {
    let rows = Rows::of(k);
    (0..k.rows())
        .map(|i| {
            rows.row(i)
                .map(|(j, _)| j as u32)
                .filter(|&j| j as usize != i)
                .collect()
        })
        .collect()
}

/// From one triple a node to three columns.
fn separate(interleaved: &[f64], components: &mut [f64]) {
    let n = components.len() / 3;
    for (i, triple) in interleaved.as_chunks::<3>().0.iter().enumerate() {
        for d in 0..3 {
            components[n * d + i] = triple[d];
        }
    }
}

/// From three columns to one triple a node.
fn interleave(components: &[f64], interleaved: &mut [f64]) {
    let n = components.len() / 3;
    for (i, triple) in interleaved.as_chunks_mut::<3>().0.iter_mut().enumerate() {
        for d in 0..3 {
            triple[d] = components[n * d + i];
        }
    }
}
