//! The kernels of the cycle, for comparison with the memory bandwidth.

use super::{Multigrid, cycle, top};
use crate::kernel::{Kernel, Measure};

impl Multigrid {
    /// Lower bound on the bytes moved by a cycle, input and output included.
    pub(crate) fn bytes(&self) -> usize {
        let levels = self.levels.iter();
        let inside: usize = levels
            .map(|l| {
                (2 * l.steps() - 1) * l.sweep_bytes()
                    + l.restriction_bytes()
                    + l.prolongation_bytes()
            })
            .sum();
        inside + 2 * 40 * self.sizes[0].nodes
    }

    /// Passes the kernels of a cycle to `measure`.
    pub(crate) fn visit_kernels(&mut self, measure: &mut Measure) {
        let whole = self.bytes();
        let Some((fine, rest)) = self.levels.split_first_mut() else {
            return;
        };
        let steps = fine.steps() as f64;
        let kernel = |name, bytes, runs| Kernel { name, bytes, runs };
        let bytes = fine.sweep_bytes();
        measure(
            kernel("smoothing step, f32", bytes, 2.0 * steps - 1.0),
            &mut || fine.sweep_once(),
        );
        let bytes = fine.restriction_bytes();
        let below = top(rest, &mut self.coarse);
        measure(
            kernel("residual and its restriction, f32", bytes, 1.0),
            &mut || fine.restrict::<1>(below),
        );
        let bytes = fine.prolongation_bytes();
        measure(kernel("prolongation, f32", bytes, 1.0), &mut || {
            fine.prolong::<1>(below);
        });
        let inside = whole - 2 * 40 * self.sizes[0].nodes;
        let fine_bytes = (2 * fine.steps() - 1) * fine.sweep_bytes()
            + fine.restriction_bytes()
            + fine.prolongation_bytes();
        let coarse = &mut self.coarse;
        measure(
            kernel("coarser levels, f32", inside - fine_bytes, 1.0),
            &mut || cycle::<1>(rest, coarse),
        );
    }
}
