//! Meshes of successive configurations: moved from a reference mesh, or newly generated.

use std::sync::Arc;

use ale::{AleError, MeshMotion};
use fem::{SurplusSpace, TaylorHood};
use mesh::{Surface, TetMesh};
use nalgebra::{Isometry3, Vector3};

use super::cylinder;
use super::far_field::FarField;
use super::mesh_generator::{MeshGenerator, Source};
use super::reference_mesh::{ReferenceMesh, mesh_motions};
use crate::units::Scale;
use crate::{ModelError, Remesh};
use scene::Scene;

/// Deviation of the norm of a quaternion from 1 due to writing it to a file.
const ROTATION_ROUNDING: f64 = 1e-9;

/// Maximum number of reference meshes.
///
/// Strokes return to earlier shapes, so the reference meshes of one cycle serve the next one. Each
/// takes about a third of the memory of a solve.
const MAX_REFERENCES: usize = 3;

/// Meshes for the configurations of one scene, in scaled units.
pub struct Meshes {
    pub generator: MeshGenerator,
    /// Methods by which meshes move, in the order in which they are tried.
    ///
    /// Several only for the mesh of a file, which is generated again only if none is good enough.
    motions: Vec<Box<dyn MeshMotion>>,
    /// In the order in which they were generated. The first [`Meshes::of_file`] have the mesh of a
    /// file, one per method in use.
    references: Vec<ReferenceMesh>,
    /// Number of the references with the mesh of a file.
    of_file: usize,
    /// Methods that cannot be used for the mesh of a file, with the reasons.
    unusable: Vec<(&'static str, String)>,
    /// Index of the reference of the current mesh; `None` before the first and after adapting.
    current: Option<usize>,
}

/// The mesh of one configuration.
pub struct PlacedMesh {
    pub mesh: Arc<TetMesh>,
    /// Why it was newly generated or moved by another method; `None` if it was moved as before.
    pub remeshed: Option<Remesh>,
    /// Whether its cells differ from those of the mesh before.
    pub has_other_cells: bool,
}

impl Meshes {
    /// Prepares meshes for a scene.
    ///
    /// # Errors
    /// Those of [`MeshGenerator::new`].
    pub fn new(scene: &Scene, scale: &Scale) -> Result<Self, ModelError> {
        let generator = MeshGenerator::new(scene, scale)?;
        let is_from_file = matches!(generator.source, Source::File { .. });
        Ok(Self {
            motions: mesh_motions(scene.fem().mesh_motion, is_from_file),
            generator,
            references: Vec::new(),
            of_file: 0,
            unusable: Vec::new(),
            current: None,
        })
    }

    /// Smooth surfaces on the boundary of the fluid, with the names of their boundary parts.
    ///
    /// The bodies of the scene are at `poses`.
    pub fn boundary_surfaces(&self, poses: &[Isometry3<f64>]) -> Vec<(&str, Box<dyn Surface>)> {
        self.generator
            .boundary_surfaces(&self.generator.poses(poses))
    }

    /// Relative error of velocities due to the container.
    ///
    /// Zero unless the container replaces unbounded fluid or an infinite cylinder.
    pub fn container_error(&self, poses: &[Isometry3<f64>]) -> f64 {
        let poses = self.generator.poses(poses);
        if let Some(far) = self.generator.far_field {
            let bodies = self.generator.bounding_balls(&poses).into_iter();
            return far.relative_error(bodies.map(|body| (body.centre, body.radius)));
        }
        let reference = self
            .current
            .and_then(|current| self.references.get(current));
        reference
            .and_then(|reference| reference.end_distance(&self.generator, &poses))
            .map_or(0.0, cylinder::relative_error)
    }

    /// The ball that replaces unbounded fluid, for whose wall velocities are corrected.
    ///
    /// None for the half ball above a plane wall, which needs no correction.
    pub fn far_field(&self) -> Option<FarField> {
        self.generator.far_field.filter(|far| !far.has_plane_wall())
    }

    /// Function spaces on the current mesh.
    pub fn space(&self) -> Option<Arc<TaylorHood>> {
        let reference = self.references.get(self.current?)?;
        Some(reference.space.clone())
    }

    /// Space for error estimates on the current mesh, after [`Meshes::prepare_estimates`].
    pub fn surplus_space(&self) -> Option<Arc<SurplusSpace>> {
        self.references.get(self.current?)?.surplus.clone()
    }

    /// Creates the space for error estimates on the current mesh.
    ///
    /// # Errors
    /// A mesh with too many cells.
    pub fn prepare_estimates(&mut self) -> Result<(), ModelError> {
        let current = self.current.and_then(|k| self.references.get_mut(k));
        current.map_or(Ok(()), ReferenceMesh::prepare_estimates)
    }

