#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod articulation;
mod body_forces;
mod constrained;
mod constraints;
mod drive;
mod error;
mod flow;
mod fluid;
mod fluid_matrices;
mod formulations;
mod joint;
mod joint_loads;
mod linkage;
mod linkage_part;
mod loop_closure;
mod mesh_part;
mod motion_bounds;
mod node_blocks;
mod null_space;
mod placement;
mod prescribed_motion;
mod resistance;
mod state;
mod stresslets;
mod symmetry;
mod velocity_layout;

pub use articulation::{Articulation, BodyKind};
pub use constrained::{Constrained, Imposed};
pub use constraints::{Constraints, JointLoad};
pub use drive::{Drive, ExternalLoad};
pub use error::RigidError;
pub use flow::FlowSolution;
pub use fluid::RigidFluid;
pub use fluid_matrices::{FluidMatrices, FluidNodes, Inertia, NodeRole, SurfaceBody};
pub use formulations::{DirectRows, Eliminated, Formulation, Independent, Lagrange};
pub use joint::{Arms, Freedom, Joint, JointDrive, JointKind, PassiveDrive};
pub use linkage::Linkage;
pub use linkage_part::LinkagePart;
pub use mesh_part::{MeshPart, SumOverParts, UpdateGhosts};
pub use motion_bounds::{DerivativeBounds, MotionBounds, StateBounds, ValueBounds};
pub use null_space::{NullSpace, Reduction};
pub use resistance::GrandResistance;
pub use state::{State, StateVelocity, Twist};
pub use symmetry::SymmetryPlanes;
pub use velocity_layout::VelocityLayout;

// the crates whose types appear in signatures
pub use linalg;
pub use nalgebra;
pub use sprs;
