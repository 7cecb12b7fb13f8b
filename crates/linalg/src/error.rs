//! What can go wrong, with the numbers and the remedy.

use crate::PreconditionerKind;

/// Every failure of this crate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LinalgError {
    /// A matrix or vector does not fit the others.
    #[error("{what} has shape {found:?} where {expected:?} is needed")]
    Shape {
        /// Which matrix or vector.
        what: &'static str,
        /// Rows and columns that would fit.
        expected: (usize, usize),
        /// Rows and columns handed in.
        found: (usize, usize),
    },
    /// An entry is NaN or infinite.
    #[error("entry {index} of {what} is NaN or infinite; look for a degenerate element")]
    NotFinite {
        /// Which matrix or vector.
        what: &'static str,
        /// Position in its array of values.
        index: usize,
    },
    /// A diagonal entry of a matrix that must be positive definite is not positive.
    #[error(
        "diagonal entry {row} of {what} is {value:e}, not positive; is a row without element left in, or an element inverted?"
    )]
    NotPositive {
        /// Which matrix.
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
        "{method} reached {true_rel_residual:e} in {iterations} iterations, {target:e} was asked; allow more iterations or use a better preconditioner"
    )]
    NotConverged {
        /// The Krylov method.
        method: &'static str,
        /// Iterations done.
        iterations: usize,
        /// `||b - A x|| / ||b||` of the iterate left in `x`.
        true_rel_residual: f64,
        /// The tolerance asked.
        target: f64,
    },
    /// Further iterations no longer reduce the true residual.
    #[error(
        "{method} stagnates at {true_rel_residual:e} after {iterations} iterations, {target:e} was asked; the right-hand side may be incompatible with a singular matrix, or the tolerance be below rounding"
    )]
    Stagnated {
        /// The method.
        method: &'static str,
        /// Iterations done.
        iterations: usize,
        /// `||b - A x|| / ||b||` of the iterate left in `x`.
        true_rel_residual: f64,
        /// The tolerance asked.
        target: f64,
    },
    /// The iteration cannot go on: NaN, or an operator that is not what the method needs.
    #[error("{method} broke down in iteration {iteration}: {cause}")]
    Breakdown {
        /// The method.
        method: &'static str,
        /// Iteration where it happened.
        iteration: usize,
        /// What was seen.
        cause: &'static str,
    },
    /// The method may not be used with this preconditioner.
    #[error(
        "{method} needs a preconditioner that is {needed:?}, this one is {found:?}; use fgmres"
    )]
    UnsuitablePreconditioner {
        /// The method.
        method: &'static str,
        /// What it needs.
        needed: PreconditionerKind,
        /// What it got.
        found: PreconditionerKind,
    },
    /// The method may not be used on this operator.
    #[error(
        "{method} needs a symmetric operator, this one has other rows than columns; use fgmres"
    )]
    NotSymmetric {
        /// The method.
        method: &'static str,
    },
    /// The method does not know of components that are held at zero.
    #[error(
        "{method} cannot hold single components at zero, as {nodes} nodes ask; use fgmres with BlockTriangular or minres with BlockDiagonal"
    )]
    ConstrainedDofs {
        /// The method.
        method: &'static str,
        /// Number of nodes with such components.
        nodes: usize,
    },
    /// A matrix to be factorised is singular or not definite to working precision.
    #[error("{what} cannot be factorised: {detail}")]
    Factorisation {
        /// Which matrix.
        what: &'static str,
        /// What the factorisation reported.
        detail: String,
    },
    /// Momentum and divergence are of so different sizes that no residual norm sees both.
    #[error(
        "the largest entry of the divergence is {ratio:e} of that of the stiffness: a small residual would not bound the divergence; use units in which viscosity and element size are about one"
    )]
    Unbalanced {
        /// Largest entry of the divergence over largest diagonal entry of the stiffness matrix.
        ratio: f64,
    },
    /// Pressures that velocities do not see.
    #[error(
        "the inf-sup constant is {constant:.1e}, below {least:.1e}: the pressure space is too rich for the velocity space; use quadratic velocities with linear pressures"
    )]
    NotInfSupStable {
        /// The constant measured.
        constant: f64,
        /// The least that was asked.
        least: f64,
    },
    /// A subdomain of a domain decomposition cannot be solved on its own.
    #[error("subdomain {subdomain}: {cause}")]
    Subdomain {
        /// Which subdomain.
        subdomain: usize,
        /// What is wrong with its restricted system.
        cause: Box<LinalgError>,
    },
}
