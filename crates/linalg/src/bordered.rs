//! A scalar matrix for three components, bordered by a few dense columns.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::DMatrix;

use crate::columns::{assert_lengths, in_passes, split, split_mut};
use crate::constrained_dofs::ConstrainedDofs;
use crate::csr::{Rows, check_finite, check_shape, empty, into_rows, positive_diagonal};
use crate::node_kernel::{SparseNodes, long_row, node_row};
use crate::row_blocks::RowBlocks;
use crate::transpose::transpose;
use crate::{Csr, LinalgError, LinearOperator};

/// The operator `[K (x) I3, C; C_l^T, M]` on vectors `[nodes: 3n | border: m]`.
///
/// A node has three interleaved components. `K` is a scalar matrix, n x n, symmetric with positive
/// diagonal; `C` is 3n x m and has three rows per node, most of them empty; `M` is m x m. `C_l = C`
/// unless given. With m = 0 it is a scalar matrix applied to three right-hand sides at once.
///
/// Cost of [`apply`](LinearOperator::apply): one pass over `K`; allocates nothing, and is bitwise
/// the same on any number of threads.
///
/// ```
/// use linalg::{Bordered, Csr, LinearOperator};
/// // K = [2 -1; -1 2], three components at once
/// let k = Csr::new((2, 2), vec![0, 2, 4], vec![0, 1, 0, 1], vec![2.0, -1.0, -1.0, 2.0]);
/// let a = Bordered::scalar(k)?;
/// let mut y = [0.0; 6];
/// a.apply(&[1.0, 2.0, 3.0, 0.0, 0.0, 1.0], &mut y);
/// assert_eq!(y, [2.0, 4.0, 5.0, -1.0, -2.0, -1.0]);
/// # Ok::<(), linalg::LinalgError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Bordered {
    k: Arc<Csr>,
    border: Csr,
    border_left: Option<Csr>,
    /// `C_l^T`, so that products gather border rows and never scatter.
    border_rows: Csr,
    border_nodes: SparseNodes<f64>,
    corner: DMatrix<f64>,
    constrained: ConstrainedDofs,
    blocks: RowBlocks,
    border_blocks: RowBlocks,
    stiffness_is_symmetric: bool,
}

impl Bordered {
    /// Assembles the operator after checking shapes, finiteness and a positive diagonal.
    ///
    /// The caller guarantees that `k` is symmetric, or declares that it is not by
    /// [`with_unsymmetric_stiffness`](Self::with_unsymmetric_stiffness).
    ///
    /// # Errors
    /// [`LinalgError::Shape`], [`LinalgError::NotFinite`], [`LinalgError::NotPositive`].
    pub fn new(
        k: Csr,
        border: Csr,
        border_left: Option<Csr>,
        corner: DMatrix<f64>,
    ) -> Result<Self, LinalgError> {
        let (n, m) = (k.rows(), corner.nrows());
        check_shape("stiffness matrix K", k.shape(), (n, n))?;
        check_shape("border corner M", corner.shape(), (m, m))?;
        check_shape("border C", border.shape(), (3 * n, m))?;
        check_finite("stiffness matrix K", k.data())?;
        check_finite("border C", border.data())?;
        check_finite("border corner M", corner.as_slice())?;
        if let Some(left) = &border_left {
            check_shape("left border C_l", left.shape(), (3 * n, m))?;
            check_finite("left border C_l", left.data())?;
        }
        positive_diagonal("stiffness matrix K", &k)?;
        Ok(Self::from_parts(
            into_rows(k),
            into_rows(border),
            border_left.map(into_rows),
            corner,
        ))
    }

    /// The operator `K (x) I3` without a border: one matrix for three right-hand sides.
    ///
    /// # Errors
    /// Those of [`Bordered::new`].
    pub fn scalar(k: Csr) -> Result<Self, LinalgError> {
        let border = empty(3 * k.rows(), 0);
        Self::new(k, border, None, DMatrix::zeros(0, 0))
    }

    /// The operator `K (x) I3` for a matrix with finite values that is shared with others.
    ///
    /// # Errors
    /// [`LinalgError::Shape`], [`LinalgError::NotPositive`].
    pub(crate) fn shared(k: &Arc<Csr>) -> Result<Self, LinalgError> {
        let n = k.rows();
        check_shape("sparse matrix", k.shape(), (n, n))?;
        positive_diagonal("sparse matrix", k)?;
        let corner = DMatrix::zeros(0, 0);
        Ok(Self::from_parts(
            Arc::clone(k),
            empty(3 * n, 0),
            None,
            corner,
        ))
    }

    /// Assembles the operator from blocks that were checked before.
    pub(crate) fn from_parts(
        k: impl Into<Arc<Csr>>,
        border: Csr,
        border_left: Option<Csr>,
        corner: DMatrix<f64>,
    ) -> Self {
        let k = k.into();
        let border_rows = transpose(border_left.as_ref().unwrap_or(&border));
        Bordered {
            blocks: RowBlocks::new(Rows::new(&k).indptr),
            border_blocks: RowBlocks::new(Rows::new(&border_rows).indptr),
            border_nodes: SparseNodes::new(&border, |v| v),
            k,
            border,
            border_left,
            border_rows,
            corner,
            constrained: ConstrainedDofs::default(),
            stiffness_is_symmetric: true,
        }
    }

