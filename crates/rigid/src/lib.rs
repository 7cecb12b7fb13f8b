//! Rigid bodies, the links between them, and their motion in a Stokes fluid.
//!
//! The crate turns finite-element matrices and surface points, given as arrays, into a system
//! whose unknowns are the flow and the bodies' velocities. It knows no mesh: any code that can
//! assemble a scalar stiffness and a divergence can use it.
#![forbid(unsafe_code)]

mod articulation;
mod constraints;
mod eliminated;
mod error;
mod fluid;
mod formulation;
mod independent;
mod motion;
mod node_blocks;
mod null_space;

pub use articulation::{Arms, Articulation, BodyKind, Link, Linkage, State};
pub use constraints::{Constraints, VelocityLayout};
pub use eliminated::Eliminated;
pub use error::RigidError;
pub use fluid::{FluidMatrices, NodeRole, RigidFluid, SurfaceBody};
pub use formulation::{Constrained, Drive, Flow, Formulation, Load};
pub use independent::Independent;
pub use motion::{StateVelocity, Twist};
pub use null_space::{NullSpace, Reduction};
