//! Meshes of successive configurations: moved from a reference mesh, or newly generated.

use std::sync::Arc;

use ale::{AleError, MeshMotion};
use fem::{SurplusSpace, TaylorHood};
use mesh::{Surface, TetMesh};
use nalgebra::{Isometry3, Vector3};

use super::cylinder;
use super::far_field::FarField;
use super::mesh_generator::{MeshGenerator, Placement, Source};
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
    motions: Vec<Arc<dyn MeshMotion>>,
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
    /// `placement` is that of all bodies of the scene.
    pub fn boundary_surfaces(&self, placement: &Placement) -> Vec<(&str, Box<dyn Surface>)> {
        self.generator
            .boundary_surfaces(&self.generator.placement(placement))
    }

    /// Relative error of velocities due to the container.
    ///
    /// Zero unless the container replaces unbounded fluid or an infinite cylinder.
    pub fn container_error(&self, placement: &Placement) -> f64 {
        let placement = self.generator.placement(placement);
        if let Some(far) = self.generator.far_field {
            let bodies = self.generator.bounding_balls(&placement).into_iter();
            return far.relative_error(bodies.map(|body| (body.centre, body.radius)));
        }
        let reference = self
            .current
            .and_then(|current| self.references.get(current));
        reference
            .and_then(|reference| reference.end_distance(&self.generator, &placement))
            .map_or(0.0, cylinder::relative_error)
    }

    /// The ball that replaces unbounded fluid, for whose wall velocities are corrected.
    ///
    /// None for the half ball above a plane wall, which needs no correction.
    pub fn far_field(&self) -> Option<FarField> {
        self.generator.far_field.filter(|far| !far.has_plane_wall())
    }

    /// Function spaces on the current mesh.
    ///
    /// # Errors
    /// No current mesh, or one that is too large.
    pub fn space(&self) -> Result<Arc<TaylorHood>, ModelError> {
        let current = self.current.and_then(|k| self.references.get(k));
        current.ok_or(ModelError::NoMesh)?.space()
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

    /// The mesh of a placement of all bodies of the scene.
    ///
    /// It is moved from the oldest reference for which its cells remain good enough, or newly
    /// generated. Because of this order, once the references of a stroke exist, the mesh depends on
    /// the configuration only and not on the previous one. The first references of a file are its
    /// mesh with one method of motion each, so the mesh depends on the configuration only from the
    /// start until the fluid is meshed again.
    ///
    /// # Errors
    /// Bodies around which no mesh can be generated; [`ModelError::MeshFileExhausted`].
    pub fn at(&mut self, placement: &Placement) -> Result<PlacedMesh, ModelError> {
        let mut too_poor = Vec::new();
        let surfaced = self.generator.placement(placement);
        for number in 0..self.references.len() {
            match self.references[number].moved(&self.generator, &surfaced)? {
                Ok(mesh) => {
                    let before = self.current.replace(number);
                    let has_file = |number: usize| number < self.of_file;
                    let has_other_cells = before.is_none_or(|before| {
                        before != number && !(has_file(before) && has_file(number))
                    });
                    return Ok(PlacedMesh {
                        mesh,
                        remeshed: None,
                        has_other_cells,
                    });
                }
                Err(reason) => too_poor.push(reason),
            }
        }
        if let Some(placed) = self.by_other_motion(placement, &surfaced, &mut too_poor)? {
            return Ok(placed);
        }
        let reason = match self.of_file {
            n if n > 0 && n == self.references.len() => Remesh::InsideFile {
                tried: self.tried(&too_poor),
            },
            // Of several references the newest determines the reason.
            _ => too_poor.pop().unwrap_or(Remesh::First),
        };
        let mesh = self.remesh(placement).map_err(|error| match error {
            ModelError::Mesh(source) if self.is_from_file() => ModelError::MeshFileExhausted {
                tried: self.tried(&too_poor),
                source,
            },
            other => other,
        })?;
        Ok(PlacedMesh {
            mesh,
            remeshed: Some(reason),
            has_other_cells: true,
        })
    }

    /// The current mesh in a placement close to the present one, whatever becomes of the quality of
    /// its cells: for derivatives along a path.
    ///
    /// # Errors
    /// No current mesh; poses for which a cell would be inverted.
    pub fn at_by_current(&mut self, placement: &Placement) -> Result<PlacedMesh, ModelError> {
        let reference = self
            .current
            .and_then(|current| self.references.get(current));
        let reference = reference.ok_or(ModelError::NoMesh)?;
        let surfaced = self.generator.placement(placement);
        let mesh = reference.moved_anyway(&self.generator, &surfaced)?;
        Ok(PlacedMesh {
            mesh: Arc::new(mesh),
            remeshed: None,
            has_other_cells: false,
        })
    }

    /// The mesh of the file, moved to a placement by the first method not in use yet that keeps its
    /// cells good enough; none if there is no such method.
    ///
    /// `too_poor` has the reasons why the methods in use do not; those of the others are added.
    ///
    /// # Errors
    /// A mesh that is too large, or whose motion cannot be computed.
    fn by_other_motion(
        &mut self,
        placement: &Placement,
        surfaced: &Placement,
        too_poor: &mut Vec<Remesh>,
    ) -> Result<Option<PlacedMesh>, ModelError> {
        while self.add_motion(placement)? {
            let number = self.references.len() - 1;
            let reference = &self.references[number];
            match reference.moved(&self.generator, surfaced)? {
                Ok(mesh) => {
                    self.current = Some(number);
                    let is_other = number > 0 || !self.unusable.is_empty();
                    let remeshed = is_other.then(|| Remesh::Motion {
                        name: reference.motion(),
                        tried: self.tried(too_poor),
                    });
                    return Ok(Some(PlacedMesh {
                        mesh,
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
            .map(|(reference, reason)| format!("{}: {reason}", reference.motion()));
        let unusable = (self.unusable.iter()).map(|(name, reason)| format!("{name}: {reason}"));
        in_use.chain(unusable).collect::<Vec<_>>().join("; ")
    }

    /// Adds the mesh of the file with the next method of motion that can be used for it.
    ///
    /// Returns false if there is no further method.
    ///
    /// # Errors
    /// A mesh that is too large, or whose motion cannot be computed.
    fn add_motion(&mut self, placement: &Placement) -> Result<bool, ModelError> {
        let Source::File { mesh, .. } = &self.generator.source else {
            return Ok(false);
        };
        loop {
            let next = self.of_file + self.unusable.len();
            let Some(motion) = self.motions.get(next) else {
                return Ok(false);
            };
            let is_only = self.motions.len() == 1;
            let start: Vec<_> = (self.generator.surfaced.iter().map(|s| s.pose)).collect();
            let start = Placement::rigid(&start);
            // The first reference is in use from the start, not from a configuration on.
            let at_start = Placement::default();
            let placement = if self.references.is_empty() {
                &at_start
            } else {
                placement
            };
            let mesh = Arc::new(mesh.clone());
            let reference = ReferenceMesh::new(&self.generator, motion, mesh, start, placement);
            match reference.prepare_motion(&self.generator) {
                Ok(()) => {
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

    /// Generates a reference mesh in a placement of all bodies.
    ///
    /// If there are [`MAX_REFERENCES`] already, the oldest that was generated is discarded.
    ///
    /// # Errors
    /// Bodies around which no mesh can be generated.
    fn remesh(&mut self, placement: &Placement) -> Result<Arc<TetMesh>, ModelError> {
        let surfaced = self.generator.placement(placement);
        let mesh = Arc::new(self.generator.generate(&surfaced)?);
        let (generator, motion, mesh_at) = (&self.generator, &self.motions[0], Arc::clone(&mesh));
        let reference = ReferenceMesh::new(generator, motion, mesh_at, surfaced, placement);
        if self.references.len() == self.of_file + MAX_REFERENCES {
            self.references.remove(self.of_file);
        }
        self.references.push(reference);
        self.current = Some(self.references.len() - 1);
        Ok(mesh)
    }

    /// Replaces all references by an adapted mesh in a placement of all bodies.
    ///
    /// `sizes` are edge lengths at positions in the current mesh. Returns false if meshes cannot be
    /// generated because the mesh comes from a file.
    ///
    /// # Errors
    /// Sizes that are not positive, bodies around which no mesh can be generated.
    pub fn adapt(
        &mut self,
        placement: &Placement,
        sizes: Vec<(Vector3<f64>, f64)>,
    ) -> Result<bool, ModelError> {
        if self.is_from_file() {
            return Ok(false);
        }
        let surfaced = self.generator.placement(placement);
        self.generator.adapt(&surfaced, sizes)?;
        // Earlier references have other element sizes.
        self.references.clear();
        self.remesh(placement)?;
        self.current = None;
        Ok(true)
    }

    /// Poses of all references and the values of the joints, one reference after the other, for
    /// [`Meshes::restore`].
    pub fn reference_placements(&self) -> Placement {
        let placements = self.references.iter().map(|reference| &reference.placement);
        let mut all = Placement::default();
        for placement in placements {
            all.poses.extend(&placement.poses);
            all.values.extend(&placement.values);
        }
        all
    }

    /// Generates the references of an earlier run again, bitwise the same.
    ///
    /// # Errors
    /// Poses of another number of bodies, or values of another number of joints, around which no
    /// mesh can be generated, or of more references than there can be.
    pub fn restore(&mut self, placements: &Placement) -> Result<(), ModelError> {
        let Placement { poses, values } = placements;
        let bodies = self.generator.tags.len();
        // The references already exist.
        if *placements == self.reference_placements() {
            return Ok(());
        }
        self.references.clear();
        self.of_file = 0;
        self.unusable.clear();
        self.current = None;
        check_rotations(poses)?;
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
            self.add_motion(&Placement::default())?;
        }
        let count = poses.len() / bodies;
        let joints = self.generator.deforming_joints;
        if values.len() != count * joints {
            return Err(rigid::RigidError::Length {
                what: "values of the joints of the reference meshes",
                expected: count * joints,
                found: values.len(),
            }
            .into());
        }
        for (number, poses) in poses.chunks(bodies).enumerate() {
            let placement = Placement {
                poses: poses.to_vec(),
                values: values[number * joints..(number + 1) * joints].to_vec(),
            };
            // The mesh of a file was generated again only after all methods to move it were in use.
            if !self.add_motion(&placement)? {
                self.remesh(&placement)?;
            }
        }
        Ok(())
    }

    /// Permeability of each cell ([`MeshGenerator::permeability`]) in a placement of all bodies.
    pub fn permeability(&self, mesh: &TetMesh, placement: &Placement) -> Option<Vec<f64>> {
        let surfaced = self.generator.placement(placement);
        self.generator.permeability(mesh, &surfaced)
    }
}

/// Refuses poses of an earlier run whose rotations are none.
///
/// # Errors
/// [`ModelError::History`].
pub(super) fn check_rotations(poses: &[Isometry3<f64>]) -> Result<(), ModelError> {
    let mut deviations = (poses.iter()).map(|pose| (pose.rotation.norm() - 1.0).abs());
    match deviations.find(|deviation| deviation.is_nan() || *deviation > ROTATION_ROUNDING) {
        None => Ok(()),
        Some(deviation) => Err(ModelError::History(format!(
            "is damaged: the norm of a rotation differs from 1 by {deviation:e}"
        ))),
    }
}
