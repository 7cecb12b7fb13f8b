//! Operators, sparse kernels, Krylov methods, multigrid and direct factorisations.
#![deny(unsafe_code)]

mod csr;

pub use csr::{Csr, Csr3};
