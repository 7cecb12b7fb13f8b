//! Prolongation of a bordered operator, and Galerkin products with it.

use std::borrow::Cow;

use nalgebra::DMatrix;

use crate::constrained_dofs::ConstrainedDofs;
use crate::csr::{Rows, check_finite, check_shape, empty, into_rows};
use crate::product::{build_rows, kron3_multiply_add, multiply};
use crate::transpose::transpose;
use crate::{Bordered, Csr, LinalgError};

/// The prolongation `u_fine = (P (x) I3) u_coarse + Q v`, `v_fine = v_coarse` of nodes and border.
///
/// From P1 to P2 elements `P` interpolates: 1 at vertices, 1/2 at both ends of an edge. `Q`
/// contains the motion that border dofs impose on fine nodes only: with a rigid body in the border,
/// half the rigid motion at a free midside node whose edge has one end on the body.
#[derive(Debug, Clone)]
pub struct Prolongation {
    nodes: Csr,
    border: Csr,
    border_left: Option<Csr>,
}

impl Prolongation {
    /// Prolongation from `nodes`, P (n x n_coarse), and `border`, Q (3n x m).
    ///
    /// # Errors
    /// [`LinalgError::Shape`], [`LinalgError::NotFinite`].
    pub fn new(nodes: Csr, border: Csr) -> Result<Self, LinalgError> {
        let expected = (3 * nodes.rows(), border.cols());
        check_shape("border Q of the prolongation", border.shape(), expected)?;
        check_finite("prolongation P", nodes.data())?;
        check_finite("border Q of the prolongation", border.data())?;
        Ok(Prolongation::from_parts(
            into_rows(nodes),
            into_rows(border),
            None,
        ))
    }

    /// Prolongation from `nodes`, P (n x n_coarse), of an operator without a border.
    ///
    /// For [`ScalarMultigrid::with_prolongation`](crate::ScalarMultigrid::with_prolongation).
    ///
    /// # Errors
    /// [`LinalgError::NotFinite`].
    pub fn scalar(nodes: Csr) -> Result<Self, LinalgError> {
        let border = empty(3 * nodes.rows(), 0);
        Self::new(nodes, border)
    }

    /// Sets other border columns `Q_l` (3n x m) in the restriction `r_v + Q_l^T r`.
    ///
    /// Needed if a border row is not the equation tested with the motion of its column, for example
    /// a row of constraints. The residuals of such rows must not be mixed with those of the nodes.
    ///
    /// # Errors
    /// [`LinalgError::Shape`], [`LinalgError::NotFinite`].
    pub fn with_left_border(mut self, border_left: Csr) -> Result<Self, LinalgError> {
        check_shape(
            "left border Q_l of the prolongation",
            border_left.shape(),
            self.border.shape(),
        )?;
        check_finite("left border Q_l of the prolongation", border_left.data())?;
        self.border_left = Some(into_rows(border_left));
        Ok(self)
    }

    /// Assembles a prolongation from matrices that were checked before.
    pub(crate) fn from_parts(nodes: Csr, border: Csr, border_left: Option<Csr>) -> Self {
        Prolongation {
            nodes,
            border,
            border_left,
        }
    }

    /// The scalar prolongation `P`, n x n_coarse.
    pub fn nodes(&self) -> &Csr {
        &self.nodes
    }

    /// The border columns `Q`, 3n x m.
    pub fn border(&self) -> &Csr {
        &self.border
    }

    /// The border columns of the restriction `Q_l`, 3n x m; `Q` unless given.
    pub fn border_left(&self) -> &Csr {
        self.border_left.as_ref().unwrap_or(&self.border)
    }

    /// Removes the border motions of constrained dofs.
    pub(crate) fn constrain(&self, constrained: &ConstrainedDofs) -> Cow<'_, Self> {
        if constrained.is_empty() {
            return Cow::Borrowed(self);
        }
        Cow::Owned(Prolongation {
            nodes: self.nodes.clone(),
            border: constrained.drop_rows(self.border.clone()),
            border_left: self
                .border_left
                .clone()
                .map(|left| constrained.drop_rows(left)),
        })
    }

    pub(crate) fn check_against(&self, fine: &Bordered) -> Result<(), LinalgError> {
        let (n, m) = (fine.nodes(), fine.border_len());
        let expected = (n, self.nodes.cols());
        check_shape("prolongation P", self.nodes.shape(), expected)?;
        let expected = (3 * n, m);
        check_shape(
            "border Q of the prolongation",
            self.border.shape(),
            expected,
        )
    }

    /// The Galerkin operator `[P Q_l; 0 I]^T [K C; C_l^T M] [P Q; 0 I]`.
    ///
    /// `K` and `P` stand for `K (x) I3` and `P (x) I3`.
    ///
    /// ```text
    /// K_c  = P^T K P               C_c = P^T (C + K Q)
    /// C_lc = P^T (C_l + K Q_l)     M_c = M + Q_l^T (C + K Q) + C_l^T Q
    /// ```
    ///
    /// `k_coarse` replaces the first product if it is known, as on straight-sided meshes.
    pub(crate) fn galerkin(&self, fine: &Bordered, k_coarse: Option<Csr>) -> Bordered {
        let k = fine.stiffness();
        let restrict = transpose(&self.nodes);
        let k_coarse = k_coarse.unwrap_or_else(|| multiply(&restrict, &multiply(k, &self.nodes)));
        let constrained = fine.constrained_dofs();
        let kq_plus_c = constrained.drop_rows(kron3_multiply_add(k, &self.border, fine.border()));
        let (q_left, c_left) = (
            self.border_left(),
            fine.border_left().unwrap_or(fine.border()),
        );
        let left = (fine.border_left().is_some() || self.border_left.is_some())
            .then(|| constrained.drop_rows(kron3_multiply_add(k, q_left, c_left)))
            .map(|left| restrict3(&restrict, &left));
        let mut corner = fine.corner().clone();
        add_transposed_product(q_left, &kq_plus_c, &mut corner);
        add_transposed_product(c_left, &self.border, &mut corner);
        Bordered::from_parts(k_coarse, restrict3(&restrict, &kq_plus_c), left, corner)
            .constrain(constrained.coarse(&self.nodes))
    }
}