    /// Declares that `K` is not symmetric, as with a convective term.
    ///
    /// Products do not change. [`minres`](crate::minres), [`cg`](crate::cg) and the direct solvers
    /// then refuse the operator; [`Multigrid`](crate::Multigrid) treats it.
    #[must_use]
    pub fn with_unsymmetric_stiffness(mut self) -> Self {
        self.stiffness_is_symmetric = false;
        self
    }

    /// The same operator with another matrix `K` of the same size.
    ///
    /// # Errors
    /// [`LinalgError::NotPositive`] for a diagonal entry that is not positive.
    pub(crate) fn with_stiffness(&self, k: Csr) -> Result<Self, LinalgError> {
        positive_diagonal("stiffness matrix K", &k)?;
        let (left, corner) = (self.border_left.clone(), self.corner.clone());
        let other = Self::from_parts(k, self.border.clone(), left, corner);
        Ok(other.constrain(self.constrained.clone()))
    }

    /// Whether `K` is symmetric: it is unless declared otherwise.
    pub fn has_symmetric_stiffness(&self) -> bool {
        self.stiffness_is_symmetric
    }

    /// Refuses a matrix `K` that was declared not to be symmetric.
    ///
    /// # Errors
    /// [`LinalgError::NotSymmetric`] with the name of the method.
    #[cfg(feature = "direct")]
    pub(crate) fn require_symmetric_stiffness(
        &self,
        method: &'static str,
    ) -> Result<(), LinalgError> {
        match self.stiffness_is_symmetric {
            true => Ok(()),
            false => Err(LinalgError::NotSymmetric { method }),
        }
    }

    /// Constrains single components of nodes to zero.
    ///
    /// The operator becomes `S A S`, with `S` the projector that zeroes the constrained components.
    /// `constrained` lists nodes in ascending order, each with the components constrained. The
    /// scalar matrix still serves all three components.
    ///
    /// Products are zero in the constrained dofs, and `x` must be zero there. Cost per product: one
    /// pass over `constrained`.
    ///
    /// ```
    /// use linalg::{Bordered, Csr, LinearOperator};
    /// let k = Csr::new((2, 2), vec![0, 2, 4], vec![0, 1, 0, 1], vec![2.0, -1.0, -1.0, 2.0]);
    /// let a = Bordered::scalar(k)?.with_constrained_dofs(&[(1, [true, false, false])])?;
    /// let mut y = [0.0; 6];
    /// a.apply(&[1.0, 2.0, 3.0, 0.0, 0.0, 1.0], &mut y);
    /// assert_eq!(y, [2.0, 4.0, 5.0, 0.0, -2.0, -1.0]);
    /// # Ok::<(), linalg::LinalgError>(())
    /// ```
    ///
    /// # Errors
    /// [`LinalgError::Shape`] for a node that does not exist or is out of order.
    pub fn with_constrained_dofs(
        self,
        constrained: &[(u32, [bool; 3])],
    ) -> Result<Self, LinalgError> {
        let constrained = ConstrainedDofs::new(self.nodes(), constrained)?;
        Ok(self.constrain(constrained))
    }

    /// Applies constraints that were checked before.
    pub(crate) fn constrain(mut self, constrained: ConstrainedDofs) -> Self {
        if constrained.is_empty() {
            return self;
        }
        self.border = constrained.drop_rows(self.border);
        self.border_left = self.border_left.map(|left| constrained.drop_rows(left));
        self.border_rows = transpose(self.border_left.as_ref().unwrap_or(&self.border));
        self.border_blocks = RowBlocks::new(Rows::new(&self.border_rows).indptr);
        self.border_nodes = SparseNodes::new(&self.border, |v| v);
        self.constrained = constrained;
        self
    }

    /// Whether single components of nodes are constrained to zero.
    pub fn has_constrained_dofs(&self) -> bool {
        !self.constrained_dofs().is_empty()
    }

    /// The dofs that are constrained to zero.
    pub(crate) fn constrained_dofs(&self) -> &ConstrainedDofs {
        &self.constrained
    }

    /// Number of nodes n; the operator has 3n + m rows.
    pub fn nodes(&self) -> usize {
        self.k.rows()
    }

    /// Number of border dofs m.
    pub fn border_len(&self) -> usize {
        self.corner.nrows()
    }

    /// The scalar matrix `K`.
    pub fn stiffness(&self) -> &Csr {
        &self.k
    }

    /// The scalar matrix `K`, for owners that keep its sparsity pattern.
    pub(crate) fn shared_stiffness(&self) -> &Arc<Csr> {
        &self.k
    }

    /// The border columns `C`, 3n x m.
    pub fn border(&self) -> &Csr {
        &self.border
    }

