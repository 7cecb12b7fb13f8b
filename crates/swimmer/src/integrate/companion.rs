//! The errors of mesh and regularisation of a fluid with inertia, by a coarser one beside it.

use models::{DiscretisationError, InstantaneousSolution, ModelError, Uncertainty};
use rigid::StateVelocity;
use scene::PhaseSpan;

use super::moving_fluid::{
    FluidState, LEAST_STEP, MeshError, MovingFluid, TriedStep, other_discretisation,
};
use crate::added_mass::AddedMassForces;
use crate::error::SwimError;
use crate::kinetic_energy::KineticEnergy;

/// Factor on all element sizes of a coarser mesh in space, on bodies and in the fluid.
///
/// Errors on it are then four to nine times as large, and at least twice where boundary layers and
/// wakes are not resolved.
pub(crate) const COARSER: f64 = 1.4;

/// Error of the second order over the difference between two meshes with these numbers of degrees
/// of freedom, relative to that of meshes whose element sizes differ by [`COARSER`].
///
/// Elements cannot be arbitrarily large on a sphere, in a gap and at a wall. Where they are as
/// large as possible, the coarser mesh has larger ones elsewhere only, and the mean ratio of the
/// sizes follows from the numbers of degrees of freedom. None for meshes that are nearly equal:
/// they say nothing of the error.
pub(crate) fn share_of_sizes([fine, coarse]: [usize; 2]) -> Option<f64> {
    /// The difference is then a sixth of the error.
    const LEAST_RATIO: f64 = 1.08;
    let ratio = (fine as f64 / coarse as f64).cbrt();
    let share = (COARSER.powi(2) - 1.0) / (ratio * ratio - 1.0);
    (ratio >= LEAST_RATIO).then(|| share.max(1.0))
}

/// Error of the first order over the difference between meshes whose sizes differ by [`COARSER`].
///
/// Where a layer of vorticity is thinner than the elements errors are of that order: the way of a
/// sphere without mass that a force pulls from rest had an error of 2.3, 2.0 and 1.1 times the
/// difference when the layer was 1/20, 1/6 and 1/2 of the distance between nodes.
const FIRST_ORDER: f64 = 1.0 / (COARSER - 1.0);

/// Factor on the regularisation of a viscosity law in the coarser one of two fluids.
///
/// The way of a sphere that falls in a power law of the index 0.6 with regularisations of 1 to 8
/// per cent of its shear rates differs from that with ten times these by 4.0 to 6 times the effect
/// of the regularisation, with a yield stress by 1.7 to 3.1 times.
pub(super) const SOFTER: f64 = 10.0;

/// A fluid and the same on a coarser mesh that moves beside it, with a larger regularisation if its
/// viscosity law has one.
///
/// The motion is that of the fine mesh minus its estimated error, a share of the difference to the
/// coarse one. Both keep velocities of their own, so that the difference is that of the whole
/// motion, with the errors by new meshes and of boundary layers that begin thinner than an element,
/// which no estimate for one flow sees.
pub(super) struct WithCompanion<'a> {
    fine: Box<dyn MovingFluid + 'a>,
    coarse: Box<dyn MovingFluid + 'a>,
    /// Error of the fine mesh over the difference between both.
    share: f64,
    /// Relative uncertainty of that, where layers of vorticity are resolved.
    uncertainty: f64,
    /// Time from the start of a phase from which on they are.
    resolved: f64,
    /// Start of the phase, and end of the step that was tried last.
    start: f64,
    tried_end: f64,
    /// Whether the coarse one takes one step where the fine one takes two, so that the difference
    /// contains the errors of steps.
    takes_long_steps: bool,
    /// Time at which both meet at the latest.
    end: f64,
    /// Motion of the fine one since both met last; none where they meet.
    ahead: Option<StateVelocity>,
    /// Motion of the coarse one since both met last, where it followed the fine one's first step
    /// alone; its time is then that of the fine one.
    followed: Option<StateVelocity>,
    /// The motion of the fine one since both met, with the step that was tried last, and whether
    /// both meet after it.
    tried: Option<(StateVelocity, bool)>,
    /// Errors where both met last in this phase.
    error: Option<DiscretisationError>,
    /// Kinetic energies of the coarse one minus those of the fine one: where both met last after
    /// steps of different lengths, or since then, whichever is larger.
    energy_difference: [f64; 2],
    /// Long steps of the coarse one in this phase.
    long_steps: usize,
}

/// Long steps in a phase from which on the error of its first step, which both take alike and no
/// difference contains, has decayed.
const ENOUGH_LONG_STEPS: usize = 2;

