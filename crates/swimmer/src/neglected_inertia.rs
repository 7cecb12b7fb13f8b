//! What the inertia that a run neglects would change about its result, to first order.

use models::{BodySolution, Configuration, Hydrodynamics, InertialChange, ModelError, PathPoint};
use nalgebra::Vector3;
use rigid::State;
use scene::{PhaseSpan, Scene, spans};
use serde_json::{Map, Value, json};

use crate::error::SwimError;
use crate::gauss::Gauss;
use crate::inertia_numbers::InertiaNumbers;
use crate::observer::Progress;
use crate::outcome::{Outcome, mean_of_moving};
use crate::start::at_start;

/// Gauss points per phase span, at three solves and a change each.
///
/// Over a period of four phases, errors remain of the fourth harmonic only; on phases of constant
/// rates the effect varies with a power of the distance of the bodies and is integrated to 0.1 %.
const GAUSS_POINTS: usize = 2;

/// Largest rotation of a body along a run, in radians, that counts as none: it turns the effect by
/// as much.
const MAX_TURN: f64 = 0.05;

/// Part of a phase span over which rates are differenced. The difference is of second order, so it
/// has an error of 1e-8 on a sine, and of rounding on cubic paths.
const DIFFERENCE: f64 = 1e-4;

/// Change of the rates between phases, relative to the largest rate, that is rounding.
const RATE_ROUNDING: f64 = 1e-9;

/// Displacements or velocities by cause, one per body of the scene, in its units.
///
/// The sum is the first-order effect of inertia: what it would add to the result of Stokes flow.
#[derive(Clone, Debug, PartialEq)]
pub struct InertialEffect {
    /// By the unsteady acceleration of the fluid.
    pub unsteady: Vec<Vector3<f64>>,
    /// By the convective acceleration of the fluid.
    pub convective: Vec<Vector3<f64>>,
    /// By the inertia of the bodies with a density.
    pub bodies: Vec<Vector3<f64>>,
}

/// What neglecting inertia costs in a result for a fluid with a density.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct NeglectedInertia {
    /// Reynolds number and frequency parameter.
    pub numbers: InertiaNumbers,
    /// The effect of inertia, or why it is not known.
    pub effect: Result<InertialEffect, String>,
    /// The effect by all causes along the result, relative to it: along the net displacement of a
    /// run, or along the velocity of the [`fastest_body`] of a solution. None if the effect is not
    /// known or the result is zero.
    pub relative: Option<f64>,
}

impl InertialEffect {
    fn zero(scene: &Scene) -> Self {
        let zero = vec![Vector3::zeros(); scene.bodies().len()];
        Self {
            unsteady: zero.clone(),
            convective: zero.clone(),
            bodies: zero,
        }
    }

    /// Adds the velocities of a change times a time.
    fn add(&mut self, time: f64, change: &InertialChange) {
        let causes = [&mut self.unsteady, &mut self.convective, &mut self.bodies];
        for (sums, (_, response)) in causes.into_iter().zip(change.causes()) {
            for (sum, body) in sums.iter_mut().zip(&response.bodies) {
                *sum += time * body.velocity;
            }
        }
    }

    /// Names and effects of the causes, in the order of the fields.
    pub fn causes(&self) -> [(&'static str, &[Vector3<f64>]); 3] {
        [
            ("unsteady", &self.unsteady),
            ("convective", &self.convective),
            ("bodies", &self.bodies),
        ]
    }

    /// The effect by all causes.
    pub fn total(&self) -> Vec<Vector3<f64>> {
        let parts = self.unsteady.iter().zip(&self.convective);
        (parts.zip(&self.bodies))
            .map(|((unsteady, convective), body)| unsteady + convective + body)
            .collect()
    }
}

impl NeglectedInertia {
    /// The numbers of a scene with bodies at these velocities; none for a fluid without density.
    fn new<'a>(
        scene: &Scene,
        velocities: impl Iterator<Item = &'a [BodySolution]>,
        effect: impl FnOnce() -> Result<InertialEffect, SwimError>,
    ) -> Result<Option<Self>, SwimError> {
        if scene.fluid_density() == 0.0 || scene.inertia().is_kept() {
            return Ok(None);
        }
        let numbers = InertiaNumbers::of_velocities(scene, velocities);
        let effect = match effect() {
            Ok(effect) => Ok(effect),
            // What neglected inertia costs is no reason to lose the result.
            Err(SwimError::Model(error)) => Err(error.to_string()),
            Err(other) => return Err(other),
        };
        Ok(Some(Self {
            numbers,
            effect,
            relative: None,
        }))
    }

