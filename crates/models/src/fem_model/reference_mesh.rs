//! A mesh that meshes of other configurations are moved from, and the limits of the motion.

use std::sync::{Arc, OnceLock};

use ale::{
    Biharmonic, Elastic, Harmonic, Kernel, MeshMotion, MovingBody, Rbf, ReferenceMap, Stiffening,
    SurfaceDisplacement,
};
use fem::{SurplusSpace, TaylorHood};
use mesh::{Quality, TetMesh};
use mesher::Capsule;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::cylinder;
use super::mesh_generator::{MeshGenerator, Placement, Surfaced};
use crate::flow_field::get_or_try;
use crate::{ModelError, Remesh};
use scene::MeshMotionKind;

/// Smallest Jacobian of a cell, relative to its mean, that a moved mesh may have.
///
/// Quadratic fields on more distorted cells are inaccurate, and the solver becomes slow (61
/// iterations instead of 31 with one inverted cell).
const MIN_JACOBIAN: f64 = 0.2;

/// Smallest mean ratio of a cell that a moved mesh may have; motions by four radii leave 0.3.
const MIN_QUALITY: f64 = 0.1;

/// Largest length of cells in a gap, relative to its width, that a moved mesh may have.
///
/// New meshes have 0.5 to 1.25 (gaps of 8 to 0.02 radii, sizes of 0.4 to 1.2). Moved meshes reach
/// 1.5 when a resolved gap has closed to half its width.
const MAX_GAP_RATIO: f64 = 1.5;

/// Relative deterioration that is always allowed, for new meshes that exceed the limits themselves.
const ALWAYS_ALLOWED: f64 = 0.9;

/// A mesh that other meshes are moved from, and the data that belong to its connectivity.
///
/// What a single solve on the mesh does not need is created when it is first asked for.
pub struct ReferenceMesh {
    mesh: Arc<TetMesh>,
    /// The method that moves the mesh.
    motion: Arc<dyn MeshMotion>,
    moving: OnceLock<Moving>,
    /// Function spaces on the cells.
    space: OnceLock<Arc<TaylorHood>>,
    /// Space for error estimates; created when estimates are first requested.
    pub surplus: Option<Arc<SurplusSpace>>,
    /// Placement of the bodies with surfaces.
    surfaced: Placement,
    /// Placement of all bodies of the scene for which the reference was needed; empty for the mesh
    /// of a file, moved by the first method.
    pub placement: Placement,
    /// The part of a cylinder that the mesh fills.
    capsule: Option<Capsule>,
}

/// What meshes of other configurations need.
struct Moving {
    map: ReferenceMap,
    gap_ratio: f64,
    quality: Quality,
}

impl ReferenceMesh {
    /// A mesh with the method that moves it; `surfaced` is the placement of the bodies with
    /// surfaces, `placement` that of all bodies.
    pub fn new(
        generator: &MeshGenerator,
        motion: &Arc<dyn MeshMotion>,
        mesh: Arc<TetMesh>,
        surfaced: Placement,
        placement: &Placement,
    ) -> Self {
        Self {
            mesh,
            motion: Arc::clone(motion),
            moving: OnceLock::new(),
            space: OnceLock::new(),
            surplus: None,
            capsule: generator.capsule(&surfaced),
            surfaced,
            placement: placement.clone(),
        }
    }

    /// Prepares the motion of the mesh, unless it is prepared.
    ///
    /// # Errors
    /// A mesh that is too large, or whose motion cannot be computed.
    pub fn prepare_motion(&self, generator: &MeshGenerator) -> Result<(), ModelError> {
        self.moving(generator).map(|_| ())
    }

