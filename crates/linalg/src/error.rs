//! Errors of the crate, with numbers and remedies.

use crate::PreconditionerKind;

/// An error of this crate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LinalgError {
    /// A matrix or vector does not fit the others.
    #[error("{what} has shape {found:?}, expected {expected:?}")]
    Shape {
        /// Name of the matrix or vector.
        what: &'static str,
        /// Rows and columns that would fit.
        expected: (usize, usize),
        /// Rows and columns given.
        found: (usize, usize),
    },
    /// A row, column or number that does not exist or occurs twice.
    #[error("{what}: {index} is not one of {len}, or is given twice")]
    Index {
        /// Meaning of the index.
        what: &'static str,
        /// The index.
        index: u32,
        /// Number of items that exist.
        len: usize,
    },
    /// An entry is NaN or infinite.
    #[error("entry {index} of {what} is NaN or infinite; look for a degenerate element")]
    NotFinite {
        /// Name of the matrix or vector.
        what: &'static str,
        /// Position in the array of values.
        index: usize,
    },
    /// A diagonal entry of a matrix that must be positive definite is not positive.
    #[error(
        "diagonal entry {row} of {what} is {value:e}, not positive; look for a row without elements or an inverted element"
    )]
    NotPositive {
        /// Name of the matrix.
        what: &'static str,
        /// Row of the entry.
        row: usize,
        /// The entry.
        value: f64,
    },
    /// A parameter is outside its range.
    #[error("parameter {name} = {value:e} must be {range}")]
    Parameter {
        /// Name of the field.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Allowed values, in words.
        range: &'static str,
    },
    /// The iteration limit was reached.
    #[error(
        "{method} reached a relative residual of {true_rel_residual:e} in {iterations} iterations, {target:e} was requested; allow more iterations or use a better preconditioner"
    )]
    NotConverged {
        /// The Krylov method.
        method: &'static str,
        /// Number of iterations.
        iterations: usize,
        /// Relative residual of the iterate left in `x`.
        ///
        /// The larger of both norms if the operator has weights.
        true_rel_residual: f64,
        /// The same in the norm of the operator's weights; equal without them.
        weighted_rel_residual: f64,
        /// The requested tolerance.
        target: f64,
    },
    /// Further iterations no longer reduce the true residual.
    #[error(
        "{method} stagnates at a relative residual of {true_rel_residual:e} after {iterations} iterations, {target:e} was requested; the tolerance may be below rounding, or the matrix singular (see KrylovParams::with_null_vectors)"
    )]
    Stagnated {
        /// The method.
        method: &'static str,
        /// Number of iterations.
        iterations: usize,
        /// Relative residual of the iterate left in `x`.
        ///
        /// The larger of both norms if the operator has weights.
        true_rel_residual: f64,
        /// The requested tolerance.
        target: f64,
    },
    /// The iteration cannot continue: NaN, or an operator without the required properties.
    #[error("{method} broke down in iteration {iteration}: {cause}")]
    Breakdown {
        /// The method.
        method: &'static str,
        /// Iteration in which it happened.
        iteration: usize,
        /// The cause.
        cause: &'static str,
    },
    /// The method cannot be used with this preconditioner.
    #[error(
        "{method} needs a preconditioner of kind {needed:?}, this one is {found:?}; use fgmres"
    )]
    UnsuitablePreconditioner {
        /// The method.
        method: &'static str,
        /// The kind that it needs.
        needed: PreconditionerKind,
        /// The kind that was given.
        found: PreconditionerKind,
    },
    /// The method cannot be used on this operator.
    #[error("{method} needs a symmetric operator, this one is not; use fgmres")]
    NotSymmetric {
        /// The method.
        method: &'static str,
    },
    /// The method cannot be used on vectors that are divided between processes.
    #[error("{method} cannot be used on vectors that are divided between processes; use fgmres")]
    SeveralProcesses {
        /// The method.
        method: &'static str,
    },
    /// The method does not support single components constrained to zero.
    #[error(
        "{method} does not support single components constrained to zero, which {nodes} nodes have; use fgmres with BlockTriangular or minres with BlockDiagonal"
    )]
    ConstrainedDofs {
        /// The method.
        method: &'static str,
        /// Number of nodes with such components.
        nodes: usize,
    },
    /// A vector that was given as a null vector is linearly dependent on those before it.
    #[error("null vector {index} is zero or depends linearly on those before it")]
    Dependent {
        /// Position of the vector.
        index: usize,
    },
    /// A vector that was given as a null vector is not mapped to zero.
    #[error(
        "vector {index} is not a null vector: the operator reduces it only to {ratio:e} of the operator norm"
    )]
    NotNullVector {
        /// Position of the vector.
        index: usize,
        /// `||A v|| / ||A||` for the vector scaled to `||v|| = 1`.
        ratio: f64,
    },
    /// A matrix to be factorised is singular or not definite to working precision.
    #[error("{what} cannot be factorised: {detail}")]
    Factorisation {
        /// Name of the matrix.
        what: &'static str,
        /// Reason reported by the factorisation.
        detail: String,
    },
    /// Aggregation no longer coarsens a level that is too large to be factorised.
    #[error(
        "aggregation stalls on level {level} with {nodes} nodes, at most {limit} are factorised: few connections are stronger than {strength}; lower MultigridParams::strength, use MultigridParams::heterogeneous, raise max_factorised_nodes, or, if the matrix is diagonally dominant, precondition it by MassInverse"
    )]
    CoarseningStalled {
        /// Number of the level; zero is the finest.
        level: usize,
        /// Number of nodes of the level.
        nodes: usize,
        /// The limit, `MultigridParams::max_factorised_nodes`.
        limit: usize,
        /// The threshold of strong connections.
        strength: f64,
    },
    /// Stiffness and divergence differ so much in size that no residual norm controls both.
    #[error(
        "the largest entry of the divergence is only {ratio:e} times that of the stiffness, so a small residual would not bound the divergence; scale the system so that both are of similar size"
    )]
    Unbalanced {
        /// Largest entry of the divergence over largest diagonal entry of the stiffness matrix.
        ratio: f64,
    },
    /// A block of a block preconditioner, or a coupling of two, does not fit the others.
    #[error("block `{block}`: {problem}")]
    Block {
        /// Name of the block.
        block: String,
        /// What does not fit, with the numbers.
        problem: String,
    },
    /// The restriction of the system to a subdomain is singular.
    #[error("subdomain {subdomain}: {cause}")]
    Subdomain {
        /// Number of the subdomain.
        subdomain: usize,
        /// The error of its restricted system.
        cause: Box<LinalgError>,
    },
}
