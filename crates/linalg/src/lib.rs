//! Operators, sparse kernels, Krylov methods, multigrid and direct factorisations.
#![deny(unsafe_code)]

mod amg;
mod block_triangular;
mod bordered;
mod chebyshev;
mod csr;
mod direct;
mod error;
mod krylov;
mod lanczos;
mod multigrid;
mod node_kernel;
mod operator;
mod product;
mod row_blocks;
mod saddle;
mod scalar;
mod transfer;
mod vector;

pub use block_triangular::BlockTriangular;
pub use bordered::Bordered;
pub use chebyshev::MassInverse;
pub use csr::{Csr, Csr3};
pub use direct::{DirectParams, SaddleLdlt};
pub use error::LinalgError;
pub use krylov::{KrylovParams, SolveReport, cg, fgmres};
pub use multigrid::{LevelSize, Multigrid, MultigridParams};
pub use operator::{Identity, LinearOperator, Preconditioner, PreconditionerKind};
pub use saddle::SaddleSystem;
pub use transfer::Transfer;