/// `(R (x) I3) X` for `X` with three interleaved rows per node.
fn restrict3(restrict: &Csr, x: &Csr) -> Csr {
    let (r, x_rows) = (Rows::new(restrict), Rows::new(x));
    build_rows(3 * restrict.rows(), x.cols(), |i, row| {
        for (node, w) in r.row(i / 3) {
            for (c, v) in x_rows.row(3 * node + i % 3) {
                row.add(c, w * v);
            }
        }
    })
}

/// `M <- M + X^T Y`, summed row by row in order.
fn add_transposed_product(x: &Csr, y: &Csr, m: &mut DMatrix<f64>) {
    let (x_rows, y_rows) = (Rows::new(x), Rows::new(y));
    for i in 0..x.rows() {
        for (c, xv) in x_rows.row(i) {
            for (d, yv) in y_rows.row(i) {
                m[(c, d)] += xv * yv;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn sparse(matrix: &DMatrix<f64>) -> Csr {
        build_rows(matrix.nrows(), matrix.ncols(), |i, row| {
            for j in (0..matrix.ncols()).filter(|&j| matrix[(i, j)] != 0.0) {
                row.add(j, matrix[(i, j)]);
            }
        })
    }

    fn dense(matrix: &Csr) -> DMatrix<f64> {
        let rows = Rows::new(matrix);
        let mut all = DMatrix::zeros(matrix.rows(), matrix.cols());
        for i in 0..matrix.rows() {
            rows.row(i).for_each(|(j, v)| all[(i, j)] = v);
        }
        all
    }

    proptest! {
        /// Compares every block of the Galerkin operator with `T^T A T` of dense matrices.
        #[test]
        fn galerkin_matches_dense(
            n in 1..9usize, nc in 1..5usize, m in 0..5usize,
            pool in proptest::collection::vec(prop_oneof![Just(0.0), -1.0..1.0], 499),
            nonsymmetric in any::<bool>(),
        ) {
            let mut next = pool.iter().copied().cycle();
            let mut random = |r, c| DMatrix::from_fn(r, c, |_, _| next.next().unwrap_or(0.0));
            let k = random(n, n);
            let k = &k + k.transpose() + DMatrix::identity(n, n) * (2.0 * n as f64 + 1.0);
            let (c, left, corner) = (random(3 * n, m), random(3 * n, m), random(m, m));
            let (p, q) = (random(n, nc), random(3 * n, m));
            let left = if nonsymmetric { left } else { c.clone() };
            let fine = Bordered::new(
                sparse(&k), sparse(&c), nonsymmetric.then(|| sparse(&left)), corner.clone(),
            ).expect("sound");
            let q_left = if nonsymmetric { random(3 * n, m) } else { q.clone() };
            let mut prolongation = Prolongation::new(sparse(&p), sparse(&q)).expect("sound");
            if nonsymmetric {
                prolongation = prolongation.with_left_border(sparse(&q_left)).expect("sound");
            }
            let coarse = prolongation.galerkin(&fine, None);

            let three = DMatrix::identity(3, 3);
            let (k3, p3) = (k.kronecker(&three), p.kronecker(&three));
            let stiffness = p.transpose() * &k * &p;
            let border = p3.transpose() * (&c + &k3 * &q);
            let border_left = p3.transpose() * (&left + &k3 * &q_left);
            let corner = corner + q_left.transpose() * (&c + &k3 * &q) + left.transpose() * &q;
            let close = |a: &DMatrix<f64>, b: &DMatrix<f64>| a.is_empty() || (a - b).amax() < 1e-11;
            prop_assert!(close(&dense(coarse.stiffness()), &stiffness));
            prop_assert!(close(&dense(coarse.border()), &border));
            prop_assert!(close(coarse.corner(), &corner));
            let found = dense(coarse.border_left().unwrap_or(coarse.border()));
            prop_assert!(close(&found, &border_left));
        }
    }
}
