//! Errors of distributed solutions.

/// A problem that cannot be assembled or solved on several processes.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PetscError {
    /// A call of PETSc that failed.
    #[error("PETSc: {function} failed with code {code}: {message}")]
    Call {
        /// Name of PETSc's function.
        function: &'static str,
        /// Error code of PETSc.
        code: i32,
        /// PETSc's message.
        message: String,
    },
    /// A session that was started before.
    #[error("PETSc was initialised before in this process; one session can be started")]
    SecondSession,
    /// More degrees of freedom than PETSc's integers can number.
    #[error(
        "{what}: {found} does not fit into PETSc's integers of {bits} bits; use a PETSc with 64-bit \
         indices"
    )]
    TooLarge {
        /// What was counted.
        what: &'static str,
        /// The number.
        found: usize,
        /// Size of PETSc's integers.
        bits: u32,
    },
    /// Processes without a part of the mesh.
    #[error("the mesh is too small for {ranks} processes: process {rank} has no node; use fewer")]
    TooManyProcesses {
        /// Number of processes.
        ranks: usize,
        /// The first process without a node.
        rank: usize,
    },
    /// A call on a thread without a session.
    #[error("this thread has no session of PETSc; start one before solving")]
    NoSession,
    /// A linear solver that only one machine has.
    #[error("the solver '{what}' is not available on PETSc; use 'block' or 'direct'")]
    Unsupported {
        /// Name of the solver.
        what: &'static str,
    },
    /// A formulation whose system is not symmetric.
    #[error("the formulation '{formulation}' is not symmetric; use p, p-tilde or lagrange")]
    NotSymmetric {
        /// Name of the formulation.
        formulation: &'static str,
    },
    /// An outer or inner solver that did not converge.
    #[error(
        "the solver of the {role} did not converge in {iterations} iterations (PETSc's reason \
         {reason}), with a true relative residual of {true_relative_residual:.2e}; try other \
         options, or the direct solver"
    )]
    NotConverged {
        /// System, motion, pressure, or a level of multigrid.
        role: String,
        /// Its number of iterations.
        iterations: usize,
        /// `KSPConvergedReason`, negative.
        reason: i32,
        /// `|b - A x| / |b|` of the whole system.
        true_relative_residual: f64,
    },
    /// A failed assembly.
    #[error(transparent)]
    Stokes(#[from] stokes::StokesError),
    /// A failed partition.
    #[error(transparent)]
    Linalg(#[from] linalg::LinalgError),
    /// An unusable mesh.
    #[error(transparent)]
    Mesh(#[from] mesh::MeshError),
    /// Contradictory constraints.
    #[error(transparent)]
    Rigid(#[from] rigid::RigidError),
}
