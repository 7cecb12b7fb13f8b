#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod arm_vectors;
mod articulation;
mod body_forces;
mod border;
mod constrained;
mod constraints;
mod damping;
mod direct_rows;
mod drive;
mod eliminated;
mod error;
mod exponential_map;
mod flow;
mod fluid;
mod fluid_matrices;
mod formulation;
mod imposed;
mod independent;
mod joint;
mod joint_loads;
mod lagrange;
mod linkage;
mod loop_closure;
mod mesh_part;
mod node_blocks;
mod node_order;
mod null_space;
mod placement;
mod prescribed_motion;
mod resistance;
mod stresslets;
mod symmetry;
mod velocity_layout;

pub use articulation::{Arms, Articulation, BodyKind};
pub use constrained::Constrained;
pub use constraints::Constraints;
pub use direct_rows::DirectRows;
pub use drive::{Drive, ExternalLoad};
pub use eliminated::Eliminated;
pub use error::RigidError;
pub use exponential_map::{StateVelocity, Twist};
pub use flow::FlowSolution;
pub use fluid::RigidFluid;
pub use fluid_matrices::{FluidMatrices, FluidNodes, NodeRole, SurfaceBody};
pub use formulation::Formulation;
pub use imposed::Imposed;
pub use independent::Independent;
pub use joint::{JointDrive, JointKind, PassiveDrive};
pub use lagrange::Lagrange;
pub use linkage::{Joint, Linkage};
pub use mesh_part::{MeshPart, SumOverParts, UpdateGhosts};
pub use null_space::{NullSpace, Reduction};
pub use placement::State;
pub use resistance::GrandResistance;
pub use symmetry::SymmetryPlanes;
pub use velocity_layout::VelocityLayout;

// the crates whose types appear in signatures
pub use linalg;
pub use nalgebra;
pub use sprs;
