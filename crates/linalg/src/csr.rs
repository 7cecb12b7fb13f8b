//! The compressed-row types every crate exchanges: scalar entries and 3-vector entries.

use sprs::CsMatI;

/// Compressed sparse rows: `u32` columns, `usize` row pointers, columns sorted within a row.
///
/// The interchange type of the workspace; sprs keeps the structure valid (sorted, in bounds).
pub type Csr = CsMatI<f64, u32, usize>;

/// Compressed sparse rows whose entries are 3-vectors: row `q`, column `j` holds `(b_x, b_y, b_z)`.
///
/// The discrete divergence has this form: `(B u)_q = sum_j b_qj . u_j`, one row a pressure
/// unknown, one column a velocity node.
pub type Csr3 = CsMatI<[f64; 3], u32, usize>;
