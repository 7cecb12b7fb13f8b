//! A scene in scaled units for integrations in time that keep the velocity of the fluid.

use std::sync::Arc;

use ale::MeshMotion;
use fem::TaylorHood;
use mesh::{Surface, TetMesh};
use nalgebra::{Isometry3, Matrix3, Vector3, Vector6};
use rigid::{Articulation, Constraints, ExternalLoad, RigidError, StateVelocity};
use serde::{Deserialize, Serialize};
use stokes::{Options, Solution};

use super::mesh_generator::{MeshGenerator, Placement, Source};
use super::meshes::check_rotations;
use super::reference_mesh::{ReferenceMesh, mesh_motions};
use super::scene_solution::{ScaledFlow, ToScene};
use super::{law_in_space, solver_options};
use crate::error::ModelError;
use crate::scaled_scene::ScaledScene;
use crate::solution::InstantaneousSolution;
use crate::surface_motion::SurfaceMotion;
use scene::rheology::Law;
use scene::{Domain, EstimatesKind, Scene, Slip, SolverKind};

/// Bodies, loads, slip and walls of a scene in scaled units, for an integration in time of fluid
/// and bodies together.
///
/// Models answer for one instant ([`Hydrodynamics`](crate::Hydrodynamics)). A fluid with inertia
/// remembers its velocity, so its integrator needs the parts of the problem instead: lengths are
/// divided by the smallest radius, the viscosity is 1, and times are those of the scene.
pub struct MovingScene {
    scaled: ScaledScene,
    law: Option<Law>,
    /// Slip of each body with a surface, and the surface centred at the origin; none without slip.
    slips: Vec<Option<(Slip, Box<dyn Surface>)>>,
    surface_names: Vec<String>,
    walls: Vec<String>,
    /// Factor on the element sizes of its meshes.
    coarsening: f64,
}

/// Whether a law has the viscosity 1 at all shear rates, up to rounding by the scale.
fn is_newtonian(law: &Law) -> bool {
    const ROUNDING: f64 = 1e-12;
    let viscosity = law.constant_viscosity();
    viscosity.is_some_and(|viscosity| (viscosity - 1.0).abs() <= ROUNDING)
}

impl MovingScene {
    /// Scales a scene.
    ///
    /// # Errors
    /// Joints or fixed bodies that contradict each other; a mesh file that cannot be read; a power
    /// law of an index that elements in space do not have.
    pub fn new(scene: &Scene) -> Result<Self, ModelError> {
        let scaled = ScaledScene::new(scene)?;
        let generator = MeshGenerator::new(scene, &scaled.scale)?;
        let centred = Isometry3::identity();
        let slip = |body: usize| {
            let body = &scene.bodies()[body];
            body.slip.zip(scaled.scale.surface(&body.shape, &centred))
        };
        Ok(Self {
            slips: scaled.surfaced().map(slip).collect(),
            surface_names: generator.tags().map(str::to_owned).collect(),
            law: law_in_space(&scaled)?.filter(|law| !is_newtonian(law)),
            walls: (generator.wall_tags().into_iter().map(str::to_owned)).collect(),
            scaled,
            coarsening: 1.0,
        })
    }

    /// Refuses a linear solver that needs symmetric equations, which convection makes unsymmetric.
    ///
    /// # Errors
    /// [`ModelError::Unsupported`].
    pub fn check_convection(scene: &Scene) -> Result<(), ModelError> {
        let (key, solver) = ("fem.solver", scene.fem().solver);
        match solver {
            SolverKind::Block => Ok(()),
            _ => Err(ModelError::unsupported(
                format!(
                    "{}: {key} = \"{}\" with convection",
                    scene.place(key),
                    solver.word()
                ),
                "set fem.solver = \"block\", or fluid.inertia = \"unsteady\" for a run",
            )),
        }
    }

    /// The same with all element sizes of generated meshes multiplied by a factor, on bodies and
    /// far from them, for an estimate of the error of the mesh.
    ///
    /// None for the mesh of a file, and for a scene that asks for no estimates.
    ///
    /// # Errors
    /// Those of [`MovingScene::new`].
    pub fn coarser(scene: &Scene, factor: f64) -> Result<Option<Self>, ModelError> {
        let is_file = matches!(scene.domain(), Domain::Mesh { .. });
        if is_file || scene.fem().estimates == EstimatesKind::Off {
            return Ok(None);
        }
        Ok(Some(Self {
            coarsening: factor,
            ..Self::new(scene)?
        }))
    }

    /// The same with the regularisation of the viscosity law multiplied by a factor, for an
    /// estimate of its effect.
    #[must_use]
    pub fn regularised(self, factor: f64) -> Self {
        Self {
            law: self.law.map(|law| law.regularised(factor)),
            ..self
        }
    }

    /// The scene, in its own units.
    pub fn scene(&self) -> &Scene {
        &self.scaled.scene
    }