    /// The same with the relative effect on a vector, of which `of` is the effect.
    fn relative_to(
        mut self,
        vector: Vector3<f64>,
        of: impl Fn(&[Vector3<f64>]) -> Vector3<f64>,
    ) -> Self {
        let along = |effect: &InertialEffect| of(&effect.total()).dot(&vector);
        let is_zero = vector == Vector3::zeros();
        self.relative = (self.effect.as_ref().ok().filter(|_| !is_zero))
            .map(|effect| along(effect) / vector.norm_squared());
        self
    }

    /// JSON: `reynolds`, `frequency`, `relative`, and the effect by body under `unsteady`,
    /// `convective`, `bodies` and `total`, or `unknown` with the reason.
    pub fn json(&self, scene: &Scene) -> Value {
        let mut map = Map::new();
        map.insert("reynolds".to_owned(), json!(self.numbers.reynolds));
        map.insert("frequency".to_owned(), json!(self.numbers.frequency));
        map.insert("relative".to_owned(), json!(self.relative));
        let by_body = |vectors: &[Vector3<f64>]| -> Value {
            let entry = |(body, v): (&scene::Body, &Vector3<f64>)| {
                (body.name.clone(), json!([v.x, v.y, v.z]))
            };
            Value::Object(scene.bodies().iter().zip(vectors).map(entry).collect())
        };
        match &self.effect {
            Ok(effect) => {
                for (cause, vectors) in effect.causes() {
                    map.insert(cause.to_owned(), by_body(vectors));
                }
                map.insert("total".to_owned(), by_body(&effect.total()));
            }
            Err(reason) => drop(map.insert("unknown".to_owned(), json!(reason))),
        }
        Value::Object(map)
    }
}

/// What neglecting inertia costs in the velocities at the start of a scene; none for a fluid
/// without density.
///
/// `bodies` is the solution there. The rates of the joints are those of [`solve_start`], which
/// change as in the first phase of the gait.
///
/// # Errors
/// [`SwimError::OtherScene`] for a model of another scene.
///
/// [`solve_start`]: crate::solve_start
pub fn start_neglected_inertia(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    bodies: &[BodySolution],
) -> Result<Option<NeglectedInertia>, SwimError> {
    let neglected = NeglectedInertia::new(scene, std::iter::once(bodies), || {
        let accelerations = spans(scene.gait(), scene.articulation().initial_shape())?
            .next()
            .map_or(vec![0.0; scene.articulation().joints().len()], |span| {
                accelerations(&span, 0.0)
            });
        let mut effect = InertialEffect::zero(scene);
        let change = at_start(scene, model, |model, configuration, rates| {
            model.neglected_inertia()?.change(&PathPoint {
                configuration,
                rates,
                accelerations: &accelerations,
            })
        })?;
        effect.add(1.0, &change);
        Ok(effect)
    })?;
    let fastest = fastest_body(bodies).unwrap_or(0);
    let velocity = bodies.get(fastest).map(|body| body.velocity);
    Ok(neglected.map(|neglected| {
        neglected.relative_to(velocity.unwrap_or_default(), |effect| {
            effect.get(fastest).copied().unwrap_or_default()
        })
    }))
}

