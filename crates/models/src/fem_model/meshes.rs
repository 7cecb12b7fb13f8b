//! The mesh of each shape: moved from a reference where that stays good, made anew where not.

use ale::{
    Biharmonic, Elastic, Harmonic, Kernel, MeshMotion, MovingBody, Rbf, ReferenceMap, Stiffening,
};
use fem::{SurplusSpace, TaylorHood};
use mesh::{Capsule, Quality, Sphere, TetMesh};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::far_field::FarField;
use super::mesher::{Mesher, Source};
use super::tube;
use crate::scale::Scale;
use crate::{ModelError, Remesh};
use scene::{MeshMotionKind, Scene};

/// Remesh when the Jacobian of some cell falls below this part of its mean: quadratic fields on such cells are
/// poor and the solver slows down (61 iterations instead of 31 with one inverted cell).
const LEAST_JACOBIAN: f64 = 0.2;

/// Remesh when some mean ratio falls below this. Moves of four radii in one step stay at 0.3.
const LEAST_QUALITY: f64 = 0.1;

/// Remesh when cells in a gap become so many times as long as the gap is wide. New meshes have
/// 0.5 to 1.25 (gaps of 8 to 0.02 radii, sizes of 0.4 to 1.2): moved ones reach 1.5 when a resolved gap has closed to half its width.
const LARGEST_GAP_RATIO: f64 = 1.5;

/// A mesh that is worse than these when it is new may lose the rest of this part of what it has.
const KEPT_OF_ITS_OWN: f64 = 0.9;

/// Distances from a mirror plane, in radii, that are rounding of many steps: farther off, meshes are refused.
const ROUNDING: f64 = 1e-9;

/// Norms of quaternions that were written to a file differ from 1 by rounding.
const ROTATION_ROUNDING: f64 = 1e-9;

/// A mesh that others are moved from, and what is kept with its connectivity.
struct Reference {
    map: ReferenceMap,
    space: TaylorHood,
    /// What error estimates need, once they were wanted.
    surplus: Option<SurplusSpace>,
    centres: Vec<Vector3<f64>>,
    /// Poses of all bodies of the scene; none for the mesh of a file.
    poses: Vec<Isometry3<f64>>,
    /// Its [`mesh::TetMesh::gap_ratio`].
    gap_ratio: f64,
    /// Its [`mesh::TetMesh::quality`].
    quality: Quality,
    /// The piece of a cylinder that it fills.
    tube: Option<Capsule>,
}

/// References kept at most. A stroke comes back to its shapes, so those of a cycle serve the next; each takes about a third of a solve's memory.
const KEPT: usize = 3;

/// Meshes for the shapes of one scene, in units of the flow.
pub struct Meshes {
    mesher: Mesher,
    motion: Box<dyn MeshMotion>,
    /// In the order in which they were made.
    references: Vec<Reference>,
    /// The one in use; none of them after adapting.
    current: Option<usize>,
}

/// The mesh of one shape.
pub struct ShapeMesh {
    /// The mesh.
    pub mesh: TetMesh,
    /// Why it was made anew; none if it was moved.
    pub remeshed: Option<Remesh>,
    /// Whether its cells are others than those of the mesh before.
    pub other_cells: bool,
}

impl Meshes {
    /// Prepares meshes for a scene.
    ///
    /// # Errors
    /// A domain that cannot be meshed yet.
    pub fn new(scene: &Scene, scale: &Scale) -> Result<Self, ModelError> {
        Ok(Self {
            mesher: Mesher::new(scene, scale)?,
            motion: motion(scene.fem().mesh_motion),
            references: Vec::new(),
            current: None,
        })
    }

    /// Names of the bodies with surfaces: their tags in the mesh.
    pub fn tags(&self) -> impl Iterator<Item = &str> {
        self.mesher.tags()
    }

    /// Indices in the scene of the bodies with surfaces.
    pub fn surfaced_bodies(&self) -> impl Iterator<Item = usize> {
        self.mesher.surfaced_bodies()
    }

    /// Puts poses that rounding moved off the mirror planes back onto them.
    pub fn onto_mirrors(&self, poses: &mut [Isometry3<f64>]) {
        for pose in poses {
            for axis in (0..3).filter(|&axis| self.mesher.mirrors[axis]) {
                let x = &mut pose.translation.vector[axis];
                if x.abs() <= ROUNDING {
                    *x = 0.0;
                }
            }
        }
    }

    /// Tags of the walls.
    pub fn wall_tags(&self) -> Vec<&str> {
        self.mesher.wall_tags()
    }

    /// The spheres that straight facets stand for, by tags, the bodies with surfaces being at `centres`.
    pub fn straight_spheres(&self, centres: &[Vector3<f64>]) -> Vec<(&str, Sphere)> {
        self.mesher.straight_spheres(centres)
    }

