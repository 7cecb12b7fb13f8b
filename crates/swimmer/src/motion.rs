//! The motion of a run as a function of time.

use models::{FlowField, Hydrodynamics, InstantaneousSolution, PointFlow};
use nalgebra::Vector3;
use rigid::State;
use scene::{PhaseSpan, Scene, spans};
use serde::{Deserialize, Serialize};

use crate::error::SwimError;
use crate::integrate::{PathPiece, SpanResult};
use crate::moment::Moment;

/// Rounding of times, relative to the duration of a phase: starts of phases are sums.
pub(crate) const TIME_ROUNDING: f64 = 1e-9;

/// The motion of a run as a function of time, and the flow at any time of it.
///
/// It is collected phase by phase ([`Motion::append`]), for example in
/// [`Progress::span_done`](crate::Progress::span_done).
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct Motion {
    spans: Vec<SpanMotion>,
}

/// The motion over a phase span.
#[derive(Clone, Debug, Deserialize, Serialize)]
struct SpanMotion {
    number: usize,
    pieces: Vec<PathPiece>,
    end: State,
}

impl SpanMotion {
    /// The position on the phase span at which the motion ends.
    fn reached(&self) -> f64 {
        self.pieces.last().map_or(0.0, |piece| piece.to.max(0.0))
    }
}

impl Motion {
    /// Appends the phase span that follows. One that is known already, of a run that begins again
    /// with another model or tolerance, is replaced with all after it.
    pub fn append(&mut self, span: &PhaseSpan, result: &SpanResult) {
        self.spans.retain(|known| known.number < span.number);
        self.spans.push(SpanMotion {
            number: span.number,
            pieces: result.pieces.clone(),
            end: result.end.clone(),
        });
    }

    /// Positions and rates at a time; where two phases meet, the rates are those of the later one.
    ///
    /// `scene` is the scene that was run.
    ///
    /// # Errors
    /// [`SwimError::NotApplicable`] for a time outside the motion.
    pub fn at(&self, scene: &Scene, time: f64) -> Result<Moment, SwimError> {
        let set = scene.articulation();
        let first = self.spans.first().map_or(0, |motion| motion.number);
        let all = spans(scene.gait(), set.initial_shape())?.skip(first);
        let mut begins = None;
        let mut found = None;
        let (mut ends, mut rounding) = (f64::NEG_INFINITY, 0.0);
        for (span, motion) in all.zip(&self.spans) {
            rounding = TIME_ROUNDING * span.duration;
            begins.get_or_insert(span.start);
            ends = span.time(motion.reached());
            if time >= span.start - rounding {
                found = Some((span, motion));
            }
        }
        let Some((span, motion)) = found.filter(|_| time <= ends + rounding) else {
            let known = match begins {
                Some(begins) => format!("the motion is known from {begins} to {ends}"),
                None => "no phase of the motion is known".to_owned(),
            };
            return Err(SwimError::NotApplicable {
                place: format!("time {time}"),
                problem: known,
            });
        };
        let s = ((time - span.start) / span.duration).clamp(0.0, motion.reached());
        let state = match PathPiece::around(&motion.pieces, s).filter(|_| s < motion.reached()) {
            Some(piece) => piece.state(set, s)?,
            None => motion.end.clone(),
        };
        Ok(Moment {
            time: span.time(s),
            state,
            shape: span.shape(s),
            rates: span.rates(s),
        })
    }

    /// The instantaneous solution at a time.
    ///
    /// # Errors
    /// Those of [`Motion::at`] and [`Moment::solve`]; [`SwimError::NotApplicable`] where positions
    /// and rates do not determine the flow: for bodies or fluids with inertia, and thermal noise.
    pub fn solve(
        &self,
        scene: &Scene,
        model: &mut dyn Hydrodynamics,
        time: f64,
    ) -> Result<InstantaneousSolution, SwimError> {
        self.flowing(scene, time)?.solve(scene, model)
    }

    /// The flow field at a time.
    ///
    /// # Errors
    /// As [`Motion::solve`].
    pub fn flow(
        &self,
        scene: &Scene,
        model: &mut dyn Hydrodynamics,
        time: f64,
    ) -> Result<FlowField, SwimError> {
        self.flowing(scene, time)?.flow(scene, model)
    }

    /// Velocity and pressure at points at a time, as [`Moment::flow_at`].
    ///
    /// # Errors
    /// As [`Motion::solve`].
    pub fn flow_at(
        &self,
        scene: &Scene,
        model: &mut dyn Hydrodynamics,
        time: f64,
        points: &[Vector3<f64>],
    ) -> Result<Vec<Option<PointFlow>>, SwimError> {
        self.flowing(scene, time)?.flow_at(scene, model, points)
    }

    /// [`Motion::at`] where positions and rates determine the flow.
    fn flowing(&self, scene: &Scene, time: f64) -> Result<Moment, SwimError> {
        check_memory(scene)?;
        self.at(scene, time)
    }
}

/// Refuses scenes whose velocities depend on more than positions and rates.
fn check_memory(scene: &Scene) -> Result<(), SwimError> {
    let key = if scene.noise().is_some() {
        "fluid.thermal_energy"
    } else if scene.inertia().is_kept() {
        "fluid.inertia"
    } else if scene.has_masses() {
        "bodies"
    } else {
        return Ok(());
    };
    Err(SwimError::NotApplicable {
        place: scene.place(key),
        problem: "with inertia or thermal noise, positions and rates do not determine the flow at \
                  a time; the files of `swim run` have that of its solves"
            .to_owned(),
    })
}
