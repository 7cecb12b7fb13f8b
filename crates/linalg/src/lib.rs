//! Operators, sparse kernels, Krylov methods, multigrid and direct factorisations for bordered saddle-point systems.
//!
//! The crate knows no mesh and no physics. It sees one scalar matrix that serves three vector components, a *border*
//! of a few dense columns, and a divergence:
//!
//! ```text
//! [ K (x) I3   C    B^T  ]      unknowns [velocity, 3 interleaved components a node | border | pressure]
//! [ C_l^T      M    E_l^T]
//! [ B          E     0   ]
//! ```
//!
//! | to | use |
//! |---|---|
//! | describe the system | [`Bordered`], [`SaddleSystem`] |
//! | solve a large one | [`fgmres`] with [`BlockTriangular`], whose velocity block is a [`Multigrid`] cycle |
//! | solve a symmetric one in little memory | [`minres`] with [`BlockDiagonal`] |
//! | solve a large one for several right-hand sides | [`fgmres_columns`]: a pass over the matrices serves them all |
//! | solve a small one, or check | [`SaddleLdlt`] |
//! | solve a small one in two dimensions | [`ShiftedLdlt`] |
//! | solve a large one without a mesh hierarchy | [`fgmres`] with [`Schwarz`] |
//! | solve again with a matrix that changed a little | [`WarmStart`] |
//! | solve in a part that mirror planes cut off | [`Bordered::with_constrained_dofs`] |
//! | solve three scalar problems with one matrix | [`cg`] with [`Bordered::scalar`] and [`Multigrid::new`] |
//!
//! Not for general sparse matrices (faer, sprs) or distributed memory (PETSc). Every solver reports the true residual
//! against `||b||`; results are bitwise the same for any number of threads.
//!
//! # Three Poisson problems at once
//!
//! ```
//! use linalg::{Bordered, Csr, KrylovParams, Multigrid, MultigridParams, cg};
//!
//! // -u'' = f with u = 0 at both ends, n unknowns, three right-hand sides interleaved
//! let n = 2000;
//! let mut k = sprs::TriMatI::<f64, u32>::new((n, n));
//! for i in 0..n {
//!     k.add_triplet(i, i, 2.0);
//!     if i > 0 {
//!         k.add_triplet(i, i - 1, -1.0);
//!         k.add_triplet(i - 1, i, -1.0);
//!     }
//! }
//! let k: Csr = k.to_csr();
//! let a = Bordered::scalar(k)?;
//! let mut multigrid = Multigrid::new(&a, &MultigridParams::default())?;
//! let b: Vec<f64> = (0..n).flat_map(|_| [1.0, 2.0, 3.0]).collect();
//! let mut u = vec![0.0; 3 * n];
//! let report = cg(&a, &mut multigrid, &b, &mut u, &KrylovParams::default())?;
//! assert!(report.true_rel_residual <= 1e-8 && report.iterations < 30);
//! let i = n / 2; // u_i = (i + 1) (n - i) / 2 times the right-hand side
//! assert!((u[3 * i + 1] / ((i + 1) * (n - i)) as f64 - 1.0).abs() < 1e-3);
//! # Ok::<(), linalg::LinalgError>(())
//! ```
#![deny(unsafe_code)]

mod amg;
mod block_diagonal;
mod block_triangular;
mod bordered;
mod chebyshev;
mod columns;
mod constrained_dofs;
mod csr;
mod direct;
mod error;
mod inf_sup;
mod krylov;
mod lanczos;
mod multigrid;
mod node_kernel;
mod operator;
mod pressure;
mod product;
mod prolongation;
#[cfg(feature = "roofline")]
pub mod roofline;
mod row_blocks;
mod saddle;
mod scalar;
mod schwarz;
mod submatrix;
mod transpose;
mod vector;
mod warm_start;

pub use block_diagonal::BlockDiagonal;
pub use block_triangular::BlockTriangular;
pub use bordered::Bordered;
pub use chebyshev::MassInverse;
pub use csr::{Csr, Csr3};
pub use direct::{DirectParams, Precision, SaddleLdlt, ShiftedLdlt};
pub use error::LinalgError;
pub use inf_sup::InfSup;
pub use krylov::{KrylovParams, SolveReport, cg, fgmres, fgmres_columns, minres};
pub use multigrid::{BorderInverse, LevelSize, Multigrid, MultigridParams};
pub use operator::{Identity, LinearOperator, Preconditioner, PreconditionerKind};
pub use prolongation::Prolongation;
pub use saddle::SaddleSystem;
pub use schwarz::{BorderPlacement, Schwarz, SchwarzParams};
pub use submatrix::{OMITTED, submatrix};
pub use warm_start::WarmStart;
