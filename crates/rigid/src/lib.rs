//! Rigid bodies, the links between them, and their motion in a Stokes fluid.
//!
//! The crate turns finite-element matrices and surface points, given as arrays ([`FluidMatrices`]), into a system whose
//! unknowns are the flow and the bodies' velocities ([`Formulation`]). It knows no mesh: any code that can assemble a
//! scalar stiffness and a divergence can use it. Viscosity is 1 throughout; forces are those that bodies exert on the fluid.
//!
//! ```
//! use nalgebra::{DVector, Vector3};
//! use rigid::{Arms, Articulation, BodyKind, Link, Reduction};
//!
//! // Three spheres on a line; the left arm closes at unit speed, the right one keeps its length.
//! let x = [-10.0, 0.0, 10.0].map(|x| Vector3::new(x, 0.0, 0.0));
//! let links = vec![
//!     Link { name: "left arm".into(), body: 0, to: 1 },
//!     Link { name: "right arm".into(), body: 2, to: 1 },
//! ];
//! let set = Articulation::new(&[BodyKind::Rigid; 3], links, Arms::Clamped, &x)?;
//! let constraints = set.constraints(&set.initial_state(), set.initial_lengths(), &[-1.0, 0.0])?;
//!
//! // All velocities that the links allow: U = S v + W, with one rigid motion v of the whole swimmer.
//! let motions = Reduction::of(&set, &constraints)?;
//! assert_eq!(motions.dofs(), 6);
//! let u = motions.velocities(&DVector::zeros(6));
//! assert_eq!(u[0] - u[6], 1.0); // the left sphere comes closer to the centre
//! # Ok::<(), rigid::RigidError>(())
//! ```
#![forbid(unsafe_code)]

mod articulation;
mod constraints;
mod direct_rows;
mod drive;
mod eliminated;
mod error;
mod fluid;
mod formulation;
mod imposed;
mod independent;
mod lagrange;
mod link_loads;
mod motion;
mod node_blocks;
mod node_order;
mod null_space;
mod resistance;
mod symmetry;

pub use articulation::{Arms, Articulation, BodyKind, Link, Linkage, State};
pub use constraints::{Constraints, VelocityLayout};
pub use direct_rows::DirectRows;
pub use drive::{Drive, ExternalLoad};
pub use eliminated::Eliminated;
pub use error::RigidError;
pub use fluid::{FluidMatrices, NodeRole, RigidFluid, SurfaceBody};
pub use formulation::{Constrained, FlowSolution, Formulation};
pub use imposed::Imposed;
pub use independent::Independent;
pub use lagrange::Lagrange;
pub use motion::{StateVelocity, Twist};
pub use null_space::{NullSpace, Reduction};
pub use resistance::GrandResistance;
pub use symmetry::SymmetryPlanes;
