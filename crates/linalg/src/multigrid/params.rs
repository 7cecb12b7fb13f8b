//! Parameters of multigrid.

use crate::LinalgError;
use crate::chebyshev::MAX_DEGREE;

/// Parameters of the hierarchy of levels.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct MultigridParams {
    /// Smoothing steps before and after the coarse correction on the finest level.
    ///
    /// Each takes one pass over its matrix.
    pub sweeps: usize,
    /// Smoothing steps on coarser levels, whose passes are cheap.
    pub coarse_sweeps: usize,
    /// Ratio of the largest to the smallest eigenvalue that the smoother damps.
    ///
    /// It acts on eigenvalues of `D^-1 K` from `upper / smoothing_range` to `upper`.
    pub smoothing_range: f64,
    /// Threshold of strong connections.
    ///
    /// Neighbours with `a_ij^2 > strength^2 a_ii a_jj` may be aggregated.
    pub strength: f64,
    /// Largest number of nodes of a level that is solved exactly.
    pub coarsest_nodes: usize,
    /// Multiple of its diagonal that is added to the coarsest matrix before it is factorised.
    ///
    /// Zero for a regular matrix, [`SINGULAR_SHIFT`](Self::SINGULAR_SHIFT) for a singular one.
    pub coarsest_shift: f64,
    /// Treatment of an indefinite border, as with Lagrange multipliers, on the coarsest level.
    pub border: BorderInverse,
}

/// Inverse of the Schur complement `S = Q diag(s) Q^T` of the border on the coarsest level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
            // factors of such a matrix cost less than one smoothing step on the finest level
            coarsest_nodes: 500,
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
}

setters!(MultigridParams {
    with_coarsest_shift(coarsest_shift: f64),
    with_sweeps(sweeps: usize),
    with_coarse_sweeps(coarse_sweeps: usize),
    with_smoothing_range(smoothing_range: f64),
    with_strength(strength: f64),
    with_coarsest_nodes(coarsest_nodes: usize),
    with_border(border: BorderInverse),
});
