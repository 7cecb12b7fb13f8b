//! Parameters of multigrid.

use crate::chebyshev::{self, MAX_DEGREE};
use crate::{Coarsening, LinalgError};

/// Parameters of the hierarchy of levels.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct MultigridParams {
    /// Smoothing steps before and after the coarse correction on the finest level; 1 by default.
    ///
    /// Each takes one pass over its matrix.
    pub sweeps: usize,
    /// Smoothing steps on coarser levels, whose passes are cheap; 2 by default.
    pub coarse_sweeps: usize,
    /// Ratio of the largest to the smallest eigenvalue that the smoother damps; 7 by default.
    ///
    /// It acts on eigenvalues of `D^-1 K` from `upper / smoothing_range` to `upper`.
    pub smoothing_range: f64,
    /// Threshold of strong connections, which may be aggregated, 0.02 by default; see
    /// [`coarsening`].
    ///
    /// [`coarsening`]: Self::coarsening
    pub strength: f64,
    /// Measure of strong connections, and the prolongation that follows from it;
    /// [`Coarsening::Standard`] by default.
    pub coarsening: Coarsening,
    /// Number of nodes at or below which a level is solved exactly; 500 by default.
    pub coarsest_nodes: usize,
    /// Largest number of nodes that are factorised if aggregation stalls above `coarsest_nodes`.
    ///
    /// [`MAX_FACTORISED_NODES`](Self::MAX_FACTORISED_NODES) by default. Above it the set-up returns
    /// [`LinalgError::CoarseningStalled`].
    pub max_factorised_nodes: usize,
    /// Multiple of its diagonal that is added to the coarsest matrix before it is factorised.
    ///
    /// Zero, the default, for a regular matrix, [`SINGULAR_SHIFT`](Self::SINGULAR_SHIFT) for a
    /// singular one.
    pub coarsest_shift: f64,
    /// Treatment of an indefinite border, as with Lagrange multipliers, on the coarsest level;
    /// [`BorderInverse::Exact`] by default.
    pub border: BorderInverse,
}

/// Inverse of the Schur complement `S = Q diag(s) Q^T` of the border on the coarsest level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum BorderInverse {
    /// `S^-1`: the best preconditioner, indefinite if `S` is.
    Exact,
    /// `|S|^-1 = Q diag(1 / |s|) Q^T` for a symmetric `S`; equal to `Exact` for a definite one.
    ///
    /// The cycle is then positive definite, as [`minres`](crate::minres) requires, and
    /// preconditioned eigenvalues are near 1 and -1 (Vecharynski, Knyazev, SIAM J. Sci. Comput. 35,
    /// 2013).
    Absolute,
}

impl Default for MultigridParams {
    fn default() -> Self {
        MultigridParams {
            // FGMRES iterations with 1, 2, 3, 4 steps for three spheres, 243 000 dofs: 22, 21, 21,
            // 20; a pass takes a tenth of the time of an iteration
            sweeps: 1,
            // 26 iterations with one step, 22 with two or three
            coarse_sweeps: 2,
            // iterations for 3, 4, 5, 7, 10: 23, 22, 22, 22, 22
            smoothing_range: 7.0,
            // structured meshes have connections that cancel to rounding; with a threshold of zero
            // they count as strong and cost four to six iterations
            strength: 0.02,
            coarsening: Coarsening::Standard,
            // factors of such a matrix cost less than one smoothing step on the finest level
            coarsest_nodes: 500,
            max_factorised_nodes: MultigridParams::MAX_FACTORISED_NODES,
            coarsest_shift: 0.0,
            border: BorderInverse::Exact,
        }
    }
}

impl MultigridParams {
    /// Parameters of a single level that is solved exactly.
    ///
    /// The factors of the scalar `K` serve three components: they have a ninth of the nonzeros and
    /// take a twenty-seventh of the operations of the factors of `K (x) I3`. The "cycle" is then
    /// the inverse in f32 precision.
    pub fn direct() -> Self {
        MultigridParams {
            coarsest_nodes: usize::MAX,
            ..MultigridParams::default()
        }
    }