    /// Bodies and joints.
    pub fn set(&self) -> &Articulation {
        &self.scaled.set
    }

    /// Names of the boundary parts of the bodies with a surface.
    pub fn surface_names(&self) -> &[String] {
        &self.surface_names
    }

    /// Names of the boundary parts that are walls.
    pub fn walls(&self) -> &[String] {
        &self.walls
    }

    /// Indices of the bodies with a surface.
    pub fn surfaced(&self) -> impl Iterator<Item = usize> {
        self.scaled.surfaced()
    }

    /// A length or velocity in scaled units.
    pub fn length(&self, length: f64) -> f64 {
        self.scaled.scale.length(length)
    }

    /// A length or velocity in the units of the scene.
    pub fn length_to_scene(&self, length: f64) -> f64 {
        self.scaled.scale.length_to_scene(length)
    }

    /// A power or an energy in the units of the scene, whose times are kept.
    pub fn power_to_scene(&self, power: f64) -> f64 {
        self.scaled.scale.power_to_scene(power)
    }

    /// Forces and torques of all bodies in the units of the scene, from those of bodies with a
    /// surface.
    pub fn forces_to_scene(&self, forces: &[Vector6<f64>]) -> Vec<[Vector3<f64>; 2]> {
        let scale = &self.scaled.scale;
        let mut all = vec![[Vector3::zeros(); 2]; self.scene().bodies().len()];
        for (body, force) in self.surfaced().zip(forces) {
            let [linear, angular] = [0, 3].map(|first| force.fixed_rows::<3>(first).into_owned());
            all[body] = [scale.force_to_scene(linear), scale.torque_to_scene(angular)];
        }
        all
    }

    /// Density of the fluid, `ρ L² / μ`: a velocity diffuses over the smallest radius `L` in this
    /// time.
    pub fn density(&self) -> f64 {
        self.scaled.scale.density(self.scene().fluid_density())
    }

    /// Viscosity law of the fluid; none for a Newtonian fluid, also where a law has one viscosity.
    pub fn law(&self) -> Option<&Law> {
        self.law.as_ref()
    }

    /// Masses and moments of inertia of all bodies, in their axes; zero for bodies without.
    pub fn masses(&self) -> Vec<(f64, Matrix3<f64>)> {
        let scaled = |body: &scene::Body| {
            let (mass, inertia) = body.mass_matrix_by_density().unwrap_or_default();
            self.scaled.scale.mass(mass, &inertia)
        };
        self.scene().bodies().iter().map(scaled).collect()
    }

    /// Values of the joints from those of the scene.
    pub fn shape(&self, shape: &[f64]) -> Vec<f64> {
        self.scaled.values(shape)
    }

    /// External loads on all bodies at a time, with these scaled poses.
    pub fn loads(&self, time: f64, poses: &[Isometry3<f64>]) -> Vec<ExternalLoad> {
        self.scaled.loads_at(time, poses)
    }

    /// The constraints of the joints with the given velocities of bodies and the forces on joints
    /// at a time.
    ///
    /// # Errors
    /// Those of [`Constraints::with_held_velocity`].
    pub fn constraints(&self, time: f64, joints: Constraints) -> Result<Constraints, RigidError> {
        self.scaled.with_drives(time, joints)
    }

    /// Whether surfaces move relative to their bodies.
    pub fn has_slip(&self) -> bool {
        self.scene().has_surface_velocity()
    }

    /// Slip of a body with a surface at a point relative to its centre, both in its axes.
    pub fn slip(&self, number: usize, x: &Vector3<f64>) -> Vector3<f64> {
        match &self.slips[number] {
            Some((slip, surface)) => (self.scaled.scale).length(slip.velocity(&surface.normal(*x))),
            None => Vector3::zeros(),
        }
    }

    /// A change of the state in the units of the scene.
    pub fn motion_to_scene(&self, motion: &StateVelocity) -> StateVelocity {
        let passive = self.scaled.set.passive_joints();
        self.scaled.scale.motion_to_scene(motion, passive)
    }

    /// Formulation, linear solver and tolerance of the scene.
    pub fn options(&self) -> Options {
        solver_options(self.scene().fem())
    }

    /// A solution at a time in the units of the scene; with its flow if there is a mesh of it.
    ///
    /// `poses` are those of the bodies, in scaled units.
    ///
    /// # Errors
    /// A solution for another set of bodies.
    pub fn answer(
        &self,
        solved: &mut Solution,
        poses: &[Isometry3<f64>],
        time: f64,
        mesh: Option<TetMesh>,
    ) -> Result<InstantaneousSolution, ModelError> {
        let converter = ToScene {
            scaled: &self.scaled,
            time,
            far_field: None,
            container_error: 0.0,
        };
        let mut answer = converter.answer(solved, &[])?;
        answer.flow = mesh.map(|mesh| {
            let flow = ScaledFlow {
                mesh: Arc::new(mesh),
                flow: solved.flow.clone(),
                motion: SurfaceMotion::new(&self.scaled, poses, &[]),
                frame: None,
                scale: self.scaled.scale,
            };
            flow.into()
        });
        Ok(answer)
    }

