//! Formulations of the constraints: P, P-tilde, Lagrange multipliers and direct rows.

mod direct_rows;
mod eliminated;
mod independent;
mod lagrange;

pub use direct_rows::DirectRows;
pub use eliminated::Eliminated;
pub use independent::Independent;
pub use lagrange::Lagrange;

use crate::{Constrained, Drive, RigidError, RigidFluid};

/// A way to impose the constraints of joints on the flow around rigid bodies.
pub trait Formulation: Sync {
    /// Name for reports and scene files.
    fn name(&self) -> &'static str;

    /// Builds the linear system for one configuration.
    ///
    /// # Errors
    /// Constraints that contradict each other, a fluid in which some velocity is undetermined, or
    /// sizes that do not fit.
    fn constrain(&self, fluid: RigidFluid, drive: &Drive) -> Result<Constrained, RigidError>;
}
