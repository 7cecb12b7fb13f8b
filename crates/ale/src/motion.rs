//! What every extension of boundary motion into a mesh offers.

use fem::TaylorHood;
use mesh::{TetMesh, Vec3};

use crate::AleError;

/// A mesh whose boundary is to move.
#[derive(Clone, Copy)]
pub struct MovingMesh<'a> {
    /// The mesh before the motion.
    pub mesh: &'a TetMesh,
    /// What depends on its connectivity.
    pub space: &'a TaylorHood,
    /// Whether a vertex is on the boundary, where displacements are given.
    pub prescribed: &'a [bool],
}

/// A linear map from displacements of the boundary to displacements of all vertices.
///
/// The map depends on the mesh it is applied to. Applied to one reference mesh it gives meshes that follow the shape
/// ([`ReferenceMap`](crate::ReferenceMap)); applied again and again to the mesh of the step before, meshes that follow the
/// history ([`IncrementalMap`](crate::IncrementalMap)).
pub trait MeshMotion: Send + Sync {
    /// Its name in scenes and tables.
    fn name(&self) -> &'static str;

    /// Whether one scalar operator extends each component by itself: one scalar field then serves a body's translations in all directions.
    fn is_scalar(&self) -> bool;

    /// Extends each field: its values at prescribed vertices are kept, the others are overwritten.
    ///
    /// Shapes: one vector a vertex.
    /// # Errors
    /// A solve that fails, or too large a problem for the method.
    fn extend(&self, moving: &MovingMesh<'_>, fields: &mut [Vec<Vec3>]) -> Result<(), AleError>;
}
