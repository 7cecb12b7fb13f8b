//! Methods for the linear system.

/// How the linear system is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Method {
    /// FGMRES with a block-triangular preconditioner, multigrid for velocities and bodies.
    #[default]
    Block,
    /// LDLT factors by MUMPS, refined by FGMRES.
    Direct,
}
