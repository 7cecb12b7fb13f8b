//! Components of nodes that are constrained to zero, such as normal velocities on a symmetry plane.

use crate::LinalgError;
use crate::csr::{Csr, Rows};
use crate::node_kernel::Padded;
use crate::product::build_rows;

/// The constrained components of nodes; all other components are free.
///
/// Let `S` be the projector that zeroes the constrained components, so that an operator `A` becomes
/// `S A S`. One scalar matrix still serves all three components, on every level of a hierarchy: if
/// a constrained node interpolates only from coarse nodes that are constrained in the same
/// components, then `S P S_c = P S_c`, and the Galerkin product `(P S_c)^T S (K (x) I3) S (P S_c)`
/// is `S_c (P^T K P (x) I3) S_c`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct ConstrainedDofs {
    /// Nodes in ascending order with one bit per constrained component, at least one bit set.
    nodes: Vec<(u32, u8)>,
}

impl ConstrainedDofs {
    /// Constraints from nodes in ascending order, each with its constrained components.
    ///
    /// # Errors
    /// [`LinalgError::Shape`] for a node that is not below `n` or not above the one before it.
    pub fn new(n: usize, constrained: &[(u32, [bool; 3])]) -> Result<Self, LinalgError> {
        for (k, &(node, _)) in constrained.iter().enumerate() {
            let least = k
                .checked_sub(1)
                .map_or(0, |k| constrained[k].0 as usize + 1);
            if !(least..n).contains(&(node as usize)) {
                return Err(LinalgError::Shape {
                    what: "list of constrained nodes, ascending,",
                    expected: (least, n),
                    found: (node as usize, n),
                });
            }
        }
        let bits = |constrained: &[bool; 3]| {
            (0..3).fold(0, |bits, d| bits | u8::from(constrained[d]) << d)
        };
        let nodes = constrained
            .iter()
            .map(|(node, constrained)| (*node, bits(constrained)));
        Ok(ConstrainedDofs {
            nodes: nodes.filter(|(_, bits)| *bits != 0).collect(),
        })
    }

    /// Whether all components are free.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Zeroes the constrained components: `u <- S u`.
    pub fn clear(&self, u: &mut [[f64; 3]]) {
        for &(node, bits) in &self.nodes {
            components(bits).for_each(|d| u[node as usize][d] = 0.0);
        }
    }

    /// Zeroes the constrained components of all columns of a multigrid level.
    pub fn clear_columns<const S: usize>(&self, u: &mut [[Padded; S]]) {
        for &(node, bits) in &self.nodes {
            for column in &mut u[node as usize] {
                components(bits).for_each(|d| column[d] = 0.0);
            }
        }
    }

    /// The bits of each of `n` nodes.
    pub fn bits(&self, n: usize) -> Vec<u8> {
        let mut all = vec![0; n];
        for &(node, bits) in &self.nodes {
            all[node as usize] = bits;
        }
        all
    }

    /// Empties the rows of constrained dofs in a matrix with three rows per node.
    pub fn drop_rows(&self, matrix: Csr) -> Csr {
        if self.is_empty() || matrix.nnz() == 0 {
            return matrix;
        }
        let bits = self.bits(matrix.rows() / 3);
        let rows = Rows::new(&matrix);
        build_rows(matrix.rows(), matrix.cols(), |i, row| {
            if bits[i / 3] >> (i % 3) & 1 == 0 {
                for (c, v) in rows.row(i) {
                    row.add(c, v);
                }
            }
        })
    }

    /// The constraints of the coarse nodes of a prolongation.
    ///
    /// A coarse node is constrained in every component in which a fine node that interpolates from
    /// it is constrained.
    pub fn coarse(&self, prolongation: &Csr) -> Self {
        if self.is_empty() {
            return ConstrainedDofs::default();
        }
        let rows = Rows::new(prolongation);
        let mut all = vec![0; prolongation.cols()];
        for &(node, bits) in &self.nodes {
            for (j, value) in rows.row(node as usize) {
                if value != 0.0 {
                    all[j] |= bits;
                }
            }
        }
        let nodes = (0u32..).zip(all);
        ConstrainedDofs {
            nodes: nodes.filter(|(_, bits)| *bits != 0).collect(),
        }
    }

    /// Eliminates the nodes that are constrained in component `d` from a scalar matrix.
    ///
    /// Their rows and columns are replaced by the diagonal entries.
    pub fn pinned(&self, matrix: &Csr, d: usize) -> Csr {
        let bits = self.bits(matrix.rows());
        let is_constrained = |i: usize| bits[i] >> d & 1 == 1;
        let mut pinned = matrix.clone();
        for (i, mut row) in pinned.outer_iterator_mut().enumerate() {
            for (j, value) in row.iter_mut() {
                if i != j && (is_constrained(i) || is_constrained(j)) {
                    *value = 0.0;
                }
            }
        }
        pinned
    }

    #[cfg(feature = "direct")]
    /// Refuses constraints on behalf of a method that does not support them.
    ///
    /// # Errors
    /// [`LinalgError::ConstrainedDofs`] if a component is constrained.
    pub fn refuse(&self, method: &'static str) -> Result<(), LinalgError> {
        match self.nodes.len() {
            0 => Ok(()),
            nodes => Err(LinalgError::ConstrainedDofs { method, nodes }),
        }
    }
}

/// The components whose bits are set.
fn components(bits: u8) -> impl Iterator<Item = usize> {
    (0..3).filter(move |d| bits >> d & 1 == 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coarse_nodes_that_move_constrained_ones_are_constrained() {
        // coarse 0 moves fine 0 and 1, coarse 1 moves 1 and 2
        let p = Csr::new(
            (3, 2),
            vec![0, 1, 3, 4],
            vec![0, 0, 1, 1],
            vec![1.0, 0.5, 0.5, 1.0],
        );
        let x = [true, false, false];
        let coarse = |constrained: &[(u32, [bool; 3])]| {
            ConstrainedDofs::new(3, constrained).map(|h| h.coarse(&p))
        };
        assert_eq!(coarse(&[(0, x)]), ConstrainedDofs::new(2, &[(0, x)]));
        assert_eq!(
            coarse(&[(1, x)]),
            ConstrainedDofs::new(2, &[(0, x), (1, x)])
        );
        assert_eq!(coarse(&[(2, [false; 3])]), Ok(ConstrainedDofs::default()));
    }

    #[test]
    fn lists_out_of_order_or_range_are_refused() {
        let z = [false, false, true];
        assert!(ConstrainedDofs::new(3, &[(1, z), (1, z)]).is_err());
        assert!(ConstrainedDofs::new(3, &[(2, z), (1, z)]).is_err());
        assert!(ConstrainedDofs::new(3, &[(3, z)]).is_err());
        assert!(ConstrainedDofs::new(3, &[(0, z), (2, z)]).is_ok());
    }
}
