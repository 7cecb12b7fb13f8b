//! Right-hand side and correction of one level.

use crate::constrained_dofs::ConstrainedDofs;
use crate::node_kernel::Padded;

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

    /// Number of nodes of the level.
    #[cfg(feature = "roofline")]
    pub fn nodes(&self) -> usize {
        self.nodes
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
