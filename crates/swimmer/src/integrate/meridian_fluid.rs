//! Steps in time of a fluid with inertia in the meridian plane of bodies on one axis.

use axisymmetric::{
    AxialForcing, AxialIntegrator, AxialStep, AxisymmetricError, Convection, TransientParameters,
};
use models::{InstantaneousSolution, ModelError, MovingAxis};
use scene::{InertiaKind, PhaseSpan, Scene};

use super::companion::{SOFTER, WithCompanion};
use super::moving_fluid::{
    BodyMemory, FluidState, MovingFluid, PresentSpan, TriedStep, other_discretisation,
};
use super::prediction::velocity_tolerance;
use crate::added_mass::AddedMassForces;
use crate::error::SwimError;
use crate::kinetic_energy::KineticEnergy;

/// Bodies, loads and slip of a scene along its gait, in the meridian plane.
pub(super) struct MeridianScene {
    moving: MovingAxis,
    /// Polynomial degree of the velocities.
    order: usize,
    /// Relative error of the nonlinear iteration of a step.
    tolerance: f64,
    span: PresentSpan,
}

/// Allowed relative errors of velocities for which elements of the orders 4, 5, ... are enough.
///
/// Errors have signs and cancel along a stroke as velocities do, so that these are below those of
/// single velocities: the difference between the orders three and four, which is the error bar, is
/// 1.4e-3 of the net displacement in the first stroke of three spheres at a Reynolds number of 1,
/// where a tolerance of 1e-2 allows velocities an error of 5e-5. An order more reduces it by a
/// factor of four at least. A run whose bar misses the tolerance is repeated with a smaller one.
const ERRORS: [f64; 6] = [2e-5, 5e-6, 1.2e-6, 3e-7, 8e-8, 2e-8];

/// Polynomial degree that the first of these errors belongs to.
const FIRST_ORDER: usize = 4;

/// Net displacement by the errors of steps over the sum of what each of them costs.
///
/// Errors that vorticity carries through its layer have alternating signs, and those of phases in
/// which arms close and open cancel. The net is 1/150 of the sum in the stroke of three spheres at
/// a Reynolds number of 1, and 1/20 for a sphere that is released; the difference to steps twice
/// as long, the error bar, is four times as large.
const NET_OF_STEPS: f64 = 0.025;

/// Error of the nonlinear iteration over that of velocities which the tolerance allows.
///
/// A short step may use a fortieth of the latter, and its error is estimated by a difference.
const ITERATION_SHARE: f64 = 0.005;

/// Largest error of the iteration.
const MAX_TOLERANCE: f64 = 1e-6;

/// Smallest error of the iteration; rounding is a hundredth of it.
const MIN_TOLERANCE: f64 = 1e-10;

impl MeridianScene {
    /// A scene with elements of the order that its tolerance needs, and of the order below with a
    /// larger regularisation of its law.
    ///
    /// # Errors
    /// Those of [`MovingAxis::new`].
    pub fn pair(scene: &Scene) -> Result<[Self; 2], ModelError> {
        let tolerance = velocity_tolerance(scene);
        let enough = ERRORS.iter().position(|error| *error <= tolerance);
        let order = FIRST_ORDER + enough.unwrap_or(ERRORS.len() - 1);
        let iteration = (ITERATION_SHARE * tolerance).clamp(MIN_TOLERANCE, MAX_TOLERANCE);
        let of_order = |order, softer| -> Result<Self, ModelError> {
            Ok(Self {
                moving: MovingAxis::new(scene)?.regularised(softer),
                order,
                tolerance: iteration,
                span: PresentSpan::default(),
            })
        };
        Ok([of_order(order, 1.0)?, of_order(order - 1, SOFTER)?])
    }

    /// Values of the joints at a time, in the units of the scene.
    fn shape(&self, time: f64) -> Vec<f64> {
        self.span.shape(self.moving.scene(), time)
    }
}

impl AxialForcing for MeridianScene {
    fn displacement(&self, time: f64, body: usize) -> f64 {
        self.moving.displacement(time, &self.shape(time), body)
    }

    fn load(&self, time: f64, body: usize) -> f64 {
        self.moving.load(time, body)
    }

    fn has_slip(&self) -> bool {
        self.moving.has_slip()
    }

    fn slip(&self, _: f64, body: usize, x: [f64; 2]) -> [f64; 2] {
        self.moving.slip(body, x)
    }
}

/// Fluid and bodies in the meridian plane.
pub(super) struct MeridianFluid<'a> {
    scene: &'a MeridianScene,
    integrator: AxialIntegrator<'a>,
    tried: Option<AxialStep>,
    parameters: TransientParameters<'a>,
    /// Volume of the bodies.
    volume: f64,
    memory: BodyMemory,
}

