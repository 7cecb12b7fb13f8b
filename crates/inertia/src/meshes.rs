//! The meshes of a moving configuration.

use std::sync::Arc;

use ale::{AleError, ReferenceMap};
use fem::TaylorHood;
use mesh::TetMesh;
use nalgebra::Isometry3;

use crate::InertiaError;

/// A mesh of a supplier, with the space on its cells if the supplier has it.
///
/// An integrator makes a space of its own for a mesh without one, which takes 0.1 kB per degree of
/// freedom. A space on the cells of another mesh is an error
/// ([`FemError::OtherMesh`](fem::FemError::OtherMesh)).
pub struct SuppliedMesh {
    /// The mesh.
    pub mesh: TetMesh,
    /// The space on its cells.
    pub space: Option<Arc<TaylorHood>>,
}

impl SuppliedMesh {
    /// The mesh with its space.
    pub(crate) fn with_space(self) -> Result<(TetMesh, Arc<TaylorHood>), InertiaError> {
        let space = match self.space {
            Some(space) => space,
            None => Arc::new(TaylorHood::new(&self.mesh)?),
        };
        Ok((self.mesh, space))
    }
}

impl From<TetMesh> for SuppliedMesh {
    fn from(mesh: TetMesh) -> Self {
        Self { mesh, space: None }
    }
}

/// Supplies the mesh of each configuration of the bodies.
///
/// All meshes between two calls of [`renew`](Meshes::renew) have the same connectivity: velocities
/// of earlier times are carried by the nodes.
pub trait Meshes {
    /// The mesh at a time, around bodies with these poses, one per body with a surface.
    ///
    /// The time matters where walls move. A step may ask for several meshes, and be rejected.
    ///
    /// None if the mesh cannot follow the bodies there: the integrator then calls
    /// [`renew`](Meshes::renew) and tries once more.
    ///
    /// # Errors
    /// A mesh that cannot be moved for another reason.
    fn mesh(
        &mut self,
        time: f64,
        poses: &[Isometry3<f64>],
    ) -> Result<Option<SuppliedMesh>, InertiaError>;

    /// A new mesh at a time, of any connectivity, around bodies with these poses.
    ///
    /// # Errors
    /// A mesh that cannot be generated; by default there is none.
    fn renew(
        &mut self,
        _time: f64,
        _poses: &[Isometry3<f64>],
    ) -> Result<Option<SuppliedMesh>, InertiaError> {
        Ok(None)
    }

    /// Whether displacements are small: then neither bodies nor mesh move, whatever their
    /// velocities.
    fn is_frozen(&self) -> bool {
        false
    }
}

/// A mesh that moves with its bodies by a [`ReferenceMap`].
pub struct MappedMesh {
    map: ReferenceMap,
    initial: Vec<Isometry3<f64>>,
}

impl MappedMesh {
    /// The map from a mesh around bodies with the poses `initial`.
    pub fn new(map: ReferenceMap, initial: Vec<Isometry3<f64>>) -> Self {
        Self { map, initial }
    }
}

impl Meshes for MappedMesh {
    fn mesh(
        &mut self,
        _: f64,
        poses: &[Isometry3<f64>],
    ) -> Result<Option<SuppliedMesh>, InertiaError> {
        let motion = |(initial, pose): (&Isometry3<f64>, &Isometry3<f64>)| {
            let translation = pose.translation.vector - initial.translation.vector;
            let rotation = pose.rotation * initial.rotation.inverse();
            Isometry3::from_parts(translation.into(), rotation)
        };
        let motions: Vec<_> = self.initial.iter().zip(poses).map(motion).collect();
        match self.map.moved(&motions) {
            Ok(mesh) => Ok(Some(mesh.into())),
            Err(AleError::Invalid(_)) => Ok(None),
            Err(other) => Err(other.into()),
        }
    }
}

/// A mesh that does not move, for displacements that are small compared with the bodies.
///
/// The equations are then linearised about one configuration: impedances, and starts from rest
/// before bodies have moved.
pub struct FrozenMesh(pub TetMesh);

impl Meshes for FrozenMesh {
    fn mesh(&mut self, _: f64, _: &[Isometry3<f64>]) -> Result<Option<SuppliedMesh>, InertiaError> {
        Ok(Some(self.0.clone().into()))
    }

    fn is_frozen(&self) -> bool {
        true
    }
}
