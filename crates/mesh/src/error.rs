//! What can go wrong with a mesh.

/// A mesh that cannot be made, read or used, with the place and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A cell whose geometry map is not one-to-one.
    #[error(
        "cell {cell} near ({:.4}, {:.4}, {:.4}) is inverted: smallest Jacobian {jacobian:.3e} of its mean; \
         use smaller elements there or remesh", at[0], at[1], at[2]
    )]
    InvertedCell {
        /// Index of the cell.
        cell: usize,
        /// Its centroid.
        at: [f64; 3],
        /// Lower bound of the Jacobian determinant over the cell, divided by six times the straight volume.
        jacobian: f64,
    },
}
