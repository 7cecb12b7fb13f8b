//! Meshes of successive configurations: moved from a reference mesh, or newly generated.

use ale::MeshMotion;
use fem::{SurplusSpace, TaylorHood};
use mesh::{Sphere, TetMesh};
use nalgebra::{Isometry3, Vector3};

use super::cylinder;
use super::far_field::FarField;
use super::mesh_generator::{MeshGenerator, Source};
use super::reference_mesh::{ReferenceMesh, mesh_motion};
use crate::units::Scale;
use crate::{ModelError, Remesh};
use scene::Scene;

/// Distance from a symmetry plane, in radii, that counts as rounding error of many steps.
///
/// Bodies that are farther away from the plane are refused.
const PLANE_ROUNDING: f64 = 1e-9;

/// Deviation of the norm of a quaternion from 1 due to writing it to a file.
const ROTATION_ROUNDING: f64 = 1e-9;

/// Maximum number of reference meshes.
///
/// Strokes return to earlier shapes, so the reference meshes of one cycle serve the next one. Each
/// takes about a third of the memory of a solve.
const MAX_REFERENCES: usize = 3;

/// Meshes for the configurations of one scene, in scaled units.
pub struct Meshes {
    generator: MeshGenerator,
    motion: Box<dyn MeshMotion>,
    /// In the order in which they were generated.
    references: Vec<ReferenceMesh>,
    /// Index of the reference of the current mesh; `None` before the first and after adapting.
    current: Option<usize>,
}