/// The body whose centre is fastest; none without bodies.
pub fn fastest_body(bodies: &[BodySolution]) -> Option<usize> {
    let speeds = bodies.iter().map(|body| body.velocity.norm()).enumerate();
    // of equal speeds the first
    let faster = |a: (usize, f64), b: (usize, f64)| if b.1 > a.1 { b } else { a };
    speeds.reduce(faster).map(|(body, _)| body)
}

/// What neglecting inertia costs in the displacements of a completed run, from rest to rest; none
/// for a fluid without density.
///
/// The first-order changes of the velocities are integrated over the path of the run, with those by
/// the jumps of the rates between phases ([`models::NeglectedInertia::jump`]), at its start and at
/// its end. A change of the positions has no effect of its own on the velocities later, which is
/// exact in unbounded fluid and of the order of the shift over the distance of the walls in a
/// container. Not known for bodies that turn and for passive joints.
///
/// # Errors
/// [`SwimError::Interrupted`].
pub(crate) fn run_neglected_inertia(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    outcome: &Outcome,
    progress: &dyn Progress,
) -> Result<Option<NeglectedInertia>, SwimError> {
    let samples = outcome.samples.iter();
    let velocities = samples.filter_map(|sample| sample.bodies.as_deref());
    let neglected = NeglectedInertia::new(scene, velocities, || {
        if let Some(what) = without_displacement(scene, outcome) {
            let what = format!("the effect of neglected inertia on the displacement of {what}");
            let instead = "`swim solve` has that on the velocities at the start".to_owned();
            return Err(ModelError::Unsupported { what, instead }.into());
        }
        let check = || match progress.is_interrupted() {
            true => Err(SwimError::Interrupted {
                phases: outcome.spans.len(),
                all: outcome.spans.len(),
            }),
            false => Ok(()),
        };
        let mut effect = InertialEffect::zero(scene);
        let gauss = Gauss::new(GAUSS_POINTS);
        let mut before = vec![0.0; scene.articulation().joints().len()];
        let mut end = (0.0, scene.articulation().initial_shape().to_vec());
        let spans = spans(scene.gait(), scene.articulation().initial_shape())?;
        for span in spans.take(outcome.spans.len()) {
            check()?;
            let after = span.rates(0.0);
            add_jump(&mut effect, scene, model, outcome, &end, [&before, &after])?;
            for (&s, weight) in gauss.nodes.iter().zip(&gauss.weights) {
                check()?;
                let (time, shape) = (span.time(s), span.shape(s));
                let change = model.neglected_inertia()?.change(&PathPoint {
                    configuration: Configuration {
                        state: &state_at(scene, outcome, time),
                        shape: &shape,
                        time,
                    },
                    rates: &span.rates(s),
                    accelerations: &accelerations(&span, s),
                })?;
                effect.add(weight * span.duration, &change);
            }
            before = span.rates(1.0);
            end = (span.time(1.0), span.to);
        }
        let at_rest = vec![0.0; before.len()];
        add_jump(
            &mut effect,
            scene,
            model,
            outcome,
            &end,
            [&before, &at_rest],
        )?;
        Ok(effect)
    })?;
    let net = match outcome.resolved_net() > 0.0 {
        true => outcome.net_vector(),
        false => Vector3::zeros(),
    };
    Ok(
        neglected
            .map(|neglected| neglected.relative_to(net, |effect| mean_effect(outcome, effect))),
    )
}

/// The bodies of a run to whose displacement first-order velocities do not add up; none if they do.
fn without_displacement(scene: &Scene, outcome: &Outcome) -> Option<&'static str> {
    let turnings = outcome
        .samples
        .last()
        .map_or(&[][..], |last| &last.turnings);
    if outcome.stopped.is_some() {
        return Some("a run that stopped before its end");
    }
    if scene.has_passive_joints() {
        return Some("bodies with passive joints");
    }
    if turnings.iter().any(|turning| turning.angle > MAX_TURN) {
        return Some("bodies that turn");
    }
    None
}

