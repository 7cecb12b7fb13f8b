//! The trait of all methods that extend a boundary displacement into a mesh.

use fem::TaylorHood;
use mesh::{TetMesh, Vec3};

use crate::AleError;

/// A mesh with a prescribed displacement on its boundary.
#[derive(Clone, Copy)]
pub struct MovingMesh<'a> {
    /// The mesh before the motion.
    pub mesh: &'a TetMesh,
    /// The finite-element space on it.
    pub space: &'a TaylorHood,
    /// Whether each vertex has a prescribed displacement.
    pub prescribed: &'a [bool],
}

impl MovingMesh<'_> {
    /// Refuses lists and fields without exactly one finite value per vertex.
    ///
    /// # Errors
    /// [`AleError::Length`], [`AleError::NotFinite`].
    pub(crate) fn check(&self, fields: &[Vec<Vec3>]) -> Result<(), AleError> {
        let expected = self.mesh.n_vertices();
        let is_prescribed = ("vertices marked as prescribed", self.prescribed.len());
        let fields = || fields.iter().map(Vec::as_slice);
        let lengths = fields().map(|field| ("displacements of the vertices", field.len()));
        for (what, found) in std::iter::once(is_prescribed).chain(lengths) {
            if found != expected {
                return Err(AleError::Length {
                    what,
                    expected,
                    found,
                });
            }
        }
        let is_bad = |d: &Vec3| !d.iter().all(|component| component.is_finite());
        match fields().find_map(|field| field.iter().position(is_bad)) {
            Some(vertex) => Err(AleError::NotFinite {
                what: "the displacement of vertex",
                index: vertex,
            }),
            None => Ok(()),
        }
    }
}

/// A linear extension of boundary displacements to all vertices.
///
/// The extension depends on the mesh. Computed once on a reference mesh, it gives meshes that
/// depend on the configuration only ([`ReferenceMap`](crate::ReferenceMap)); computed at every step
/// on the current mesh, it would give meshes that depend on the history.
pub trait MeshMotion: Send + Sync {
    /// Name of the method in scenes and tables.
    fn name(&self) -> &'static str;

    /// Whether the components are uncoupled and have the same scalar operator.
    ///
    /// One scalar field then extends a body's translations in all directions.
    fn is_scalar(&self) -> bool;

    /// Extends each field from the prescribed vertices to all others, whose values are overwritten.
    ///
    /// Shapes: one vector per vertex. Returns the number of iterations of all solves, zero for
    /// direct methods.
    ///
    /// # Errors
    /// Fields of the wrong length or not finite, a parameter out of range, a solver that fails, or
    /// a problem too large for the method.
    fn extend(&self, moving: &MovingMesh<'_>, fields: &mut [Vec<Vec3>]) -> Result<usize, AleError>;
}