/// The mesh of one configuration.
pub struct PlacedMesh {
    pub mesh: TetMesh,
    /// Why it was newly generated; `None` if it was moved.
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
        Ok(Self {
            generator: MeshGenerator::new(scene, scale)?,
            motion: mesh_motion(scene.fem().mesh_motion),
            references: Vec::new(),
            current: None,
        })
    }

    /// Names of the boundary parts of the bodies with surfaces.
    pub fn tags(&self) -> impl Iterator<Item = &str> {
        self.generator.tags()
    }

    /// Indices in the scene of the bodies with surfaces.
    pub fn surfaced_bodies(&self) -> impl Iterator<Item = usize> {
        self.generator.surfaced_bodies()
    }

    /// Moves bodies onto the symmetry planes that they are off by rounding errors only.
    pub fn snap_to_symmetry_planes(&self, poses: &mut [Isometry3<f64>]) {
        for pose in poses {
            for axis in (0..3).filter(|&axis| self.generator.symmetry_planes[axis]) {
                let x = &mut pose.translation.vector[axis];
                if x.abs() <= PLANE_ROUNDING {
                    *x = 0.0;
                }
            }
        }
    }

    /// Names of the boundary parts that are walls.
    pub fn wall_tags(&self) -> Vec<&str> {
        self.generator.wall_tags()
    }

    /// Spheres that are approximated by straight facets, with the names of their boundary parts.
    ///
    /// The bodies with surfaces are at `centres`.
    pub fn straight_spheres(&self, centres: &[Vector3<f64>]) -> Vec<(&str, Sphere)> {
        self.generator.straight_spheres(centres)
    }

    /// Relative error of velocities due to the container.
    ///
    /// Zero unless the container replaces unbounded fluid or an infinite cylinder.
    pub fn container_error(&self, poses: &[Isometry3<f64>]) -> f64 {
        let centres = self.generator.centres(poses);
        if let Some(far) = self.generator.far_field {
            let bodies = self.generator.spheres(&centres).into_iter();
            return far.relative_error(bodies.map(|body| (body.centre, body.radius)));
        }
        let reference = self
            .current
            .and_then(|current| self.references.get(current));
        reference
            .and_then(|reference| reference.end_distance(&self.generator, &centres))
            .map_or(0.0, cylinder::relative_error)
    }

    /// The ball that replaces unbounded fluid, if the fluid is unbounded.
    pub fn far_field(&self) -> Option<FarField> {
        self.generator.far_field
    }

    /// Function spaces on the current mesh.
    pub fn space(&self) -> Option<&TaylorHood> {
        let reference = self.references.get(self.current?)?;
        Some(&reference.space)
    }

    /// Space for error estimates on the current mesh, after [`Meshes::prepare_estimates`].
    pub fn surplus_space(&self) -> Option<&SurplusSpace> {
        self.references.get(self.current?)?.surplus.as_ref()
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
    /// the configuration only and not on the previous one.
    ///
    /// # Errors
    /// Bodies around which no mesh can be generated; [`ModelError::MeshFileExhausted`].
    pub fn at(&mut self, poses: &[Isometry3<f64>]) -> Result<PlacedMesh, ModelError> {
        let generator = &self.generator;
        if let (true, Source::File { mesh, .. }) = (self.references.is_empty(), &generator.source) {
            let centres = generator.surfaced.iter().map(|s| s.position).collect();
            let reference = self.reference(mesh.clone(), centres, &[])?;
            self.references.push(reference);
        }
        let mut reason = Remesh::First;
        let centres = self.generator.centres(poses);
        for number in 0..self.references.len() {
            match self.references[number].moved(&self.generator, &centres)? {
                Ok(mesh) => {
                    let has_other_cells = self.current != Some(number);
                    self.current = Some(number);
                    return Ok(PlacedMesh {
                        mesh,
                        remeshed: None,
                        has_other_cells,
                    });
                }
                // Of several references the newest determines the reason.
                Err(too_poor) => reason = too_poor,
            }
        }
        if let Source::File { .. } = &self.generator.source {
            return Err(ModelError::MeshFileExhausted);
        }
        let mesh = self.remesh(poses)?;
        Ok(PlacedMesh {
            mesh,
            remeshed: Some(reason),
            has_other_cells: true,
        })
    }

    /// Generates a reference mesh with the bodies at `poses`.
    ///
    /// If there are [`MAX_REFERENCES`] already, the oldest is discarded.
    ///
    /// # Errors
    /// Bodies around which no mesh can be generated.
    fn remesh(&mut self, poses: &[Isometry3<f64>]) -> Result<TetMesh, ModelError> {
        let centres = self.generator.centres(poses);
        let mesh = self.generator.generate(&centres)?;
        let reference = self.reference(mesh.clone(), centres, poses)?;
        if self.references.len() == MAX_REFERENCES {
            self.references.remove(0);
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
        if let Source::File { .. } = &self.generator.source {
            return Ok(false);
        }
        self.generator
            .adapt(&self.generator.centres(poses), sizes)?;
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
    /// Poses of another number of bodies, or around which no mesh can be generated.
    pub fn restore(&mut self, poses: &[Isometry3<f64>]) -> Result<(), ModelError> {
        let bodies = self.generator.tags.len();
        // The references already exist.
        if poses == self.reference_poses() {
            return Ok(());
        }
        self.references.clear();
        self.current = None;
        let deviation = |pose: &Isometry3<f64>| (pose.rotation.norm() - 1.0).abs();
        if let Some(deviation) = (poses.iter().map(deviation))
            .find(|deviation| deviation.is_nan() || *deviation > ROTATION_ROUNDING)
        {
            return Err(ModelError::History(format!(
                "is damaged: the norm of a rotation differs from 1 by {deviation:e}"
            )));
        }
        if bodies == 0
            || !poses.len().is_multiple_of(bodies)
            || poses.len() > MAX_REFERENCES * bodies
        {
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

    /// Permeability of each cell ([`MeshGenerator::permeability`]), with the bodies at `poses`.
    pub fn permeability(&self, mesh: &TetMesh, poses: &[Isometry3<f64>]) -> Option<Vec<f64>> {
        let centres = self.generator.centres(poses);
        self.generator.permeability(mesh, &centres)
    }

    fn reference(
        &self,
        mesh: TetMesh,
        centres: Vec<Vector3<f64>>,
        poses: &[Isometry3<f64>],
    ) -> Result<ReferenceMesh, ModelError> {
        ReferenceMesh::new(&self.generator, self.motion.as_ref(), mesh, centres, poses)
    }
}