/// Adds the effect of a jump of the rates at the end of a phase span, if they jump.
fn add_jump(
    effect: &mut InertialEffect,
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    outcome: &Outcome,
    (time, shape): &(f64, Vec<f64>),
    [before, after]: [&[f64]; 2],
) -> Result<(), SwimError> {
    let largest = before
        .iter()
        .chain(after)
        .fold(0.0, |m: f64, x| m.max(x.abs()));
    let jumps = |(before, after): (&f64, &f64)| (after - before).abs() > RATE_ROUNDING * largest;
    if !before.iter().zip(after).any(jumps) {
        return Ok(());
    }
    let configuration = Configuration {
        state: &state_at(scene, outcome, *time),
        shape,
        time: *time,
    };
    let change = model
        .neglected_inertia()?
        .jump(configuration, before, after)?;
    // The jump of a velocity is a displacement already.
    effect.add(1.0, &change);
    Ok(())
}

/// The state at a time of a run whose bodies do not turn, from the curve of their positions.
fn state_at(scene: &Scene, outcome: &Outcome, time: f64) -> State {
    let mut state = scene.initial_state();
    let next = outcome.curve.partition_point(|(at, _)| *at < time);
    let last = outcome.curve.len().saturating_sub(1);
    let points = outcome
        .curve
        .get(next.saturating_sub(1))
        .zip(outcome.curve.get(next.min(last)));
    let Some(((from, first), (to, second))) = points else {
        return state;
    };
    let part = match to > from {
        true => ((time - from) / (to - from)).clamp(0.0, 1.0),
        false => 0.0,
    };
    let linkages = scene.articulation().linkages();
    for (frame, linkage) in state.frames.iter_mut().zip(linkages) {
        let root = linkage.root;
        if let (Some(first), Some(second)) = (first.get(root), second.get(root)) {
            frame.translation.vector = first.lerp(second, part);
        }
    }
    state
}

/// Rates of change of the rates at `s`, from rates inside the phase span.
fn accelerations(span: &PhaseSpan, s: f64) -> Vec<f64> {
    let start = s.clamp(DIFFERENCE, 1.0 - DIFFERENCE);
    let rates = [-1.0, 0.0, 1.0].map(|step| span.rates(start + step * DIFFERENCE));
    let offset = (s - start) / DIFFERENCE;
    // The derivative of the parabola through three points at the offset from the middle one.
    let per_time = 1.0 / (DIFFERENCE * span.duration);
    (0..rates[1].len())
        .map(|joint| {
            let [before, middle, after] = [0, 1, 2].map(|k: usize| rates[k][joint]);
            per_time * (0.5 * (after - before) + offset * (after - 2.0 * middle + before))
        })
        .collect()
}

/// The mean of an effect over the bodies that move, as in [`Outcome::net`].
///
/// `outcome` tells which ones move.
pub fn mean_effect(outcome: &Outcome, effect: &[Vector3<f64>]) -> Vector3<f64> {
    let moving = outcome.displacement.iter().zip(effect);
    let moving: Vec<_> = moving
        .filter(|(displacement, _)| **displacement != Vector3::zeros())
        .map(|(_, effect)| *effect)
        .collect();
    mean_of_moving(&moving)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use scene::{Gait, Sine};

    #[test]
    fn accelerations_are_derivatives_of_the_rates_up_to_the_ends() {
        let sine = Sine {
            joint: 0,
            amplitude: 2.0,
            phase: 0.3,
            order: 1,
        };
        let period = 3.0;
        let gait = Gait::harmonic(1, vec![sine], period);
        let span = spans(&gait, &[8.0]).unwrap().next().unwrap();
        let omega = TAU / period;
        for s in [0.0, 0.4, 1.0] {
            let angle = 0.3 + omega * span.time(s);
            let expected = -2.0 * omega * omega * angle.sin();
            let found = accelerations(&span, s)[0];
            // (h^2 / 3) times the fourth derivative of the length, at the ends
            assert!(
                (found - expected).abs() < 1e-7 * 2.0 * omega * omega,
                "{s}: {found} {expected}"
            );
        }
    }
}