    fn moving(&self, generator: &MeshGenerator) -> Result<&Moving, ModelError> {
        get_or_try(&self.moving, || {
            let placed = generator.surfaced.iter().zip(&self.surfaced.poses);
            let bodies: Vec<MovingBody> = (generator.tags().zip(placed))
                .map(|(tag, (body, pose))| MovingBody {
                    tag: tag.to_owned(),
                    centre: pose.translation.vector,
                    // Rotations do not change spheres.
                    rotates: !body.is_isotropic(),
                })
                .collect();
            // A space that nobody else needs is not kept, for its memory.
            let space = match self.space.get() {
                Some(space) => Arc::clone(space),
                None => Arc::new(TaylorHood::new(&self.mesh)?),
            };
            let mesh = Arc::clone(&self.mesh);
            Ok(Moving {
                map: ReferenceMap::with_space(mesh, &space, &bodies, &*self.motion)?,
                gap_ratio: generator.gap_ratio(&self.mesh, &self.surfaced),
                quality: self.mesh.quality(),
            })
        })
    }

    /// Function spaces on the cells.
    ///
    /// # Errors
    /// A mesh that is too large.
    pub fn space(&self) -> Result<Arc<TaylorHood>, ModelError> {
        let space = get_or_try(&self.space, || TaylorHood::new(&self.mesh).map(Arc::new))?;
        Ok(Arc::clone(space))
    }

    /// Name of the method that moves the mesh.
    pub fn motion(&self) -> &'static str {
        self.motion.name()
    }

    /// The mesh at its reference configuration.
    pub fn mesh(&self) -> &Arc<TetMesh> {
        &self.mesh
    }

    /// Placement of the bodies with surfaces there.
    pub fn surfaced(&self) -> &Placement {
        &self.surfaced
    }

    /// Creates the space for error estimates if there is none.
    ///
    /// # Errors
    /// A mesh with too many cells.
    pub fn prepare_estimates(&mut self) -> Result<(), ModelError> {
        if self.surplus.is_none() {
            self.surplus = Some(Arc::new(SurplusSpace::new(&self.mesh)?));
        }
        Ok(())
    }

    /// Distance from placed bodies to the nearer end of a cylinder, in its radii.
    pub fn end_distance(&self, generator: &MeshGenerator, placement: &Placement) -> Option<f64> {
        let capsule = self.capsule.as_ref()?;
        Some(cylinder::end_distance(
            capsule,
            &generator.bounding_balls(placement),
        ))
    }

    /// The mesh moved to placed bodies, or the reason why it becomes too poor.
    ///
    /// # Errors
    /// A failed motion for another reason than a poor mesh.
    pub fn moved(
        &self,
        generator: &MeshGenerator,
        placement: &Placement,
    ) -> Result<Result<Arc<TetMesh>, Remesh>, ModelError> {
        if let Some(distance) = self.end_distance(generator, placement)
            && cylinder::is_too_close(distance)
        {
            return Ok(Err(Remesh::End(distance)));
        }
        // A mesh at its reference configuration is always accepted, because a new one would not be
        // better.
        if *placement == self.surfaced {
            return Ok(Ok(Arc::clone(&self.mesh)));
        }
        let moving = self.moving(generator)?;
        let mesh = match self.moved_anyway(generator, placement) {
            Ok(mesh) => mesh,
            Err(ModelError::Ale(ale::AleError::Invalid(_))) => return Ok(Err(Remesh::Inverted)),
            Err(other) => return Err(other),
        };
        let quality = mesh.quality();
        let reference = &moving.quality;
        if quality.min_jacobian < MIN_JACOBIAN.min(ALWAYS_ALLOWED * reference.min_jacobian) {
            return Ok(Err(Remesh::Jacobian(quality.min_jacobian)));
        }
        if quality.min_quality < MIN_QUALITY.min(ALWAYS_ALLOWED * reference.min_quality) {
            return Ok(Err(Remesh::Quality(quality.min_quality)));
        }
        let gap_ratio = generator.gap_ratio(&mesh, placement);
        if gap_ratio > MAX_GAP_RATIO.max(moving.gap_ratio / ALWAYS_ALLOWED) {
            return Ok(Err(Remesh::Gap(gap_ratio)));
        }
        Ok(Ok(Arc::new(mesh)))
    }

    /// The mesh moved to placed bodies, without limits of quality.
    ///
    /// Nodes on a body that deforms move onto the surface of the new shape: on spheres along their
    /// rays from the centre, on tubes as material points.
    ///
    /// # Errors
    /// [`ale::AleError::Invalid`] if a cell is inverted; those of [`Self::prepare_motion`].
    pub fn moved_anyway(
        &self,
        generator: &MeshGenerator,
        placement: &Placement,
    ) -> Result<TetMesh, ModelError> {
        let poses = placement.poses.iter().zip(&self.surfaced.poses);
        let bodies = || generator.surfaced.iter().zip(poses.clone());
        let motion = |(body, (now, then)): (&Surfaced, (&Isometry3<f64>, &Isometry3<f64>))| {
            let translation = now.translation.vector - then.translation.vector;
            // Rotations do not change spheres, whose surface meshes are translated.
            let rotation = match body.is_isotropic() {
                true => UnitQuaternion::identity(),
                false => now.rotation * then.rotation.inverse(),
            };
            Isometry3::from_parts(Translation3::from(translation), rotation)
        };
        let motions: Vec<Isometry3<f64>> = bodies().map(motion).collect();
        let displacements: Vec<Option<Box<SurfaceDisplacement<'_>>>> = (bodies().zip(&motions))
            .map(|((body, (_, then)), motion)| {
                let deformation = body.deformation.as_ref()?;
                let values = [&self.surfaced.values[..], &placement.values];
                let own = generator.displacement(deformation, values);
                let turn = motion.rotation * then.rotation;
                let displacement = move |x: &Vector3<f64>| {
                    let arm = x - then.translation.vector;
                    turn * own(&then.rotation.inverse_transform_vector(&arm))
                };
                Some(Box::new(displacement) as Box<SurfaceDisplacement<'_>>)
            })
            .collect();
        let displacements: Vec<_> = displacements.iter().map(Option::as_deref).collect();
        let map = &self.moving(generator)?.map;
        Ok(map.moved_and_deformed(&motions, &displacements)?)
    }
}