    /// The left border `C_l`, 3n x m, if it differs from `C`.
    pub fn border_left(&self) -> Option<&Csr> {
        self.border_left.as_ref()
    }

    /// The border rows `C_l^T`, m x 3n.
    pub(crate) fn border_rows(&self) -> &Csr {
        &self.border_rows
    }

    /// The corner `M`, m x m.
    pub fn corner(&self) -> &DMatrix<f64> {
        &self.corner
    }

    /// Node rows in blocks of equal work.
    pub(crate) fn node_blocks(&self) -> &RowBlocks {
        &self.blocks
    }

    /// Border rows in blocks of equal work.
    pub(crate) fn border_blocks(&self) -> &RowBlocks {
        &self.border_blocks
    }

    /// Writes the node rows of the product to the columns `y`.
    ///
    /// `extra(i, a_i)` may add to the sums of node `i`.
    pub(crate) fn apply_nodes<const S: usize>(
        &self,
        u: [&[f64]; S],
        v: [&[f64]; S],
        y: [&mut [f64]; S],
        extra: impl Fn(usize, &mut [[f64; 3]; S]) + Sync,
    ) {
        let (k, u) = (Rows::new(&self.k), u.map(nodes));
        let rows = |rows: Range<usize>, mut y: [&mut [[f64; 3]]; S]| {
            for (at, i) in rows.clone().enumerate() {
                let mut a = node_row(k, i, u);
                extra(i, &mut a);
                for (y, a) in y.iter_mut().zip(a) {
                    y[at] = a;
                }
            }
            let first = rows.start;
            self.border_nodes.for_each(rows, |i, d, c, value| {
                for (y, v) in y.iter_mut().zip(v) {
                    y[i - first][d] += value * v[c];
                }
            });
        };
        let mut y = y.map(nodes_mut);
        self.blocks
            .for_each_block(y.each_mut().map(|y| &mut **y), &rows);
        y.into_iter().for_each(|y| self.constrained.clear(y));
    }

    /// Writes the border rows of the product to the columns `y`, `extra(c)` added.
    pub(crate) fn apply_border<const S: usize>(
        &self,
        u: [&[f64]; S],
        v: [&[f64]; S],
        y: [&mut [f64]; S],
        extra: impl Fn(usize) -> [f64; S] + Sync,
    ) {
        let matrix = Rows::new(&self.border_rows);
        let rows = |rows: Range<usize>, y: [&mut [f64]; S]| {
            for (at, c) in rows.enumerate() {
                let (nodes, others) = (long_row(matrix, c, |j| u.map(|u| u[j])), extra(c));
                for s in 0..S {
                    let corner: f64 = v[s]
                        .iter()
                        .enumerate()
                        .map(|(d, v)| self.corner[(c, d)] * v)
                        .sum();
                    y[s][at] = nodes[s] + corner + others[s];
                }
            }
        };
        self.border_blocks.for_each_block(y, &rows);
    }

    fn pass<const S: usize>(&self, x: [&[f64]; S], y: [&mut [f64]; S]) {
        assert_lengths(&x, self.cols(), &y, self.rows());
        let (u, v) = split(x, 3 * self.nodes());
        let (yu, yv) = split_mut(y, 3 * self.nodes());
        self.apply_nodes(u, v, yu, |_, _| ());
        self.apply_border(u, v, yv, |_| [0.0; S]);
    }
}

impl LinearOperator for Bordered {
    fn rows(&self) -> usize {
        3 * self.nodes() + self.border_len()
    }

    fn cols(&self) -> usize {
        self.rows()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.pass([x], [y]);
    }

    fn apply_columns(&self, x: &[&[f64]], y: &mut [&mut [f64]]) {
        in_passes!(self.pass(x, y));
    }

    /// Whether no left border is given and the corner is symmetric to rounding.
    ///
    /// `K` is symmetric unless declared otherwise.
    fn is_symmetric(&self) -> bool {
        let (m, corner) = (self.border_len(), &self.corner);
        let is_symmetric = |c: usize, d: usize| {
            // entries of the corner are sums over many surface points: about a thousand roundings
            let rounding = 1e3 * f64::EPSILON * corner[(c, c)].abs().max(corner[(d, d)].abs());
            let (upper, lower) = (corner[(c, d)], corner[(d, c)]);
            (upper - lower).abs() <= rounding.max(1e3 * f64::EPSILON * upper.abs())
        };
        let has_symmetric_parts = self.stiffness_is_symmetric && self.border_left.is_none();
        has_symmetric_parts && (0..m).all(|c| (0..c).all(|d| is_symmetric(c, d)))
    }
}

/// A flat vector as one triple per node.
pub(crate) fn nodes(u: &[f64]) -> &[[f64; 3]] {
    u.as_chunks().0
}

/// A flat vector as one triple per node.
pub(crate) fn nodes_mut(u: &mut [f64]) -> &mut [[f64; 3]] {
    u.as_chunks_mut().0
}
