//! Steps in time of a fluid with inertia on meshes in space.

use std::cell::RefCell;
use std::f64::consts::PI;
use std::rc::Rc;

use inertia::{
    Bodies, BodyMass, Convection, Forcing, InertiaError, Integrator, Meshes, Parameters,
    ProjectionJump, Step, SuppliedMesh,
};
use mesh::TetMesh;
use models::{InstantaneousSolution, ModelError, MovingMeshes, MovingScene};
use nalgebra::{Isometry3, Vector3};
use rigid::{Constraints, ExternalLoad, RigidError};
use scene::{InertiaKind, PhaseSpan, Scene};

use super::companion::{COARSER, SOFTER, WithCompanion, share_of_sizes};
use super::moving_fluid::{
    BodyMemory, FluidState, MovingFluid, PresentSpan, TriedStep, other_discretisation,
};
use crate::added_mass::AddedMassForces;
use crate::error::SwimError;
use crate::kinetic_energy::KineticEnergy;

/// Bodies, loads and slip of a scene along its gait, on meshes in space.
pub(super) struct SpatialScene {
    moving: MovingScene,
    span: PresentSpan,
}

impl SpatialScene {
    /// Prepares a scene.
    ///
    /// # Errors
    /// Those of [`MovingScene::new`] and [`MovingScene::check_convection`].
    pub fn new(scene: &Scene) -> Result<Self, ModelError> {
        if scene.inertia().kind == InertiaKind::Full {
            MovingScene::check_convection(scene)?;
        }
        Ok(Self {
            moving: MovingScene::new(scene)?,
            span: PresentSpan::default(),
        })
    }

    /// The scene on coarser meshes and with a larger regularisation of its law; none for the mesh
    /// of a file and without `fem.estimates`.
    ///
    /// # Errors
    /// Those of [`MovingScene::new`].
    pub fn coarser(scene: &Scene) -> Result<Option<Self>, ModelError> {
        let coarser = MovingScene::coarser(scene, COARSER)?;
        Ok(coarser.map(|moving| Self {
            moving: moving.regularised(SOFTER),
            span: PresentSpan::default(),
        }))
    }
}

impl Forcing for SpatialScene {
    fn shape(&self, time: f64) -> Vec<f64> {
        self.moving
            .shape(&self.span.shape(self.moving.scene(), time))
    }

    fn loads(&self, time: f64, poses: &[Isometry3<f64>]) -> Vec<ExternalLoad> {
        self.moving.loads(time, poses)
    }

    fn constraints(&self, time: f64, joints: Constraints) -> Result<Constraints, RigidError> {
        self.moving.constraints(time, joints)
    }

    fn has_slip(&self) -> bool {
        self.moving.has_slip()
    }

    fn slip(&self, _: f64, body: usize, x: &Vector3<f64>) -> Vector3<f64> {
        self.moving.slip(body, x)
    }
}

/// Meshes of a scene for an integrator in time, whose origin is part of what a fluid remembers.
#[derive(Clone)]
struct SceneMeshes(Rc<RefCell<MovingMeshes>>);

impl SceneMeshes {
    /// A mesh that the origin has moved or generated, with its space.
    fn with_space(&self, mesh: TetMesh) -> SuppliedMesh {
        let space = self.0.borrow().space();
        SuppliedMesh { mesh, space }
    }
}

impl Meshes for SceneMeshes {
    fn mesh(
        &mut self,
        _: f64,
        poses: &[Isometry3<f64>],
    ) -> Result<Option<SuppliedMesh>, InertiaError> {
        let moved = self.0.borrow_mut().moved(poses).map_err(supplied)?;
        Ok(moved.map(|mesh| self.with_space(mesh)))
    }

    fn renew(
        &mut self,
        _: f64,
        poses: &[Isometry3<f64>],
    ) -> Result<Option<SuppliedMesh>, InertiaError> {
        let renewed = self.0.borrow_mut().renewed(poses).map_err(supplied)?;
        Ok(Some(self.with_space(renewed)))
    }
}

fn supplied(error: ModelError) -> InertiaError {
    InertiaError::Supplier(Box::new(error))
}

/// Fluid and bodies on meshes in space.
pub(super) struct SpatialFluid<'a> {
    scene: &'a SpatialScene,
    integrator: Integrator<'a>,
    meshes: SceneMeshes,
    tried: Option<Step>,
    /// The jump by the last new mesh before the accepted steps.
    seen: Option<ProjectionJump>,
    /// Volume of the bodies.
    volume: f64,
    memory: BodyMemory,
}

impl<'a> SpatialFluid<'a> {
    /// Fluid and bodies at rest.
    ///
    /// # Errors
    /// Bodies around which no mesh can be generated.
    pub fn at_rest(scene: &'a SpatialScene) -> Result<Self, SwimError> {
        let moving = &scene.moving;
        let masses = moving.masses().into_iter();
        let bodies = Bodies {
            set: moving.set(),
            masses: masses
                .map(|(mass, inertia)| BodyMass { mass, inertia })
                .collect(),
            surfaces: moving.surface_names().to_vec(),
            walls: moving.walls().to_vec(),
        };
        let convection = match moving.scene().inertia().kind {
            InertiaKind::Full => Convection::Full,
            _ => Convection::Neglected,
        };
        let mut parameters = Parameters::new(moving.density())
            .with_convection(convection)
            .with_options(moving.options());
        if let Some(law) = moving.law() {
            parameters = parameters.with_law(law);
        }
        let meshes = SceneMeshes(Rc::new(RefCell::new(moving.meshes()?)));
        let supplied = Box::new(meshes.clone());
        let volumes = moving.scene().bodies().iter();
        Ok(Self {
            integrator: Integrator::from_rest(bodies, scene, supplied, parameters, 0.0)?,
            meshes,
            scene,
            tried: None,
            seen: None,
            volume: volumes.map(|body| body.shape.volume()).sum(),
            memory: BodyMemory::new(moving.scene()),
        })
    }