/// Factor on the bars of energies before: at the end of phases of three steps errors were twice the
/// difference.
const EARLY_BARS: f64 = 3.0;

impl<'a> WithCompanion<'a> {
    fn new(both: [Box<dyn MovingFluid + 'a>; 2], share: f64, takes_long_steps: bool) -> Self {
        let [fine, coarse] = both;
        let start = fine.time();
        Self {
            end: start,
            start,
            tried_end: start,
            resolved: 0.0,
            fine,
            coarse,
            share,
            // the difference is the bar
            uncertainty: 1.0 / share,
            takes_long_steps,
            ahead: None,
            followed: None,
            tried: None,
            error: None,
            energy_difference: [0.0; 2],
            long_steps: 0,
        }
    }

    /// Of meshes in space whose sizes differ by [`COARSER`] and which take the same steps, with
    /// their [`share_of_sizes`] and the time after which elements resolve the layers of vorticity
    /// that begin with a phase.
    ///
    /// The share is 0.35 for the fourth order. It was 0.2 at the median for the speeds of squirmers
    /// in steady flow, 0.12 to 0.29 for the largest speeds of spheres that fall in a box, and 0 to
    /// 0.14 for a stroke of three spheres (`docs/decisions.md`).
    pub fn of_space(
        both: [Box<dyn MovingFluid + 'a>; 2],
        share_of_sizes: f64,
        resolved: f64,
    ) -> Self {
        let companion = Self::new(both, 0.2, false);
        Self {
            uncertainty: share_of_sizes * companion.uncertainty,
            resolved,
            ..companion
        }
    }

    /// Relative uncertainty of the error in the step that was tried last, in addition to that of
    /// all steps.
    fn own_uncertainty(&self) -> f64 {
        match self.tried_end - self.start < self.resolved {
            true => FIRST_ORDER * self.uncertainty,
            false => 0.0,
        }
    }

    /// Relative uncertainty of the error at the end of this step.
    fn present_uncertainty(&self) -> f64 {
        self.uncertainty.max(self.own_uncertainty())
    }

    /// Of elements in the meridian plane whose orders differ by one, by which errors change by
    /// factors of two to ten, and with steps twice as long, by which those of the second order
    /// change by a factor of four.
    pub fn of_meridian_plane(both: [Box<dyn MovingFluid + 'a>; 2]) -> Self {
        Self::new(both, 0.25, true)
    }

    /// Whether both meet after a step to this time: every second time where steps of the coarse one
    /// are long, after the first step of a phase and at its end.
    fn meets(&self, time: f64) -> bool {
        !self.takes_long_steps || self.ahead.is_some() || self.error.is_none() || time >= self.end
    }

    /// A step of the coarse one to a time; its motion since both met last.
    ///
    /// Where a long step of it fails, it takes the two of the fine one. The first of them stays
    /// taken, whatever becomes of the second.
    fn step_coarse(&mut self, time: f64) -> Result<StateVelocity, SwimError> {
        if self.ahead.is_some() && self.followed.is_none() {
            match self.coarse.try_step(time - self.coarse.time()) {
                Err(error) if error.needs_shorter_step() => {}
                step => return Ok(step?.increment),
            }
            let first = self
                .coarse
                .try_step(self.fine.time() - self.coarse.time())?;
            self.coarse.accept()?;
            self.followed = Some(first.increment);
        }
        let last = self.coarse.try_step(time - self.coarse.time())?.increment;
        Ok(match &self.followed {
            Some(first) => first + &last,
            None => last,
        })
    }

    /// Whether the difference of both after a step of this length contains its error: the coarse
    /// one took a longer one.
    fn differs_by_steps(&self) -> bool {
        self.takes_long_steps && self.ahead.is_some() && self.followed.is_none()
    }
}

impl MovingFluid for WithCompanion<'_> {
    fn time(&self) -> f64 {
        self.fine.time()
    }

    fn enter(&mut self, span: &PhaseSpan) {
        self.fine.enter(span);
        self.coarse.enter(span);
        self.start = span.start;
        self.end = span.start + span.duration * (1.0 - LEAST_STEP);
        (self.error, self.energy_difference) = (None, [0.0; 2]);
        self.long_steps = 0;
    }

    fn start_from_stokes(&mut self, span: &PhaseSpan) -> Result<(), SwimError> {
        self.fine.start_from_stokes(span)?;
        self.coarse.start_from_stokes(span)
    }

    fn restart(&mut self) {
        self.fine.restart();
        self.coarse.restart();
    }

    fn try_step(&mut self, length: f64) -> Result<TriedStep, SwimError> {
        let fine = self.fine.try_step(length)?;
        let time = self.fine.time() + fine.length;
        self.tried_end = time;
        let meets = self.meets(time);
        let whole = match &self.ahead {
            Some(ahead) => ahead + &fine.increment,
            None => fine.increment.clone(),
        };
        let error = match meets {
            true => &(&self.step_coarse(time)? + &(&whole * -1.0)) * self.share,
            false => &whole * 0.0,
        };
        self.tried = Some((whole, meets));
        Ok(TriedStep {
            increment: &fine.increment + &(&error * -1.0),
            mesh_error: Some(MeshError {
                change: error,
                relative_uncertainty: self.uncertainty,
                own_uncertainty: self.own_uncertainty(),
            }),
            velocity_error: match !meets || self.differs_by_steps() {
                true => 0.0,
                false => fine.velocity_error,
            },
            ..fine
        })
    }

    /// The long steps at most double, too, but for the first two after a lone one.
    fn max_growth(&self) -> f64 {
        match self.takes_long_steps {
            true => std::f64::consts::SQRT_2,
            false => self.fine.max_growth(),
        }
    }

    fn solution(&mut self, with_flow: bool) -> Result<InstantaneousSolution, SwimError> {
        let mut fine = self.fine.solution(with_flow)?;
        if matches!(self.tried, Some((_, true))) {
            let coarse = self.coarse.solution(false)?;
            let uncertainty = Uncertainty {
                relative: self.present_uncertainty(),
                ..Uncertainty::default()
            };
            let difference =
                DiscretisationError::between(&coarse.response, &fine.response, uncertainty);
            self.error = DiscretisationError::combination([(self.share, &difference)]);
            fine.seconds += coarse.seconds;
        }
        if let Some(error) = self.error.clone() {
            fine.correct(error);
            for bar in fine.error_bars_mut() {
                // The effect of a regularisation is a part of the difference to a larger one.
                bar.model.get_or_insert(0.0);
            }
        }
        Ok(fine)
    }

    /// Known where both meet, with their difference as an error.
    fn added_mass_forces(&self) -> Result<Option<AddedMassForces>, SwimError> {
        if !matches!(self.tried, Some((_, true))) {
            return Ok(None);
        }
        let (fine, coarse) = (
            self.fine.added_mass_forces()?,
            self.coarse.added_mass_forces()?,
        );
        Ok(fine
            .zip(coarse)
            .map(|(fine, coarse)| fine.corrected(&coarse, self.share, self.present_uncertainty())))
    }

    fn accept(&mut self) -> Result<(), SwimError> {
        let (whole, meets) = self.tried.take().ok_or(SwimError::NoFlow)?;
        self.fine.accept()?;
        if !meets {
            self.ahead = Some(whole);
            return Ok(());
        }
        let is_whole = self.differs_by_steps() || !self.takes_long_steps;
        self.long_steps += usize::from(self.differs_by_steps());
        (self.ahead, self.followed) = (None, None);
        self.coarse.accept()?;
        let [fine, coarse] = [self.fine.kinetic_energy()?, self.coarse.kinetic_energy()?];
        let found = [coarse.fluid - fine.fluid, coarse.bodies - fine.bodies];
        for (difference, found) in self.energy_difference.iter_mut().zip(found) {
            if is_whole || found.abs() > difference.abs() {
                *difference = found;
            }
        }
        Ok(())
    }

    fn kinetic_energy(&self) -> Result<KineticEnergy, SwimError> {
        let fine = self.fine.kinetic_energy()?;
        let is_early = self.takes_long_steps && self.long_steps < ENOUGH_LONG_STEPS;
        let factor = if is_early { EARLY_BARS } else { 1.0 };
        Ok(fine.corrected(
            self.energy_difference,
            self.share,
            factor * self.present_uncertainty(),
        ))
    }

    fn remembered(&mut self) -> Result<FluidState, SwimError> {
        let both = [self.fine.remembered()?, self.coarse.remembered()?];
        Ok(FluidState::WithCompanion(Box::new(both)))
    }

    fn continue_from(&mut self, state: FluidState) -> Result<(), SwimError> {
        let FluidState::WithCompanion(both) = state else {
            return Err(other_discretisation());
        };
        let [fine, coarse] = *both;
        self.fine.continue_from(fine)?;
        self.coarse.continue_from(coarse)?;
        if (self.fine.time() - self.coarse.time()).abs() > LEAST_STEP * self.fine.time().abs() {
            let problem = "has a fluid of another time than that of its companion".to_owned();
            return Err(ModelError::History(problem).into());
        }
        (self.ahead, self.followed) = (None, None);
        Ok(())
    }
}