    /// The mesh with the bodies at `poses`, one per body of the scene.
    ///
    /// It is moved from the oldest reference for which its cells remain good enough, or newly
    /// generated. Because of this order, once the references of a stroke exist, the mesh depends on
    /// the configuration only and not on the previous one. The first references of a file are its
    /// mesh with one method of motion each, so the mesh depends on the configuration only from the
    /// start until the fluid is meshed again.
    ///
    /// # Errors
    /// Bodies around which no mesh can be generated; [`ModelError::MeshFileExhausted`].
    pub fn at(&mut self, poses: &[Isometry3<f64>]) -> Result<PlacedMesh, ModelError> {
        let mut too_poor = Vec::new();
        let surfaced = self.generator.poses(poses);
        for number in 0..self.references.len() {
            match self.references[number].moved(&self.generator, &surfaced)? {
                Ok(mesh) => {
                    let before = self.current.replace(number);
                    let has_file = |number: usize| number < self.of_file;
                    let has_other_cells = before.is_none_or(|before| {
                        before != number && !(has_file(before) && has_file(number))
                    });
                    return Ok(PlacedMesh {
                        mesh: Arc::new(mesh),
                        remeshed: None,
                        has_other_cells,
                    });
                }
                Err(reason) => too_poor.push(reason),
            }
        }
        if let Some(placed) = self.by_other_motion(poses, &surfaced, &mut too_poor)? {
            return Ok(placed);
        }
        let reason = match self.of_file {
            n if n > 0 && n == self.references.len() => Remesh::InsideFile {
                tried: self.tried(&too_poor),
            },
            // Of several references the newest determines the reason.
            _ => too_poor.pop().unwrap_or(Remesh::First),
        };
        let mesh = self.remesh(poses).map_err(|error| match error {
            ModelError::Mesh(source) if self.is_from_file() => ModelError::MeshFileExhausted {
                tried: self.tried(&too_poor),
                source,
            },
            other => other,
        })?;
        Ok(PlacedMesh {
            mesh: Arc::new(mesh),
            remeshed: Some(reason),
            has_other_cells: true,
        })
    }

    /// The current mesh with the bodies at `poses` close to the present ones, whatever becomes of
    /// the quality of its cells: for derivatives along a path.
    ///
    /// # Errors
    /// No current mesh; poses for which a cell would be inverted.
    pub fn at_by_current(&mut self, poses: &[Isometry3<f64>]) -> Result<PlacedMesh, ModelError> {
        let reference = self
            .current
            .and_then(|current| self.references.get(current));
        let reference = reference.ok_or(ModelError::NoMesh)?;
        let mesh = reference.moved_anyway(&self.generator, &self.generator.poses(poses))?;
        Ok(PlacedMesh {
            mesh: Arc::new(mesh),
            remeshed: None,
            has_other_cells: false,
        })
    }

    /// The mesh of the file, moved to `poses` by the first method not in use yet that keeps its
    /// cells good enough; none if there is no such method.
    ///
    /// `too_poor` has the reasons why the methods in use do not; those of the others are added.
    ///
    /// # Errors
    /// A mesh that is too large, or whose motion cannot be computed.
    fn by_other_motion(
        &mut self,
        poses: &[Isometry3<f64>],
        surfaced: &[Isometry3<f64>],
        too_poor: &mut Vec<Remesh>,
    ) -> Result<Option<PlacedMesh>, ModelError> {
        while self.add_motion(poses)? {
            let number = self.references.len() - 1;
            let reference = &self.references[number];
            match reference.moved(&self.generator, surfaced)? {
                Ok(mesh) => {
                    self.current = Some(number);
                    let is_other = number > 0 || !self.unusable.is_empty();
                    let remeshed = is_other.then(|| Remesh::Motion {
                        name: reference.motion,
                        tried: self.tried(too_poor),
                    });
                    return Ok(Some(PlacedMesh {
                        mesh: Arc::new(mesh),
                        remeshed,
                        has_other_cells: false,
                    }));
                }
                Err(reason) => too_poor.push(reason),
            }
        }
        Ok(None)
    }

    /// Methods that move the mesh of the file, each with the reason why it is not good enough.
    fn tried(&self, too_poor: &[Remesh]) -> String {
        let of_file = self.references.iter().take(self.of_file);
        let in_use = (of_file.zip(too_poor))
            .map(|(reference, reason)| format!("{}: {reason}", reference.motion));
        let unusable = (self.unusable.iter()).map(|(name, reason)| format!("{name}: {reason}"));
        in_use.chain(unusable).collect::<Vec<_>>().join("; ")
    }

