//! What the terms that a run neglects would change about its result, to first order.

use models::{
    AxisymmetricModel, BodySolution, Configuration, FemModel, FirstOrderChange, Hydrodynamics,
    ModelError, NeglectedTerm, PathPoint,
};
use nalgebra::Vector3;
use rigid::State;
use scene::{InertiaKind, PhaseSpan, RheologyKind, Scene, SceneError, spans};
use serde_json::{Map, Value, json};

use crate::error::SwimError;
use crate::gauss::Gauss;
use crate::inertia_numbers::InertiaNumbers;
use crate::observer::{Progress, check_interruption};
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

/// First-order effect of a neglected term on displacements or velocities, in the scene's units:
/// what the term would add to the result.
#[derive(Clone, Debug, PartialEq)]
pub struct NeglectedEffect {
    term: NeglectedTerm,
    /// By part, one vector per body of the scene.
    parts: Vec<(&'static str, Vec<Vector3<f64>>)>,
}

/// What neglecting a term costs in a result.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Neglected {
    /// The term.
    pub term: NeglectedTerm,
    /// Reynolds number and frequency parameter; for inertia.
    pub numbers: Option<InertiaNumbers>,
    /// The effect, or why it is not known.
    pub effect: Result<NeglectedEffect, String>,
    /// The effect along the result, relative to it: along the net displacement of a run, or along
    /// the velocity of the [`fastest_body`] of a solution. None if the effect is not known or the
    /// result is zero or below its error bar.
    pub relative: Option<f64>,
}

impl NeglectedEffect {
    fn new(term: NeglectedTerm) -> Self {
        Self {
            term,
            parts: Vec::new(),
        }
    }

    /// Adds the velocities of a change times a time.
    fn add(&mut self, time: f64, change: &FirstOrderChange) {
        for (name, response) in &change.parts {
            let velocities = response.bodies.iter().map(|body| time * body.velocity);
            match self.parts.iter_mut().find(|(part, _)| part == name) {
                Some((_, sums)) => sums
                    .iter_mut()
                    .zip(velocities)
                    .for_each(|(sum, v)| *sum += v),
                None => self.parts.push((name, velocities.collect())),
            }
        }
    }

    /// Names of the parts, which are those of the [`NeglectedTerm`], with their effects on each
    /// body.
    pub fn parts(&self) -> impl Iterator<Item = (&'static str, &[Vector3<f64>])> {
        (self.parts.iter()).map(|(name, vectors)| (*name, vectors.as_slice()))
    }

    /// The effect on each body: the sum of the parts, or the first of them if they are forms of the
    /// same change.
    pub fn total(&self) -> Vec<Vector3<f64>> {
        let mut parts = self.parts.iter().map(|(_, vectors)| vectors);
        let mut total = parts.next().cloned().unwrap_or_default();
        for part in parts.filter(|_| self.term.adds_up()) {
            total.iter_mut().zip(part).for_each(|(sum, v)| *sum += v);
        }
        total
    }

    /// Largest size of a vector `of` the effect: of the sum, or of a form.
    pub fn largest(&self, of: impl Fn(&[Vector3<f64>]) -> Vector3<f64>) -> f64 {
        let forms = match self.term.adds_up() {
            true => vec![self.total()],
            false => (self.parts.iter().map(|(_, vectors)| vectors.clone())).collect(),
        };
        forms.iter().map(|form| of(form).norm()).fold(0.0, f64::max)
    }
}

/// Whether flows of a scene do without a term that its fluid has.
fn is_neglected(scene: &Scene, term: NeglectedTerm) -> bool {
    match term {
        // Random velocities have no rates of change.
        NeglectedTerm::Inertia => {
            scene.fluid_density() != 0.0 && !scene.inertia().is_kept() && scene.noise().is_none()
        }
        NeglectedTerm::Rheology => scene.rheology().is_some_and(|rheology| !rheology.is_kept()),
    }
}

/// Whether a scene lets the effect of a term decide about it.
pub(crate) fn is_automatic(scene: &Scene, term: NeglectedTerm) -> bool {
    match term {
        NeglectedTerm::Inertia => scene.inertia().kind == InertiaKind::Auto,
        NeglectedTerm::Rheology => {
            (scene.rheology()).is_some_and(|rheology| rheology.kind == RheologyKind::Auto)
        }
    }
}

/// The scene with a term that it neglected.
pub(crate) fn with_term(scene: &Scene, term: NeglectedTerm) -> Result<Scene, SceneError> {
    match term {
        NeglectedTerm::Inertia => scene.with_inertia(InertiaKind::Full),
        NeglectedTerm::Rheology => scene.with_rheology(RheologyKind::Full),
    }
}

