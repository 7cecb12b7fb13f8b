//! Errors of the assembly and of integrals over a mesh, and the checks of arrays of callers.

use mesh::Vec3;

use crate::quantity::{Quantity, is_finite};

/// Error of an assembly or an integral, with its place and the remedy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FemError {
    /// The Jacobian of a cell's geometry map is not positive at a quadrature point.
    #[error(
        "cell {cell} near ({:.4}, {:.4}, {:.4}) is inverted, flat or not finite: \
         Jacobian determinant {jacobian:.3e}; use smaller elements there or remesh",
        at[0], at[1], at[2]
    )]
    InvertedCell {
        /// Index of the cell.
        cell: usize,
        /// Mean position of its vertices.
        at: [f64; 3],
        /// Jacobian determinant.
        jacobian: f64,
    },
    /// The mesh differs from the one for which the space was built.
    #[error(
        "the cells of the mesh are not those for which the space was built \
         ({found} cells, {expected} expected); build the space again after remeshing"
    )]
    OtherMesh {
        /// Number of cells of the mesh for which the space was built.
        expected: usize,
        /// Number of cells of the given mesh.
        found: usize,
    },
    /// A mesh that is too large for the index types.
    #[error("{what} is {found}, but the index types allow at most {limit}; use a smaller mesh")]
    TooLarge {
        /// Name of the quantity.
        what: &'static str,
        /// Its value.
        found: usize,
        /// Largest allowed value.
        limit: usize,
    },
    /// An array of the wrong length.
    #[error("{what} has length {found}, expected {expected}")]
    Length {
        /// Name of the array.
        what: &'static str,
        /// Its length.
        found: usize,
        /// Expected length.
        expected: usize,
    },
    /// A number that is NaN or infinite.
    #[error("{what} is not finite at index {index}")]
    NotFinite {
        /// Name of the array or quantity.
        what: &'static str,
        /// Index of the first entry, or nodal vector, that is not finite.
        index: usize,
    },
    /// An integrand of a weak form, load or integral that is NaN or infinite.
    #[error(
        "{what} of cell {cell} near ({:.4}, {:.4}, {:.4}) is not finite; check the coefficients, and \
         that nodal fields in it have one value per vertex or one per point of the mesh",
        at[0], at[1], at[2]
    )]
    NotFiniteInCell {
        /// Name of the quantity.
        what: &'static str,
        /// Index of the cell.
        cell: usize,
        /// Mean position of its vertices.
        at: [f64; 3],
    },
    /// A degree for which there is no quadrature rule.
    #[error("no quadrature rule of degree {degree}: the largest degree is {largest}")]
    Degree {
        /// Requested degree.
        degree: usize,
        /// Largest degree of a rule.
        largest: usize,
    },
    /// A point outside the mesh.
    #[error(
        "point {index} at ({:.4}, {:.4}, {:.4}) is outside the mesh; leave it out",
        at[0], at[1], at[2]
    )]
    OutsideMesh {
        /// Index of the point.
        index: usize,
        /// Its position.
        at: [f64; 3],
    },
    /// A matrix whose rows and columns cannot be restricted to the free nodes.
    #[error(transparent)]
    Linalg(#[from] linalg::LinalgError),
    /// A boundary tag without facets.
    #[error("no facet has tag {tag}; the mesh has {n_tags} tags")]
    EmptyTag {
        /// The tag.
        tag: u16,
        /// Number of tags of the mesh.
        n_tags: usize,
    },
    /// A part of the boundary that is not a closed surface.
    #[error(
        "the facets with tag {tag} are not a closed surface: |∮ n dS| is {gap:.3e} of their area; \
         give all facets of a body the same tag"
    )]
    OpenSurface {
        /// The tag.
        tag: u16,
        /// `|∮ n dS|` divided by the area.
        gap: f64,
    },
}

/// Checks that the array `what` has the `expected` length and that every entry is finite.
pub(crate) fn check_array(
    what: &'static str,
    values: &[f64],
    expected: usize,
) -> Result<(), FemError> {
    check(what, values, expected, |value| value.is_finite())
}

/// Checks that the nodal vectors `what` have the `expected` number and that every component is
/// finite.
pub(crate) fn check_vectors(
    what: &'static str,
    values: &[Vec3],
    expected: usize,
) -> Result<(), FemError> {
    check(what, values, expected, |value| {
        value.iter().all(|component| component.is_finite())
    })
}

/// Checks that what was integrated in a cell with these nodes is finite.
pub(crate) fn check_finite_in_cell<'a, T: Quantity + 'a>(
    what: &'static str,
    cell: usize,
    nodes: &[Vec3; 10],
    values: impl IntoIterator<Item = &'a T>,
) -> Result<(), FemError> {
    if is_finite(values) {
        return Ok(());
    }
    let at = mean_of_vertices(nodes).into();
    Err(FemError::NotFiniteInCell { what, cell, at })
}

/// Mean position of the vertices of a cell with these nodes.
pub(crate) fn mean_of_vertices(nodes: &[Vec3; 10]) -> Vec3 {
    (nodes[0] + nodes[1] + nodes[2] + nodes[3]) / 4.0
}

fn check<T>(
    what: &'static str,
    values: &[T],
    expected: usize,
    is_finite: impl Fn(&T) -> bool,
) -> Result<(), FemError> {
    check_length(what, values.len(), expected)?;
    match values.iter().position(|value| !is_finite(value)) {
        Some(index) => Err(FemError::NotFinite { what, index }),
        None => Ok(()),
    }
}

/// Checks that an array of the length `found` has the `expected` length.
pub(crate) fn check_length(
    what: &'static str,
    found: usize,
    expected: usize,
) -> Result<(), FemError> {
    if found == expected {
        Ok(())
    } else {
        Err(FemError::Length {
            what,
            found,
            expected,
        })
    }
}
