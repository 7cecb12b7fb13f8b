//! What can go wrong between a mesh and its matrices.

/// An assembly or an integral that cannot be done, with the place and the remedy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FemError {
    /// The Jacobian of a cell's geometry map is not positive at a quadrature point.
    #[error(
        "cell {cell} near ({:.4}, {:.4}, {:.4}) is inverted, flat or not finite: Jacobian {jacobian:.3e}; \
         check the mesh's quality, use smaller elements there or remesh", at[0], at[1], at[2]
    )]
    InvertedCell {
        /// Index of the cell.
        cell: usize,
        /// Mean of its vertices.
        at: [f64; 3],
        /// The offending Jacobian determinant.
        jacobian: f64,
    },
    /// The mesh given is not the one whose sparsity the space holds.
    #[error(
        "the mesh has other cells than the one the space was made for ({found} cells, {expected} expected); \
         call TaylorHood::new again after remeshing"
    )]
    OtherMesh {
        /// Cells of the mesh the space was made for.
        expected: usize,
        /// Cells of the mesh given.
        found: usize,
    },
    /// A mesh too large for the index types.
    #[error(
        "{what} is {found}, more than the {limit} that the sparsity tables can hold; use a smaller mesh"
    )]
    TooLarge {
        /// The quantity.
        what: &'static str,
        /// Its value.
        found: usize,
        /// The largest value possible.
        limit: usize,
    },
    /// An array of the wrong length.
    #[error("{what} has {found} entries, {expected} expected")]
    Length {
        /// The array.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length it should have.
        expected: usize,
    },
    /// A number that is NaN or infinite.
    #[error("{what} is not finite at index {index}")]
    NotFinite {
        /// The array or quantity.
        what: &'static str,
        /// Where in it.
        index: usize,
    },
    /// A boundary tag without facets.
    #[error("no facet has tag {tag}; the mesh has {n_tags} tags")]
    EmptyTag {
        /// The tag asked for.
        tag: u16,
        /// Number of tags of the mesh.
        n_tags: usize,
    },
    /// A solve that failed.
    #[error(transparent)]
    Linalg(#[from] linalg::LinalgError),
    /// A boundary part that encloses no volume.
    #[error(
        "the facets with tag {tag} do not close: |oint n dS| is {gap:.3e} of their area; \
         give every facet of a body the same tag"
    )]
    OpenSurface {
        /// The tag.
        tag: u16,
        /// Norm of the vector area over the area.
        gap: f64,
    },
}