    /// Parameters for strongly varying coefficients.
    ///
    /// Those of [`Coarsening::Filtered`], with two smoothing steps on the finest level. Iterations
    /// of [`cg`](crate::cg) to 1e-8 with a random right-hand side, Dirichlet conditions and
    /// [`ScalarMultigrid`](crate::ScalarMultigrid), and the operator complexity in parentheses. `k`
    /// is constant in each cell, with a random logarithm; finite volumes use harmonic means. Cells:
    /// 32^3 and 128^2. The last column is [`anisotropic`](Self::anisotropic).
    ///
    /// | problem | default | heterogeneous | anisotropic |
    /// |:--|--:|--:|--:|
    /// | finite volumes, 3-D, `k` from 1e-3 to 1e3 | 46 (2.8) | 15 (2.9) | 13 (2.8) |
    /// | finite volumes, 3-D, `k` = 1e-3 or 1e3 | 15 (3.7) | 11 (2.4) | 11 (2.6) |
    /// | trilinear elements, 3-D, `k` from 1e-3 to 1e3 | 20 (1.4) | 11 (1.4) | 11 (1.6) |
    /// | finite volumes, 2-D, `k` from 1e-3 to 1e3 | 73 (1.9) | 19 (1.9) | 52 (1.8) |
    /// | bilinear elements, 2-D, `k` from 1e-3 to 1e3 | 56 (1.5) | 14 (1.4) | 13 (1.5) |
    /// | finite volumes, 3-D, `k_z` = 1e-3 | 12 (2.5) | 9 (1.7) | 9 (1.8) |
    /// | finite volumes, 3-D, `k_z` = 1e3 | 12 (27) | 8 (2.0) | 8 (2.0) |
    /// | trilinear elements, 3-D, `k_z` = 1e-3 | 93 (1.1) | 10 (1.1) | 10 (1.1) |
    /// | trilinear elements, 3-D, `k_z` = 1e3 | 160 (1.1) | 16 (1.6) | 16 (1.5) |
    /// | bilinear elements, 2-D, `k_y` = 1e-3 | 251 (1.1) | 10 (1.5) | 9 (1.5) |
    /// | the same, rotated by 15 degrees | 111 (1.1) | 32 (1.3) | 17 (1.5) |
    /// | the same, rotated by 30 degrees | 66 (1.1) | 26 (1.3) | 22 (1.4) |
    /// | the same, rotated by 45 degrees | 41 (1.1) | 32 (1.3) | 17 (1.8) |
    /// | finite volumes, 3-D, `k` = 1 | 11 (1.6) | 9 (1.6) | 9 (1.6) |
    ///
    pub fn heterogeneous() -> Self {
        MultigridParams {
            coarsening: Coarsening::Filtered,
            // between a quarter and a half: in trilinear elements with an anisotropy of 10^3 the
            // ratio of weak to strong couplings is 1/4, in isotropic ones 1/2. Iterations for 0.26,
            // 0.3, 0.4 with one smoothing step and random coefficients in three dimensions: 24, 23,
            // 21, in two: 28, 25, 29
            strength: 0.3,
            // 15 iterations instead of 23, 19 instead of 25: a step costs less than it saves
            sweeps: 2,
            ..MultigridParams::default()
        }
    }

    /// Parameters for anisotropy in any direction to the grid.
    ///
    /// Those of [`heterogeneous`](Self::heterogeneous), whose table has the iterations, with a
    /// larger [`strength`](Self::strength): nodes are aggregated along the strong direction only.
    /// Random coefficients on the few couplings of finite volumes in two dimensions leave too few
    /// strong ones.
    pub fn anisotropic() -> Self {
        MultigridParams {
            // in bilinear elements with an anisotropy of 10^3 the ratio of the couplings across the
            // strong direction to those along it is 0.40 at 45 degrees, 0.49 at 15. Iterations at
            // 45 degrees for 0.3, 0.4, 0.5: 32, 32, 17; smoothing does not help: 32, 30 with three
            // steps on coarser levels or on the finest, 33 with twice the smoothing range
            strength: 0.5,
            ..MultigridParams::heterogeneous()
        }
    }

    /// Relaxation factors of the smoothing steps on a level, the finest of which is 0, with the
    /// upper bound on the spectrum of the scaled matrix.
    pub(super) fn relaxation_factors(&self, level: usize, upper: f64) -> Vec<f64> {
        let steps = match level {
            0 => self.sweeps,
            _ => self.coarse_sweeps,
        };
        chebyshev::sweeps(upper, self.smoothing_range, steps)
    }

    /// Refuses a level of `nodes` nodes that can neither be aggregated nor factorised.
    pub(super) fn check_stalled(&self, level: usize, nodes: usize) -> Result<(), LinalgError> {
        if nodes <= self.max_factorised_nodes {
            return Ok(());
        }
        Err(LinalgError::CoarseningStalled {
            level,
            nodes,
            limit: self.max_factorised_nodes,
            strength: self.strength,
        })
    }

    /// Refuses parameters outside their ranges.
    pub(super) fn check(&self) -> Result<(), LinalgError> {
        let parameter = |name, value, range| Err(LinalgError::Parameter { name, value, range });
        if !(self.smoothing_range > 1.0 && self.smoothing_range.is_finite()) {
            return parameter(
                "smoothing_range",
                self.smoothing_range,
                "above 1 and finite",
            );
        }
        for (name, sweeps) in [
            ("sweeps", self.sweeps),
            ("coarse_sweeps", self.coarse_sweeps),
        ] {
            if !(1..=MAX_DEGREE).contains(&sweeps) {
                return parameter(name, sweeps as f64, "from 1 to 1000");
            }
        }
        if !(0.0..1.0).contains(&self.coarsest_shift) {
            return parameter("coarsest_shift", self.coarsest_shift, "in [0, 1)");
        }
        if !(0.0..1.0).contains(&self.strength) {
            return parameter("strength", self.strength, "in [0, 1)");
        }
        Ok(())
    }
}

impl MultigridParams {
    /// The [`coarsest_shift`](Self::coarsest_shift) for a singular matrix.
    ///
    /// Small compared with the least nonzero eigenvalue of `D^-1 K` on the coarsest level, which is
    /// 0.025 for the seven-point Laplacian on 8^3 nodes; large compared with the rounding errors of
    /// the cycle in f32, 1e-7.
    pub const SINGULAR_SHIFT: f64 = 1e-5;

    /// The default of [`max_factorised_nodes`](Self::max_factorised_nodes).
    ///
    /// The factors of the 27-point stencil on 12 167 nodes take 0.6 s, ten times the set-up of a
    /// hierarchy, and their cost in three dimensions grows with the square of the number of nodes.
    pub const MAX_FACTORISED_NODES: usize = 10_000;
}

setters!(MultigridParams {
    with_coarsest_shift(coarsest_shift: f64),
    with_sweeps(sweeps: usize),
    with_coarse_sweeps(coarse_sweeps: usize),
    with_smoothing_range(smoothing_range: f64),
    with_strength(strength: f64),
    with_coarsening(coarsening: Coarsening),
    with_max_factorised_nodes(max_factorised_nodes: usize),
    with_coarsest_nodes(coarsest_nodes: usize),
    with_border(border: BorderInverse),
});