impl<'a> MeridianFluid<'a> {
    /// Fluid and bodies at rest, beside those of a coarser scene.
    ///
    /// # Errors
    /// Bodies around which no mesh can be generated.
    pub fn with_companion(
        [fine, coarse]: &'a [MeridianScene; 2],
    ) -> Result<Box<dyn MovingFluid + 'a>, SwimError> {
        let fine = Box::new(Self::at_rest(fine)?);
        // Where there is no mesh for the estimate, there is no estimate.
        let Ok(coarse) = Self::at_rest(coarse) else {
            return Ok(fine);
        };
        Ok(Box::new(WithCompanion::of_meridian_plane([
            fine,
            Box::new(coarse),
        ])))
    }

    /// Fluid and bodies at rest.
    ///
    /// # Errors
    /// Bodies around which no mesh can be generated.
    pub fn at_rest(scene: &'a MeridianScene) -> Result<Self, SwimError> {
        let moving = &scene.moving;
        let convection = match moving.scene().inertia().kind {
            InertiaKind::Full => Convection::Full,
            _ => Convection::Neglected,
        };
        let mut parameters = TransientParameters::new(moving.density())
            .with_convection(convection)
            .with_order(scene.order)
            .with_tolerance(scene.tolerance);
        if let Some(law) = moving.law() {
            parameters = parameters.with_law(law);
        }
        let (bodies, walls) = (moving.bodies(), moving.surroundings());
        let integrator = AxialIntegrator::from_rest(bodies, walls, scene, parameters, 0.0);
        Ok(Self {
            integrator: integrator.map_err(failed)?,
            scene,
            tried: None,
            parameters,
            volume: bodies.iter().map(|body| body.shape.volume()).sum(),
            memory: BodyMemory::new(moving.scene()),
        })
    }
}

fn failed(error: AxisymmetricError) -> SwimError {
    ModelError::from(error).into()
}

impl MovingFluid for MeridianFluid<'_> {
    fn time(&self) -> f64 {
        self.integrator.time()
    }

    fn enter(&mut self, span: &PhaseSpan) {
        self.scene.span.enter(span);
    }

    fn start_from_stokes(&mut self, span: &PhaseSpan) -> Result<(), SwimError> {
        let moving = &self.scene.moving;
        let (shape, rates) = (span.shape(0.0), span.rates(0.0));
        let rates: Vec<f64> = (0..moving.bodies().len())
            .map(|body| moving.displacement_rate(span.time(0.0), &shape, &rates, body))
            .collect();
        self.integrator.start_from_stokes(&rates).map_err(failed)
    }

    fn restart(&mut self) {
        self.integrator.restart();
    }

    fn try_step(&mut self, length: f64) -> Result<TriedStep, SwimError> {
        let step = self.integrator.try_step(length).map_err(failed)?;
        let moving = &self.scene.moving;
        let before = self.integrator.positions();
        // Twice the impulse over the mass of the fluid that the bodies displace: their added mass
        // is at least half of it.
        let jump = 2.0 * step.momentum_jump.map_or(0.0, f64::abs) / self.volume;
        // An error in a layer that vorticity crosses within the step carries the impulse
        // `4π a² (h μ/ρ)^(1/2) ρ` per velocity, which moves a body by that over `6π μ a`.
        let BodyMemory { diffusion, inertia } = self.memory;
        let lasts = step.length + (step.length * diffusion).sqrt() + inertia;
        let tried = TriedStep {
            length: step.length,
            increment: moving.increment(&before, &step.positions),
            mesh_error: None,
            error: step.error,
            displacement_error: NET_OF_STEPS * lasts * moving.length_to_scene(step.flow_error),
            velocity_error: moving.length_to_scene(step.velocity_error),
            jump: moving.length_to_scene(jump),
        };
        self.tried = Some(step);
        Ok(tried)
    }

    fn solution(&mut self, _: bool) -> Result<InstantaneousSolution, SwimError> {
        let step = self.tried.as_ref().ok_or(SwimError::NoFlow)?;
        let numbers = (self.integrator.dofs(), self.parameters.tolerance);
        let shape = self.scene.shape(step.time);
        Ok(self.scene.moving.answer(&step.into(), &shape, numbers)?)
    }

    fn added_mass_forces(&self) -> Result<Option<AddedMassForces>, SwimError> {
        let step = self.tried.as_ref().ok_or(SwimError::NoFlow)?;
        let forces = self.integrator.added_mass_forces(step).map_err(failed)?;
        let forces = self.scene.moving.forces_to_scene(&forces);
        Ok(Some(AddedMassForces::new(forces)))
    }

    fn accept(&mut self) -> Result<(), SwimError> {
        let step = self.tried.take().ok_or(SwimError::NoFlow)?;
        self.integrator.accept(step);
        Ok(())
    }

    fn kinetic_energy(&self) -> Result<KineticEnergy, SwimError> {
        let energies = self.integrator.kinetic_energy().map_err(failed)?;
        let moving = &self.scene.moving;
        Ok(KineticEnergy::new(
            energies.map(|energy| moving.power_to_scene(energy)),
        ))
    }

    fn remembered(&mut self) -> Result<FluidState, SwimError> {
        Ok(FluidState::Meridian(self.integrator.remembered()))
    }

    fn continue_from(&mut self, state: FluidState) -> Result<(), SwimError> {
        let FluidState::Meridian(state) = state else {
            return Err(other_discretisation());
        };
        self.tried = None;
        self.integrator.continue_from(state).map_err(failed)
    }
}
