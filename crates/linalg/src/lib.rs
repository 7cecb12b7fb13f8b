#![doc = include_str!("../README.md")]
#![deny(unsafe_code)]

/// Methods that set a public field each and return the struct.
macro_rules! setters {
    ($type:ident { $($set:ident($field:ident: $value:ty),)* }) => {
        impl $type {
            $(
                #[doc = concat!("Sets [`", stringify!($field), "`](Self::", stringify!($field), ").")]
                #[must_use]
                pub fn $set(mut self, $field: $value) -> Self {
                    self.$field = $field;
                    self
                }
            )*
        }
    };
}

mod block_diagonal;
mod block_preconditioner;
mod block_triangular;
mod bordered;
mod chebyshev;
mod columns;
mod constrained_dofs;
mod coupled_operator;
mod csr;
mod csr_operator;
#[cfg(feature = "direct")]
mod direct;
mod error;
mod explicit_inverse;
mod krylov;
mod lanczos;
mod multigrid;
mod node_kernel;
mod operator;
mod pressure;
mod product;
mod prolongation;
mod row_blocks;
mod saddle;
mod schur;
#[cfg(feature = "metis")]
mod schwarz;
mod smoothed_aggregation;
mod submatrix;
mod time_derivative;
mod transpose;
mod vector;
mod warm_start;

// the types of matrices and vectors in the signatures of this crate
pub use nalgebra;
pub use sprs;

pub use block_diagonal::BlockDiagonal;
pub use block_preconditioner::{BlockForm, BlockPreconditioner, BlockPreconditionerBuilder};
pub use block_triangular::BlockTriangular;
pub use bordered::Bordered;
pub use chebyshev::MassInverse;
pub use coupled_operator::CoupledOperator;
pub use csr::{Csr, Csr3, Csr33};
pub use csr_operator::CsrOperator;
#[cfg(feature = "metis")]
pub use direct::partition;
#[cfg(feature = "direct")]
pub use direct::{DirectParams, Precision, SaddleLdlt, ShiftedLdlt};
pub use error::LinalgError;
pub use explicit_inverse::ExplicitInverse;
pub use krylov::{
    ERROR_OVER_RESIDUAL, KrylovParams, NullVectors, OrthonormalBasis, SolveReport, cg, fgmres,
    fgmres_columns, minres,
};
pub use multigrid::{
    BorderInverse, CoupledMultigrid, CyclePart, LevelSize, Multigrid, MultigridParams,
    ScalarMultigrid,
};
pub use operator::{
    Identity, LinearOperator, Preconditioner, PreconditionerKind, SumOverProcesses,
};
pub use pressure::SchurInertia;
pub use prolongation::Prolongation;
pub use saddle::SaddleSystem;
#[cfg(feature = "metis")]
pub use schwarz::{BorderPlacement, Schwarz, SchwarzParams};
pub use smoothed_aggregation::{Aggregates, Coarsening};
pub use submatrix::{OMITTED, submatrix};
pub use time_derivative::{StepControl, StepTooShort, TimeDerivative, extrapolation};
pub use warm_start::WarmStart;