    /// What is left of relative errors for a container that stands for something larger: unbounded fluid, an infinite cylinder.
    pub fn container_error(&self, poses: &[Isometry3<f64>]) -> f64 {
        let centres = self.mesher.centres(poses);
        if let Some(far) = self.mesher.far_field {
            let bodies = self.mesher.spheres(&centres).into_iter();
            return far.relative_error(bodies.map(|body| (body.centre, body.radius)));
        }
        let reference = self
            .current
            .and_then(|current| self.references.get(current));
        reference
            .and_then(|reference| self.to_end(reference, &centres))
            .map_or(0.0, tube::relative_error)
    }

    /// Radii of the cylinder between the bodies and the nearest end of the piece that a reference fills.
    fn to_end(&self, reference: &Reference, centres: &[Vector3<f64>]) -> Option<f64> {
        let tube = reference.tube.as_ref()?;
        Some(tube::to_end(tube, &self.mesher.spheres(centres)))
    }

    /// What the wall takes that stands for unbounded fluid, if one does.
    pub fn far_field(&self) -> Option<FarField> {
        self.mesher.far_field
    }

    /// What is kept with the connectivity of the mesh in use.
    pub fn space(&self) -> Option<&TaylorHood> {
        let reference = self.references.get(self.current?)?;
        Some(&reference.space)
    }

    /// What error estimates need of the mesh in use, if [`Meshes::prepare_estimates`] made it.
    pub fn surplus_space(&self) -> Option<&SurplusSpace> {
        self.references.get(self.current?)?.surplus.as_ref()
    }

    /// Numbers the cubic functions of the mesh in use.
    ///
    /// # Errors
    /// A mesh with too many cells.
    pub fn prepare_estimates(&mut self) -> Result<(), ModelError> {
        if let Some(current) = self.current
            && let Some(reference) = self.references.get_mut(current)
            && reference.surplus.is_none()
        {
            reference.surplus = Some(SurplusSpace::new(reference.map.reference())?);
        }
        Ok(())
    }

    /// The mesh with the bodies at `poses` (one a body of the scene): the first reference that can be moved there without being spoilt, or a
    /// new one. In this order the mesh depends on the shape, not on where the bodies came from, once the meshes of a stroke are made.
    ///
    /// # Errors
    /// Bodies that cannot be meshed around, or that have moved farther than a mesh from a file can follow.
    pub fn at(&mut self, poses: &[Isometry3<f64>]) -> Result<ShapeMesh, ModelError> {
        if let (true, Source::File { mesh, .. }) = (self.references.is_empty(), &self.mesher.source)
        {
            let centres = self.mesher.surfaced.iter().map(|s| s.position).collect();
            let reference = self.reference(mesh.clone(), centres, &[])?;
            self.references.push(reference);
        }
        let mut reason = Remesh::First;
        for number in 0..self.references.len() {
            match self.moved(&self.references[number], poses)? {
                Ok(mesh) => {
                    let other_cells = self.current != Some(number);
                    self.current = Some(number);
                    return Ok(ShapeMesh {
                        mesh,
                        remeshed: None,
                        other_cells,
                    });
                }
                // Of several the newest tells why.
                Err(spoilt) => reason = spoilt,
            }
        }
        if let Source::File { .. } = &self.mesher.source {
            return Err(ModelError::MeshFileExhausted);
        }
        let mesh = self.remesh(poses)?;
        Ok(ShapeMesh {
            mesh,
            remeshed: Some(reason),
            other_cells: true,
        })
    }

    /// Makes a mesh with the bodies at `poses` another reference; the oldest goes where there are too many.
    ///
    /// # Errors
    /// Bodies that cannot be meshed around.
    fn remesh(&mut self, poses: &[Isometry3<f64>]) -> Result<TetMesh, ModelError> {
        let centres = self.mesher.centres(poses);
        let mesh = self.mesher.generate(&centres)?;
        let reference = self.reference(mesh.clone(), centres, poses)?;
        if self.references.len() == KEPT {
            self.references.remove(0);
        }
        self.references.push(reference);
        self.current = Some(self.references.len() - 1);
        Ok(mesh)
    }

    /// Makes a new reference at `poses` with edges as long as `wanted` at places in the mesh in use; false if meshes cannot be made here.
    ///
    /// # Errors
    /// Sizes that are not positive, bodies that cannot be meshed around.
    pub fn adapt(
        &mut self,
        poses: &[Isometry3<f64>],
        wanted: Vec<(Vector3<f64>, f64)>,
    ) -> Result<bool, ModelError> {
        if let Source::File { .. } = &self.mesher.source {
            return Ok(false);
        }
        self.mesher.adapt(&self.mesher.centres(poses), wanted)?;
        // The others have the sizes of before.
        self.references.clear();
        self.remesh(poses)?;
        self.current = None;
        Ok(true)
    }

    /// The poses that the references were made for, one after the other, from which [`Meshes::restore`] makes the same ones.
    pub fn reference_poses(&self) -> Vec<Isometry3<f64>> {
        self.references
            .iter()
            .flat_map(|reference| reference.poses.iter().copied())
            .collect()
    }