    /// Meshes of the scene that move with the bodies.
    ///
    /// # Errors
    /// A mesh file that cannot be read.
    pub fn meshes(&self) -> Result<MovingMeshes, ModelError> {
        let scene = self.scene();
        let generator = MeshGenerator::new(scene, &self.scaled.scale)?.coarsened(self.coarsening);
        let is_from_file = matches!(generator.source, Source::File { .. });
        let motion = mesh_motions(scene.fem().mesh_motion, is_from_file).swap_remove(0);
        Ok(MovingMeshes {
            generator,
            motion,
            reference: None,
            is_generated: false,
        })
    }
}

/// The meshes of one integration in time: of one connectivity until there is a new one.
pub struct MovingMeshes {
    generator: MeshGenerator,
    motion: Arc<dyn MeshMotion>,
    reference: Option<ReferenceMesh>,
    /// Whether the reference was generated, and is not the mesh of a file.
    is_generated: bool,
}

/// What the present meshes of an integration in time are moved from.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct MeshOrigin {
    /// Scaled poses of the bodies with a surface around which the mesh was generated.
    poses: Vec<Isometry3<f64>>,
    is_generated: bool,
}

impl MovingMeshes {
    /// The mesh around bodies with a surface at these poses, moved from that before; none if its
    /// cells become too poor.
    ///
    /// # Errors
    /// Bodies around which there is no first mesh; a motion that fails for another reason.
    pub fn moved(&mut self, poses: &[Isometry3<f64>]) -> Result<Option<TetMesh>, ModelError> {
        let placement = self.snapped(poses);
        match &self.reference {
            Some(reference) => {
                let mesh = reference.moved(&self.generator, &placement)?.ok();
                Ok(mesh.map(Arc::unwrap_or_clone))
            }
            None => {
                let is_from_file = matches!(self.generator.source, Source::File { .. });
                self.new_mesh(placement, !is_from_file).map(Some)
            }
        }
    }

    /// A new mesh around bodies with a surface at these poses.
    ///
    /// # Errors
    /// Bodies around which no mesh can be generated.
    pub fn renewed(&mut self, poses: &[Isometry3<f64>]) -> Result<TetMesh, ModelError> {
        self.new_mesh(self.snapped(poses), true)
    }

    /// The space on the cells of the present meshes; none before the first.
    pub fn space(&self) -> Option<Arc<TaylorHood>> {
        // A mesh with a space that cannot be created was refused.
        self.reference.as_ref()?.space().ok()
    }

    /// What the present meshes are moved from; none before the first.
    pub fn origin(&self) -> Option<MeshOrigin> {
        self.reference.as_ref().map(|reference| MeshOrigin {
            poses: reference.surfaced().poses.clone(),
            is_generated: self.is_generated,
        })
    }

    /// Generates the mesh of an earlier run again, bitwise the same, from which meshes are moved
    /// from now on.
    ///
    /// # Errors
    /// [`ModelError::History`] for poses that do not fit the scene, poses around which no mesh can
    /// be generated.
    pub fn restore(&mut self, origin: &MeshOrigin) -> Result<TetMesh, ModelError> {
        if let Some(reference) = &self.reference
            && self.origin().as_ref() == Some(origin)
        {
            return Ok(TetMesh::clone(reference.mesh()));
        }
        let (expected, found) = (self.generator.surfaced.len(), origin.poses.len());
        let is_from_file = matches!(self.generator.source, Source::File { .. });
        if expected != found || !(origin.is_generated || is_from_file) {
            return Err(ModelError::History(format!(
                "is damaged: a mesh of {found} bodies instead of {expected}, or of no file"
            )));
        }
        check_rotations(&origin.poses)?;
        self.new_mesh(Placement::rigid(&origin.poses), origin.is_generated)
    }

    fn new_mesh(
        &mut self,
        placement: Placement,
        is_generated: bool,
    ) -> Result<TetMesh, ModelError> {
        let mesh = match &self.generator.source {
            Source::File { mesh, .. } if !is_generated => mesh.clone(),
            _ => self.generator.generate(&placement)?,
        };
        let shared = Arc::new(mesh.clone());
        // The poses of all bodies would serve to restore a history, which a fluid's flow is not in.
        let (motion, all) = (&self.motion, Placement::default());
        let reference = ReferenceMesh::new(&self.generator, motion, shared, placement, &all);
        reference.space()?;
        self.reference = Some(reference);
        self.is_generated = is_generated;
        Ok(mesh)
    }

    /// The placement at poses, with bodies on the symmetry planes that they are off by rounding.
    fn snapped(&self, poses: &[Isometry3<f64>]) -> Placement {
        let mut placement = Placement::rigid(poses);
        let generator = &self.generator;
        generator.snap_to_symmetry_planes(&mut placement.poses);
        placement
    }
}