    /// Adds the mesh of the file with the next method of motion that can be used for it.
    ///
    /// Returns false if there is no further method.
    ///
    /// # Errors
    /// A mesh that is too large, or whose motion cannot be computed.
    fn add_motion(&mut self, poses: &[Isometry3<f64>]) -> Result<bool, ModelError> {
        let Source::File { mesh, .. } = &self.generator.source else {
            return Ok(false);
        };
        loop {
            let next = self.of_file + self.unusable.len();
            let Some(motion) = self.motions.get(next) else {
                return Ok(false);
            };
            let is_only = self.motions.len() == 1;
            let start = (self.generator.surfaced.iter().map(|s| s.pose)).collect();
            // The first reference is in use from the start, not from a configuration on.
            let poses = if self.references.is_empty() {
                &[]
            } else {
                poses
            };
            let motion = motion.as_ref();
            match ReferenceMesh::new(&self.generator, motion, mesh.clone(), start, poses) {
                Ok(reference) => {
                    self.references.push(reference);
                    self.of_file += 1;
                    return Ok(true);
                }
                Err(ModelError::Ale(
                    error @ (AleError::TooManyCentres { .. }
                    | AleError::Singular
                    | AleError::Linalg(_)),
                )) if !is_only => self.unusable.push((motion.name(), error.to_string())),
                Err(other) => return Err(other),
            }
        }
    }

    fn is_from_file(&self) -> bool {
        matches!(self.generator.source, Source::File { .. })
    }

    /// Generates a reference mesh with the bodies at `poses`.
    ///
    /// If there are [`MAX_REFERENCES`] already, the oldest that was generated is discarded.
    ///
    /// # Errors
    /// Bodies around which no mesh can be generated.
    fn remesh(&mut self, poses: &[Isometry3<f64>]) -> Result<TetMesh, ModelError> {
        let surfaced = self.generator.poses(poses);
        let mesh = self.generator.generate(&surfaced)?;
        let motion = self.motions[0].as_ref();
        let reference = ReferenceMesh::new(&self.generator, motion, mesh.clone(), surfaced, poses)?;
        if self.references.len() == self.of_file + MAX_REFERENCES {
            self.references.remove(self.of_file);
        }
        self.references.push(reference);
        self.current = Some(self.references.len() - 1);
        Ok(mesh)
    }

    /// Replaces all references by an adapted mesh with the bodies at `poses`.
    ///
    /// `sizes` are edge lengths at positions in the current mesh. Returns false if meshes cannot be
    /// generated because the mesh comes from a file.
    ///
    /// # Errors
    /// Sizes that are not positive, bodies around which no mesh can be generated.
    pub fn adapt(
        &mut self,
        poses: &[Isometry3<f64>],
        sizes: Vec<(Vector3<f64>, f64)>,
    ) -> Result<bool, ModelError> {
        if self.is_from_file() {
            return Ok(false);
        }
        self.generator.adapt(&self.generator.poses(poses), sizes)?;
        // Earlier references have other element sizes.
        self.references.clear();
        self.remesh(poses)?;
        self.current = None;
        Ok(true)
    }

    /// Poses of all references, one reference after the other, for [`Meshes::restore`].
    pub fn reference_poses(&self) -> Vec<Isometry3<f64>> {
        self.references
            .iter()
            .flat_map(|reference| reference.poses.iter().copied())
            .collect()
    }

    /// Generates the references of an earlier run again, bitwise the same.
    ///
    /// # Errors
    /// Poses of another number of bodies, around which no mesh can be generated, or of more
    /// references than there can be.
    pub fn restore(&mut self, poses: &[Isometry3<f64>]) -> Result<(), ModelError> {
        let bodies = self.generator.tags.len();
        // The references already exist.
        if poses == self.reference_poses() {
            return Ok(());
        }
        self.references.clear();
        self.of_file = 0;
        self.unusable.clear();
        self.current = None;
        let deviation = |pose: &Isometry3<f64>| (pose.rotation.norm() - 1.0).abs();
        if let Some(deviation) = (poses.iter().map(deviation))
            .find(|deviation| deviation.is_nan() || *deviation > ROTATION_ROUNDING)
        {
            return Err(ModelError::History(format!(
                "is damaged: the norm of a rotation differs from 1 by {deviation:e}"
            )));
        }
        // The mesh of a file, moved by the first method, is a reference without poses.
        let most = MAX_REFERENCES + usize::from(self.is_from_file()) * (self.motions.len() - 1);
        if bodies == 0 || !poses.len().is_multiple_of(bodies) || poses.len() > most * bodies {
            return Err(rigid::RigidError::Length {
                what: "poses of the reference meshes",
                expected: bodies,
                found: poses.len(),
            }
            .into());
        }
        if self.is_from_file() {
            self.add_motion(&[])?;
        }
        for poses in poses.chunks(bodies) {
            // The mesh of a file was generated again only after all methods to move it were in use.
            if !self.add_motion(poses)? {
                self.remesh(poses)?;
            }
        }
        Ok(())
    }

    /// Permeability of each cell ([`MeshGenerator::permeability`]), with the bodies at `poses`.
    pub fn permeability(&self, mesh: &TetMesh, poses: &[Isometry3<f64>]) -> Option<Vec<f64>> {
        let poses = self.generator.poses(poses);
        self.generator.permeability(mesh, &poses)
    }
}
