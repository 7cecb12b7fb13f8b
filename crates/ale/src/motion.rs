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

/// A linear extension of boundary displacements to all vertices.
///
/// The extension depends on the mesh. Computed once on a reference mesh, it gives meshes that
/// depend on the configuration only ([`ReferenceMap`](crate::ReferenceMap)); computed at every step
/// on the current mesh, it gives meshes that depend on the history
/// ([`IncrementalMap`](crate::IncrementalMap)).
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
    /// A parameter out of range, a solver that fails, or a problem too large for the method.
    fn extend(&self, moving: &MovingMesh<'_>, fields: &mut [Vec<Vec3>]) -> Result<usize, AleError>;
}