    /// Fluid and bodies at rest, beside those of a coarser scene if their meshes differ enough.
    ///
    /// # Errors
    /// Bodies around which no mesh can be generated.
    pub fn with_companion(
        scene: &'a SpatialScene,
        coarser: Option<&'a SpatialScene>,
    ) -> Result<Box<dyn MovingFluid + 'a>, SwimError> {
        let fine = Self::at_rest(scene)?;
        // Where there is no mesh for the estimate, there is no estimate.
        let Some(coarse) = coarser.and_then(|scene| Self::at_rest(scene).ok()) else {
            return Ok(Box::new(fine));
        };
        let nodes = |fluid: &Self| fluid.integrator.mesh().n_points();
        let Some(share) = share_of_sizes([nodes(&fine), nodes(&coarse)]) else {
            return Ok(Box::new(fine));
        };
        let resolved = fine.integrator.age_of_resolved_layers()?;
        // Layers of oscillations are as thick as those that have grown for `P / π`.
        let period = scene.moving.scene().shortest_period();
        let is_thin = period.is_some_and(|period| period / PI < resolved);
        let resolved = if is_thin { f64::INFINITY } else { resolved };
        let both = [Box::new(fine) as Box<dyn MovingFluid>, Box::new(coarse)];
        Ok(Box::new(WithCompanion::of_space(both, share, resolved)))
    }

    /// Velocity of the bodies that a new mesh changes at most: twice the impulse over the mass of
    /// the fluid that they displace, since their added mass is at least half of it.
    fn jump(&self) -> f64 {
        let jump = self.integrator.last_jump();
        if jump == self.seen {
            return 0.0;
        }
        let momentum = jump.map_or(0.0, |jump| jump.momentum.norm());
        let scale = self.scene.moving.length_to_scene(1.0);
        2.0 * momentum * self.parts() * scale.powi(4) / self.volume
    }

    /// Number of the equal parts of the fluid, one of which is meshed.
    fn parts(&self) -> f64 {
        let planes = self.scene.moving.scene().fem_symmetry_planes();
        2_f64.powi(planes.into_iter().filter(|plane| *plane).count() as i32)
    }
}

impl MovingFluid for SpatialFluid<'_> {
    fn time(&self) -> f64 {
        self.integrator.time()
    }

    fn enter(&mut self, span: &PhaseSpan) {
        self.scene.span.enter(span);
    }

    fn start_from_stokes(&mut self, span: &PhaseSpan) -> Result<(), SwimError> {
        let rates = self.scene.moving.shape(&span.rates(0.0));
        self.integrator.start_from_stokes(&rates)?;
        Ok(())
    }

    fn restart(&mut self) {
        self.integrator.restart();
    }

    fn try_step(&mut self, length: f64) -> Result<TriedStep, SwimError> {
        let step = self.integrator.try_step(length)?;
        let moving = &self.scene.moving;
        let increment = step.increment().ok_or(SwimError::NoFlow)?;
        let velocity_error = moving.length_to_scene(step.velocity_error);
        let tried = TriedStep {
            length: step.length,
            increment: moving.motion_to_scene(increment),
            mesh_error: None,
            error: step.error,
            displacement_error: velocity_error * (step.length + self.memory.total()),
            velocity_error,
            jump: self.jump(),
        };
        self.tried = Some(step);
        Ok(tried)
    }

    fn solution(&mut self, with_flow: bool) -> Result<InstantaneousSolution, SwimError> {
        let step = self.tried.as_mut().ok_or(SwimError::NoFlow)?;
        let mesh = with_flow.then(|| step.mesh().clone());
        let time = self.integrator.time() + step.length;
        let moving = &self.scene.moving;
        Ok(moving.answer(&mut step.solved, &step.poses, time, mesh)?)
    }

    fn added_mass_forces(&self) -> Result<Option<AddedMassForces>, SwimError> {
        let step = self.tried.as_ref().ok_or(SwimError::NoFlow)?;
        let forces = self.integrator.added_mass_forces(step)?;
        let forces = self.scene.moving.forces_to_scene(&forces);
        Ok(Some(AddedMassForces::new(forces)))
    }

    fn accept(&mut self) -> Result<(), SwimError> {
        let step = self.tried.take().ok_or(SwimError::NoFlow)?;
        self.seen = self.integrator.last_jump();
        Ok(self.integrator.accept(step)?)
    }

    fn kinetic_energy(&self) -> Result<KineticEnergy, SwimError> {
        let of_part = self.integrator.kinetic_energy()?;
        let energies = [
            self.parts() * of_part,
            self.integrator.bodies_kinetic_energy(),
        ];
        let moving = &self.scene.moving;
        Ok(KineticEnergy::new(
            energies.map(|energy| moving.power_to_scene(energy)),
        ))
    }

    fn remembered(&mut self) -> Result<FluidState, SwimError> {
        let origin = self.meshes.0.borrow().origin();
        let origin = origin.ok_or(SwimError::NoFlow)?;
        Ok(FluidState::Spatial(origin, self.integrator.remembered()))
    }

    fn continue_from(&mut self, state: FluidState) -> Result<(), SwimError> {
        let FluidState::Spatial(origin, state) = state else {
            return Err(other_discretisation());
        };
        let mesh = self.meshes.0.borrow_mut().restore(&origin)?;
        self.tried = None;
        self.seen = None;
        let mesh = self.meshes.with_space(mesh);
        Ok(self.integrator.continue_from(state, mesh)?)
    }
}