impl Neglected {
    /// The cost of neglecting a term in a scene with bodies at these velocities; none for a term
    /// that the fluid does not have or the flow follows.
    fn new<'a>(
        scene: &Scene,
        term: NeglectedTerm,
        velocities: impl Iterator<Item = &'a [BodySolution]>,
        effect: impl FnOnce() -> Result<NeglectedEffect, SwimError>,
    ) -> Result<Option<Self>, SwimError> {
        if !is_neglected(scene, term) {
            return Ok(None);
        }
        let numbers = match term {
            NeglectedTerm::Inertia => Some(InertiaNumbers::of_velocities(scene, velocities)),
            NeglectedTerm::Rheology => None,
        };
        let effect = match effect() {
            Ok(effect) => Ok(effect),
            // What neglecting a term costs is no reason to lose the result.
            Err(SwimError::Model(error)) => Err(error.to_string()),
            Err(other) => return Err(other),
        };
        Ok(Some(Self {
            term,
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
        let along = |effect: &NeglectedEffect| of(&effect.total()).dot(&vector);
        let is_zero = vector == Vector3::zeros();
        self.relative = (self.effect.as_ref().ok().filter(|_| !is_zero))
            .map(|effect| along(effect) / vector.norm_squared());
        self
    }

    /// Key of the JSON: `neglected_inertia` or `neglected_rheology`.
    pub fn key(&self) -> &'static str {
        match self.term {
            NeglectedTerm::Inertia => "neglected_inertia",
            NeglectedTerm::Rheology => "neglected_rheology",
        }
    }

    /// JSON: `reynolds` and `frequency` for inertia, `relative`, and the effect by body under the
    /// names of the parts and, if these add up, `total`, or `unknown` with the reason.
    pub fn json(&self, scene: &Scene) -> Value {
        let mut map = Map::new();
        if let Some(numbers) = &self.numbers {
            map.insert("reynolds".to_owned(), json!(numbers.reynolds));
            map.insert("frequency".to_owned(), json!(numbers.frequency));
        }
        map.insert("relative".to_owned(), json!(self.relative));
        let by_body = |vectors: &[Vector3<f64>]| -> Value {
            let entry = |(body, v): (&scene::Body, &Vector3<f64>)| {
                (body.name.clone(), json!([v.x, v.y, v.z]))
            };
            Value::Object(scene.bodies().iter().zip(vectors).map(entry).collect())
        };
        match &self.effect {
            Ok(effect) => {
                for (part, vectors) in effect.parts() {
                    map.insert(part.to_owned(), by_body(vectors));
                }
                if self.term.adds_up() {
                    map.insert("total".to_owned(), by_body(&effect.total()));
                }
            }
            Err(reason) => drop(map.insert("unknown".to_owned(), json!(reason))),
        }
        Value::Object(map)
    }
}

/// What neglected terms cost in the velocities at the start of a scene.
///
/// `bodies` is the solution there. The rates of the joints are those of [`solve_start`], which
/// change as in the first phase of the gait.
///
/// # Errors
/// [`SwimError::OtherScene`] for a model of another scene.
///
/// [`solve_start`]: crate::solve_start
pub fn start_neglected(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    bodies: &[BodySolution],
) -> Result<Vec<Neglected>, SwimError> {
    let fastest = fastest_body(bodies).unwrap_or(0);
    let velocity = bodies.get(fastest).map(|body| body.velocity);
    let of_term = |term: NeglectedTerm| {
        let neglected = Neglected::new(scene, term, std::iter::once(bodies), || {
            let accelerations = spans(scene.gait(), scene.articulation().initial_shape())?
                .next()
                .map_or(vec![0.0; scene.articulation().joints().len()], |span| {
                    accelerations(&span, 0.0)
                });
            let mut effect = NeglectedEffect::new(term);
            with_model(scene, term, model, |model| {
                let change = at_start(scene, model, |model, configuration, rates| {
                    let at = PathPoint {
                        configuration,
                        rates,
                        accelerations: &accelerations,
                    };
                    model.neglected(term)?.change(term, &at)
                })?;
                effect.add(1.0, &change);
                Ok(())
            })?;
            Ok(effect)
        })?;
        Ok(neglected.map(|neglected| {
            neglected.relative_to(velocity.unwrap_or_default(), |effect| {
                effect.get(fastest).copied().unwrap_or_default()
            })
        }))
    };
    let costs = NeglectedTerm::ALL.into_iter().map(of_term);
    costs.filter_map(Result::transpose).collect()
}

/// Calls `evaluate` with a model that can tell the effect of a term.
///
/// It is `model` if that can. A viscosity law has its effect in the meridian plane, at the cost of
/// a second; elements in space are taken only where the scene lets the effect decide.
fn with_model(
    scene: &Scene,
    term: NeglectedTerm,
    model: &mut dyn Hydrodynamics,
    evaluate: impl FnOnce(&mut dyn Hydrodynamics) -> Result<(), SwimError>,
) -> Result<(), SwimError> {
    if model.neglected(term).is_ok() {
        return evaluate(model);
    }
    let is_plane = AxisymmetricModel::supports(scene)
        && AxisymmetricModel::without_law_change(scene).is_none();
    if term == NeglectedTerm::Rheology && is_plane {
        return evaluate(&mut AxisymmetricModel::new(scene)?);
    }
    match is_automatic(scene, term) {
        true => evaluate(&mut FemModel::new(scene)?),
        false => evaluate(model),
    }
}

/// The body whose centre is fastest; none without bodies.
pub fn fastest_body(bodies: &[BodySolution]) -> Option<usize> {
    let speeds = bodies.iter().map(|body| body.velocity.norm()).enumerate();
    // of equal speeds the first
    let faster = |a: (usize, f64), b: (usize, f64)| if b.1 > a.1 { b } else { a };
    speeds.reduce(faster).map(|(body, _)| body)
}

/// What neglected terms cost in the displacements of a completed run, from rest to rest.
///
/// The first-order changes of the velocities are integrated over the path of the run, with those of
/// inertia by the jumps of the rates between phases ([`models::NeglectedTerms::jump`]), at its
/// start and at its end. A change of the positions has no effect of its own on the velocities
/// later, which is exact in unbounded fluid and of the order of the shift over the distance of the
/// walls in a container. Not known for bodies that turn and for passive joints.
///
/// # Errors
/// [`SwimError::Interrupted`].
pub(crate) fn run_neglected(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    outcome: &Outcome,
    progress: &mut dyn Progress,
) -> Result<Vec<Neglected>, SwimError> {
    let net = match resolved_net(outcome) > 0.0 {
        true => outcome.net_vector(),
        false => Vector3::zeros(),
    };
    let mut of_term = |term: NeglectedTerm| {
        let samples = outcome.samples.iter();
        let velocities = samples.filter_map(|sample| sample.bodies.as_deref());
        let neglected = Neglected::new(scene, term, velocities, || {
            let mut effect = NeglectedEffect::new(term);
            with_model(scene, term, model, |model| {
                add_run(&mut effect, scene, model, outcome, progress)
            })?;
            Ok(effect)
        })?;
        Ok(neglected
            .map(|neglected| neglected.relative_to(net, |effect| mean_effect(outcome, effect))))
    };
    let costs = NeglectedTerm::ALL.into_iter().map(&mut of_term);
    costs.filter_map(Result::transpose).collect()
}

/// The net displacement to which effects are compared: zero if it is rounding, or below its error
/// bar.
pub fn resolved_net(outcome: &Outcome) -> f64 {
    let net = outcome.resolved_net();
    match net > outcome.error_estimate.total() {
        true => net,
        false => 0.0,
    }
}

/// Adds the effect along the path of a run.
fn add_run(
    effect: &mut NeglectedEffect,
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    outcome: &Outcome,
    progress: &mut dyn Progress,
) -> Result<(), SwimError> {
    let term = effect.term;
    if let Some(what) = without_displacement(scene, outcome) {
        let term = term.name();
        let what = format!("the effect of neglecting {term} on the displacement of {what}");
        let instead = "`swim solve` has that on the velocities at the start".to_owned();
        return Err(ModelError::Unsupported { what, instead }.into());
    }
    let phases = outcome.spans.len();
    let gauss = Gauss::new(GAUSS_POINTS);
    let mut before = vec![0.0; scene.articulation().joints().len()];
    let mut end = (0.0, scene.articulation().initial_shape().to_vec());
    let spans = spans(scene.gait(), scene.articulation().initial_shape())?;
    for span in spans.take(outcome.spans.len()) {
        let work = format!("what neglecting {} changes", term.name());
        progress.works(&work, span.number as f64, phases as f64);
        let after = span.rates(0.0);
        add_jump(effect, scene, model, outcome, &end, [&before, &after])?;
        for (&s, weight) in gauss.nodes.iter().zip(&gauss.weights) {
            check_interruption(progress, phases, phases)?;
            let (time, shape) = (span.time(s), span.shape(s));
            let at = PathPoint {
                configuration: Configuration {
                    state: &state_at(scene, outcome, time),
                    shape: &shape,
                    time,
                },
                rates: &span.rates(s),
                accelerations: &accelerations(&span, s),
            };
            let change = model.neglected(term)?.change(term, &at)?;
            effect.add(weight * span.duration, &change);
        }
        before = span.rates(1.0);
        end = (span.time(1.0), span.to);
    }
    let at_rest = vec![0.0; before.len()];
    add_jump(effect, scene, model, outcome, &end, [&before, &at_rest])
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

/// Adds the effect of inertia by a jump of the rates at the end of a phase span, if they jump; a
/// viscosity law has no memory.
fn add_jump(
    effect: &mut NeglectedEffect,
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
    if effect.term != NeglectedTerm::Inertia || !before.iter().zip(after).any(jumps) {
        return Ok(());
    }
    let configuration = Configuration {
        state: &state_at(scene, outcome, *time),
        shape,
        time: *time,
    };
    let inertia = model.neglected(effect.term)?;
    let change = inertia.jump(configuration, before, after)?;
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