/// The mesh motions of a scene, in the order in which they are tried.
///
/// Meshes that can be generated again need one method only, that of the paper. The mesh of a file
/// is tried with others, ordered by cost and by the displacement that they allow
/// (`docs/ale-files.md`): biharmonic for fine meshes, harmonic for curved cells of coarse meshes,
/// cubic radial basis functions near walls, linear ones in gaps.
pub fn mesh_motions(kind: MeshMotionKind, is_from_file: bool) -> Vec<Arc<dyn MeshMotion>> {
    match (kind, is_from_file) {
        (MeshMotionKind::Auto, true) => vec![
            Arc::new(Biharmonic),
            Arc::new(Harmonic(Stiffening::KanchiMasud)),
            Arc::new(Rbf(Kernel::Cubic)),
            Arc::new(Rbf(Kernel::Linear)),
        ],
        _ => vec![mesh_motion(kind)],
    }
}

fn mesh_motion(kind: MeshMotionKind) -> Arc<dyn MeshMotion> {
    match kind {
        MeshMotionKind::Biharmonic => Arc::new(Biharmonic),
        MeshMotionKind::Laplace => Arc::new(Harmonic(Stiffening::None)),
        MeshMotionKind::Auto | MeshMotionKind::KanchiMasud => {
            Arc::new(Harmonic(Stiffening::KanchiMasud))
        }
        MeshMotionKind::InverseVolume => Arc::new(Harmonic(Stiffening::InverseVolume)),
        MeshMotionKind::Elastic => Arc::new(Elastic::default()),
        MeshMotionKind::Rbf => Arc::new(Rbf(Kernel::Cubic)),
    }
}