    /// Makes the references of an earlier run again, bit for bit.
    ///
    /// # Errors
    /// Poses of another number of bodies, or such as cannot be meshed.
    pub fn restore(&mut self, poses: &[Isometry3<f64>]) -> Result<(), ModelError> {
        let bodies = self.mesher.tags.len();
        // The references of this run already.
        if poses == self.reference_poses() {
            return Ok(());
        }
        self.references.clear();
        self.current = None;
        let off = |pose: &Isometry3<f64>| (pose.rotation.norm() - 1.0).abs();
        if let Some(off) =
            (poses.iter().map(off)).find(|off| off.is_nan() || *off > ROTATION_ROUNDING)
        {
            return Err(ModelError::History(format!(
                "is damaged: a rotation is {off:e} away from being one"
            )));
        }
        if bodies == 0 || !poses.len().is_multiple_of(bodies) || poses.len() > KEPT * bodies {
            return Err(rigid::RigidError::Length {
                what: "poses of the reference meshes",
                expected: bodies,
                found: poses.len(),
            }
            .into());
        }
        poses
            .chunks(bodies)
            .try_for_each(|poses| self.remesh(poses).map(drop))
    }

    fn reference(
        &self,
        mesh: TetMesh,
        centres: Vec<Vector3<f64>>,
        poses: &[Isometry3<f64>],
    ) -> Result<Reference, ModelError> {
        let space = TaylorHood::new(&mesh)?;
        let moving: Vec<MovingBody> = self
            .tags()
            .zip(&centres)
            .map(|(tag, &centre)| MovingBody {
                tag: tag.to_owned(),
                centre,
                rotates: false,
            })
            .collect();
        let gap_ratio = self.mesher.gap_ratio(&mesh, &centres);
        let quality = mesh.quality();
        let map = ReferenceMap::new(mesh, &moving, self.motion.as_ref())?;
        Ok(Reference {
            gap_ratio,
            quality,
            tube: self.mesher.tube(&centres),
            map,
            space,
            surplus: None,
            centres,
            poses: poses.to_vec(),
        })
    }

    /// As [`Mesher::permeability`], with the bodies at `poses`.
    pub fn permeability(&self, mesh: &TetMesh, poses: &[Isometry3<f64>]) -> Option<Vec<f64>> {
        self.mesher.permeability(mesh, &self.mesher.centres(poses))
    }

    /// A reference moved to `poses`, or why that would spoil it.
    fn moved(
        &self,
        reference: &Reference,
        poses: &[Isometry3<f64>],
    ) -> Result<Result<TetMesh, Remesh>, ModelError> {
        let centres = self.mesher.centres(poses);
        if let Some(to_end) = self.to_end(reference, &centres)
            && tube::is_near(to_end)
        {
            return Ok(Err(Remesh::End(to_end)));
        }
        // Only spheres so far: turning one changes nothing, so its surface mesh is only translated.
        let motions: Vec<Isometry3<f64>> = centres
            .iter()
            .zip(&reference.centres)
            .map(|(now, then)| {
                Isometry3::from_parts(Translation3::from(now - then), UnitQuaternion::identity())
            })
            .collect();
        let mesh = match reference.map.moved(&motions) {
            Ok(mesh) => mesh,
            Err(ale::AleError::Invalid(_)) => return Ok(Err(Remesh::Inverted)),
            Err(other) => return Err(other.into()),
        };
        let quality = mesh.quality();
        // A new mesh must not be refused as it is: no other would be better.
        let own = &reference.quality;
        if quality.min_jacobian < LEAST_JACOBIAN.min(KEPT_OF_ITS_OWN * own.min_jacobian) {
            return Ok(Err(Remesh::Jacobian(quality.min_jacobian)));
        }
        if quality.min_quality < LEAST_QUALITY.min(KEPT_OF_ITS_OWN * own.min_quality) {
            return Ok(Err(Remesh::Quality(quality.min_quality)));
        }
        let gap_ratio = self.mesher.gap_ratio(&mesh, &centres);
        if gap_ratio > LARGEST_GAP_RATIO.max(reference.gap_ratio / KEPT_OF_ITS_OWN) {
            return Ok(Err(Remesh::Gap(gap_ratio)));
        }
        Ok(Ok(mesh))
    }
}

/// The mesh motion of a scene.
fn motion(kind: MeshMotionKind) -> Box<dyn MeshMotion> {
    match kind {
        MeshMotionKind::Laplace => Box::new(Harmonic(Stiffening::None)),
        MeshMotionKind::KanchiMasud => Box::new(Harmonic(Stiffening::KanchiMasud)),
        MeshMotionKind::InverseVolume => Box::new(Harmonic(Stiffening::InverseVolume)),
        MeshMotionKind::Elastic => Box::new(Elastic::default()),
        MeshMotionKind::Biharmonic => Box::new(Biharmonic),
        MeshMotionKind::Rbf => Box::new(Rbf(Kernel::Cubic)),
    }
}
