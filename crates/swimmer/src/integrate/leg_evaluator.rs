//! The velocity at a point of a leg, with every solution of the model checked.

use nalgebra::{DMatrix, UnitQuaternion};
use rigid::{State, StateVelocity, Twist};

use super::leg_solution::LegSolution;
use crate::SwimError;
use models::{
    Configuration, ErrorEstimates, Hydrodynamics, InstantaneousSolution, ModelError, Query, Seconds,
};
use scene::{Leg, Scene, closest_contact};

type Observer<'a> = &'a mut dyn FnMut(&LegSolution, &dyn Hydrodynamics) -> Result<(), SwimError>;

/// The model's answers along one leg.
pub(super) struct LegEvaluator<'a> {
    pub scene: &'a Scene,
    pub leg: &'a Leg,
    pub seconds: Seconds,
    pub solves: usize,
    model: &'a mut dyn Hydrodynamics,
    observe: Observer<'a>,
}

impl<'a> LegEvaluator<'a> {
    pub fn new(
        scene: &'a Scene,
        model: &'a mut dyn Hydrodynamics,
        leg: &'a Leg,
        observe: Observer<'a>,
    ) -> Self {
        Self {
            scene,
            leg,
            seconds: Seconds::default(),
            solves: 0,
            model,
            observe,
        }
    }

    /// The velocity at a point of the leg, with error estimates of the model or without.
    pub fn solve(
        &mut self,
        s: f64,
        state: &State,
        estimates: bool,
    ) -> Result<LegSolution, SwimError> {
        let rates = [self.leg.rates()];
        let mut solutions = self.ask(s, state, |model, configuration| {
            model.solve(&Query::new(configuration, &rates).with_estimates(estimates))
        })?;
        let solution = solutions.pop().ok_or(ModelError::NoSolution {
            model: self.model.name(),
        })?;
        self.record(s, state, solution)
    }

    /// The grand resistance at a point of the leg.
    pub fn resistance(&mut self, s: f64, state: &State) -> Result<DMatrix<f64>, SwimError> {
        self.ask(s, state, |model, configuration| {
            model.resistance(configuration)
        })
    }

    /// When the model estimates its discretisation errors.
    pub fn error_estimates(&self) -> ErrorEstimates {
        self.model.error_estimates()
    }

    /// Asks the model, after a check that bodies and walls do not touch.
    fn ask<T>(
        &mut self,
        s: f64,
        state: &State,
        question: impl Fn(&mut dyn Hydrodynamics, Configuration<'_>) -> Result<T, ModelError>,
    ) -> Result<T, SwimError> {
        let lengths = self.leg.lengths(s);
        self.check_clearance(s, state, &lengths)?;
        let configuration = Configuration {
            state,
            lengths: &lengths,
        };
        Ok(question(self.model, configuration)?)
    }

    /// Counts a solution and shows it to the observer.
    pub fn record(
        &mut self,
        s: f64,
        state: &State,
        solution: InstantaneousSolution,
    ) -> Result<LegSolution, SwimError> {
        solution.check_finite(self.model.name())?;
        self.seconds += solution.seconds;
        let solved = LegSolution {
            number: self.solves,
            s,
            state: state.clone(),
            solution,
        };
        self.solves += 1;
        (self.observe)(&solved, &*self.model)?;
        Ok(solved)
    }

    /// The same answer seen from another state of a scene whose motion depends on its shape alone.
    pub fn turned(&self, solved: &LegSolution, state: &State) -> LegSolution {
        let turn = state.frames[0].rotation * solved.state.frames[0].rotation.inverse();
        let mut turned = LegSolution {
            state: state.clone(),
            ..solved.clone()
        };
        rotate_motion(&turn, &mut turned.solution.motion);
        if let Some(error) = &mut turned.solution.mesh_error {
            rotate_frames(&turn, &mut error.frames);
            for vector in error.bodies.iter_mut().chain(&mut error.forces) {
                *vector = turn * *vector;
            }
        }
        for body in &mut turned.solution.bodies {
            for vector in [
                &mut body.velocity,
                &mut body.angular_velocity,
                &mut body.force,
                &mut body.torque,
            ] {
                *vector = turn * *vector;
            }
        }
        turned
    }

    /// Name of what the leg moves, for messages.
    pub fn what(&self) -> String {
        match self.leg.link {
            Some(link) => self.scene.articulation().links()[link].name.clone(),
            None => "all lengths held".to_owned(),
        }
    }

    fn check_clearance(&self, s: f64, state: &State, lengths: &[f64]) -> Result<(), SwimError> {
        let poses = self.scene.articulation().place(state, lengths)?;
        let bodies = self.scene.bodies();
        let Some(contact) = closest_contact(bodies, self.scene.domain(), &poses) else {
            return Ok(());
        };
        if !contact.touches(bodies[contact.body].bounding_radius()) {
            return Ok(());
        }
        let name = &bodies[contact.body].name;
        Err(SwimError::Collision {
            phase: self.leg.number + 1,
            what: self.what(),
            percent: 100.0 * s,
            time: self.leg.time(s),
            problem: match contact.other {
                Some(other) => format!(
                    "bodies '{name}' and '{}' touch (gap {:.4})",
                    bodies[other].name, contact.gap
                ),
                None => format!(
                    "body '{name}' touches the wall (clearance {:.4})",
                    contact.gap
                ),
            },
        })
    }
}

fn rotate_motion(turn: &UnitQuaternion<f64>, motion: &mut StateVelocity) {
    rotate_frames(turn, &mut motion.frames);
    for spin in &mut motion.spins {
        *spin = turn * *spin;
    }
}

fn rotate_frames(turn: &UnitQuaternion<f64>, frames: &mut [Twist]) {
    for frame in frames {
        frame.linear = turn * frame.linear;
        frame.angular = turn * frame.angular;
    }
}
