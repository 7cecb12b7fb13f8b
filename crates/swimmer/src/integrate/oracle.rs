//! What the integrator asks: the velocity at a point of a leg, with every answer checked.

use nalgebra::{DMatrix, UnitQuaternion};
use rigid::{State, StateVelocity, Twist};

use super::Solved;
use crate::SwimError;
use crate::model::{Hydrodynamics, Instant, ModelError, Placement, Seconds};
use scene::Leg;
use scene::{Scene, closest_contact};

type Observer<'a> = &'a mut dyn FnMut(&Solved, &dyn Hydrodynamics) -> Result<(), SwimError>;

/// The model's answers along one leg.
pub(super) struct Oracle<'a> {
    pub scene: &'a Scene,
    pub leg: &'a Leg,
    pub seconds: Seconds,
    pub solves: usize,
    model: &'a mut dyn Hydrodynamics,
    observe: Observer<'a>,
}

impl<'a> Oracle<'a> {
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

    /// The velocity at a point of the leg.
    pub fn solve(&mut self, s: f64, state: &State) -> Result<Solved, SwimError> {
        let instant = self.ask(s, state, |model, placement| model.instant(placement))?;
        self.answered(s, state, instant)
    }

    /// The grand resistance at a point of the leg.
    pub fn resistance(&mut self, s: f64, state: &State) -> Result<DMatrix<f64>, SwimError> {
        self.ask(s, state, |model, placement| model.resistance(placement))
    }

    /// Asks the model, after a look whether the bodies have room.
    fn ask<T>(
        &mut self,
        s: f64,
        state: &State,
        question: impl Fn(&mut dyn Hydrodynamics, &Placement<'_>) -> Result<T, ModelError>,
    ) -> Result<T, SwimError> {
        let lengths = self.leg.lengths(s);
        self.check_room(s, state, &lengths)?;
        let placement = Placement {
            state,
            lengths: &lengths,
            rates: &self.leg.rates(),
        };
        Ok(question(self.model, &placement)?)
    }

    /// Counts an answer and shows it to whoever observes.
    pub fn answered(
        &mut self,
        s: f64,
        state: &State,
        instant: Instant,
    ) -> Result<Solved, SwimError> {
        instant.check_finite(self.model.name())?;
        self.seconds += instant.seconds;
        let solved = Solved {
            number: self.solves,
            s,
            state: state.clone(),
            instant,
        };
        self.solves += 1;
        (self.observe)(&solved, &*self.model)?;
        Ok(solved)
    }

    /// The same answer seen from another state of a scene whose motion depends on its shape alone.
    pub fn turned(&self, solved: &Solved, state: &State) -> Solved {
        let turn = state.frames[0].rotation * solved.state.frames[0].rotation.inverse();
        let mut turned = Solved {
            state: state.clone(),
            ..solved.clone()
        };
        turn_motion(&turn, &mut turned.instant.motion);
        if let Some(error) = &mut turned.instant.mesh_error {
            turn_frames(&turn, &mut error.frames);
            for vector in error.bodies.iter_mut().chain(&mut error.forces) {
                *vector = turn * *vector;
            }
        }
        for body in &mut turned.instant.bodies {
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

    /// Whether the next answers are to come with estimates of what the mesh gets wrong.
    ///
    /// Returns whether they will.
    pub fn want_estimates(&mut self, wanted: bool) -> bool {
        self.model.want_estimates(wanted)
    }

    /// Name of what the leg moves, for messages.
    pub fn what(&self) -> String {
        match self.leg.link {
            Some(link) => self.scene.articulation.links()[link].name.clone(),
            None => "all lengths held".to_owned(),
        }
    }

    fn check_room(&self, s: f64, state: &State, lengths: &[f64]) -> Result<(), SwimError> {
        let poses = self.scene.articulation.place(state, lengths)?;
        let bodies = &self.scene.bodies;
        let Some(contact) = closest_contact(bodies, &self.scene.domain, &poses) else {
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

fn turn_motion(turn: &UnitQuaternion<f64>, motion: &mut StateVelocity) {
    turn_frames(turn, &mut motion.frames);
    for spin in &mut motion.spins {
        *spin = turn * *spin;
    }
}

fn turn_frames(turn: &UnitQuaternion<f64>, frames: &mut [Twist]) {
    for frame in frames {
        frame.linear = turn * frame.linear;
        frame.angular = turn * frame.angular;
    }
}
