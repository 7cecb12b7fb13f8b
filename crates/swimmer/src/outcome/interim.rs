//! The state of a run between two phase spans, to which the next one is appended.

use models::AccumulatedError;
use nalgebra::Vector3;
use rigid::{Articulation, State};
use scene::{PhaseSpan, Scene};

use super::displacement_errors::{
    corrected_bar, displacement_bars, errors_of_bodies, largest_error, uncorrected_bars,
};
use super::sample::uniform_times;
use super::{Outcome, PeriodicStart, Sample, SpanOutcome};
use crate::error::SwimError;
use crate::integrate::{SpanResult, UnsteadyState, enter_table};
use crate::linkage_works::LinkageWork;
use crate::mean_flow::MeanFlowInTime;
use crate::turning::Turning;

/// Points of the curve per piece of a phase span: enough for a smooth plot.
const CURVE_POINTS: usize = 12;

/// Largest number of points between two samples at which turns are counted.
const MAX_PARTS: f64 = 1e6;

/// The state of a run between two phase spans.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Interim {
    /// State of the bodies.
    pub state: State,
    /// The fluid if it has inertia; none at a start that is not periodic.
    pub fluid: Option<UnsteadyState>,
    /// Outcome of the completed phase spans.
    pub outcome: Outcome,
}

impl Interim {
    /// The state before the first phase span.
    ///
    /// # Errors
    /// A linkage whose loop the initial shape does not close.
    pub fn start(scene: &Scene) -> Result<Self, SwimError> {
        Self::from_state(scene, scene.initial_state())
    }

    /// A state before the first phase span, such as one with other values of passive joints.
    ///
    /// # Errors
    /// A state of another articulation, or one in which a loop does not close.
    pub fn from_state(scene: &Scene, state: State) -> Result<Self, SwimError> {
        let set = scene.articulation();
        let shape = set.initial_shape();
        let origin = positions(set, &state, shape)?;
        let poses = set.place(&state, shape)?;
        let outcome = Outcome {
            displacement: vec![Vector3::zeros(); origin.len()],
            accumulated_error: Some(AccumulatedError::default()),
            accumulated_integration_error: Some(AccumulatedError::default()),
            tolerance_met: true,
            samples: vec![Sample {
                time: 0.0,
                span: 0,
                shape: set.joint_values(&state, shape)?,
                turnings: vec![Turning::default(); poses.len()],
                poses,
                bodies: None,
                interpolated: None,
                kinetic_energy: None,
                added_mass: None,
            }],
            curve: vec![(0.0, origin)],
            ..Outcome::default()
        };
        Ok(Self {
            state,
            fluid: None,
            outcome,
        })
    }

    /// Positions of all bodies in the present state.
    pub(crate) fn positions(
        &self,
        scene: &Scene,
        shape: &[f64],
    ) -> Result<Vec<Vector3<f64>>, SwimError> {
        positions(scene.articulation(), &self.state, shape)
    }

    /// Appends a phase span: the state becomes that at its end, and the outcome includes it.
    ///
    /// `origin` are the positions from which displacements count.
    pub(crate) fn append(
        &mut self,
        scene: &Scene,
        origin: &[Vector3<f64>],
        span: &PhaseSpan,
        result: &SpanResult,
    ) -> Result<(), SwimError> {
        let set = scene.articulation();
        let before = self.positions(scene, &span.from)?;
        self.state = result.end.clone();
        self.fluid.clone_from(&result.fluid);
        let after = self.positions(scene, &end_of(span, result))?;
        let outcome = &mut self.outcome;
        outcome.append_trajectory(scene, span, result)?;
        outcome.append_displacement(set, span, result, [&before, &after]);
        outcome.append_remainder(span);
        outcome.displacement = after.iter().zip(origin).map(|(a, b)| a - b).collect();
        outcome.velocities.clone_from(&result.velocities);
        outcome.append_costs_and_work(result);
        outcome.estimate_errors(set, &after);
        Ok(())
    }
}

impl Outcome {
    /// Appends the solves and the end of a phase span to the trajectory.
    fn append_trajectory(
        &mut self,
        scene: &Scene,
        span: &PhaseSpan,
        result: &SpanResult,
    ) -> Result<(), SwimError> {
        let set = scene.articulation();
        let start = match &self.periodic_start {
            Some(start) => start.rotation,
            None => scene.initial_state().frames[0].rotation,
        };
        let last = self.samples.last();
        let mut turnings = last.map_or(Vec::new(), |sample| sample.turnings.clone());
        turnings.resize(scene.bodies().len(), Turning::default());
        let mut before = result.state(set, 0.0)?;
        let mut poses = set.place(&before, &span.from)?;
        let bodies = (result.solutions.iter()).flat_map(|solution| &solution.solution.bodies);
        let frames =
            (result.solutions.iter()).flat_map(|solution| &solution.solution.motion.frames);
        let velocities =
            (bodies.map(|body| body.angular_velocity)).chain(frames.map(|frame| frame.angular));
        let fastest = velocities.fold(0.0, |most: f64, velocity| most.max(velocity.norm()));
        let mut from = 0.0;
        let mut sample = |s: f64, end: Option<&State>, bodies| {
            // Steps of half a radian, in which no turn is lost.
            let parts = (2.0 * fastest * span.duration * (s - from))
                .ceil()
                .clamp(1.0, MAX_PARTS);
            let mut values = Vec::new();
            for part in 1..=parts as usize {
                let at = from + (s - from) * part as f64 / parts;
                let (state, shape) = match end {
                    Some(end) if part as f64 == parts => (end.clone(), end_of(span, result)),
                    _ => (result.state(set, at)?, span.shape(at)),
                };
                let reached = set.place(&state, &shape)?;
                values = set.joint_values(&state, &shape)?;
                for ((turning, now), then) in turnings.iter_mut().zip(&reached).zip(&poses) {
                    turning.append(&(now.rotation * then.rotation.inverse()));
                }
                poses = reached;
                let (now, then) = (state.frames[0].rotation, before.frames[0].rotation);
                self.turning.append(&(now * then.inverse()));
                self.rotation = self.turning.rotation_vector(&(now * start.inverse()));
                before = state;
            }
            from = s;
            Ok::<_, SwimError>(Sample {
                time: span.time(s),
                span: span.number,
                shape: values,
                poses: poses.clone(),
                turnings: turnings.clone(),
                bodies,
                interpolated: None,
                kinetic_energy: None,
                added_mass: None,
            })
        };
        // Velocities with inertia begin with those of the start, which no solution has.
        let has_inertia = scene.inertia().is_kept() || scene.has_masses();
        if let ([start], false) = (&mut self.samples[..], has_inertia) {
            start.interpolated = result.bodies(0.0);
        }
        let reached = result.reached();
        let uniform = uniform_times(scene, span, self.uniform_samples.len(), reached);
        let mut uniform = uniform.into_iter().peekable();
        let at_end = |solution: &&crate::SpanSolution| solution.s >= reached;
        for solution in &result.solutions {
            if at_end(&solution) {
                continue;
            }
            while let Some(s) = uniform.next_if(|s| *s < solution.s) {
                self.uniform_samples
                    .push(sample(s, None, result.bodies(s))?);
            }
            let bodies = Some(solution.solution.bodies.clone());
            self.samples.push(Sample {
                kinetic_energy: solution.kinetic_energy,
                added_mass: solution.added_mass.clone(),
                ..sample(solution.s, None, bodies)?
            });
        }
        for s in uniform {
            self.uniform_samples
                .push(sample(s, None, result.bodies(s))?);
        }
        let last = result.solutions.last().filter(at_end);
        let bodies = last.map(|solution| solution.solution.bodies.clone());
        self.samples.push(Sample {
            interpolated: match bodies {
                Some(_) => None,
                None => result.bodies(reached),
            },
            kinetic_energy: last.and_then(|solution| solution.kinetic_energy),
            added_mass: last.and_then(|solution| solution.added_mass.clone()),
            ..sample(reached, Some(&result.end), bodies)?
        });
        // Steps of thermal noise are short.
        let points = scene.noise().map_or(CURVE_POINTS, |_| 1);
        let parts = points * result.pieces.len();
        for k in 1..=parts {
            let s = reached * (k as f64 / parts as f64);
            let at = positions(set, &result.state(set, s)?, &span.shape(s))?;
            self.curve.push((span.time(s), at));
        }
        Ok(())
    }

    /// Appends the displacement over a phase span between two lists of positions, with its errors.
    fn append_displacement(
        &mut self,
        set: &Articulation,
        span: &PhaseSpan,
        result: &SpanResult,
        [before, after]: [&[Vector3<f64>]; 2],
    ) {
        let displacement: Vec<_> = after.iter().zip(before).map(|(a, b)| a - b).collect();
        let of_roots: Vec<_> = (set.linkages().iter())
            .map(|linkage| displacement[linkage.root])
            .collect();
        let mesh = result.accumulated_error.as_ref();
        let integration = result.accumulated_integration_error.as_ref();
        let largest = |error: &AccumulatedError| largest_error(set, error, after);
        let accumulated = (mesh, &result.accumulated_model_error, integration);
        self.spans.push(SpanOutcome {
            joints: span.joints.clone(),
            solves: result.solves,
            lookups: result.lookups,
            error_estimate: displacement_bars(&result.error_estimate, accumulated, largest),
            displacement,
        });
        type Append = fn(&mut AccumulatedError, &AccumulatedError, &[Vector3<f64>]);
        let appended = |sum: &mut Option<AccumulatedError>, of_span, append: Append| {
            let (mut sum, of_span) = sum.take().zip(of_span)?;
            append(&mut sum, of_span, &of_roots);
            Some(sum)
        };
        self.accumulated_error =
            appended(&mut self.accumulated_error, mesh, AccumulatedError::append);
        // Phases, and cycles even more, have similar errors.
        (self.accumulated_model_error)
            .append_correlated(&result.accumulated_model_error, &of_roots);
        self.accumulated_integration_error = appended(
            &mut self.accumulated_integration_error,
            integration,
            AccumulatedError::append_correlated,
        );
    }

    /// Adds what remains of a periodic start: in each cycle once, because it is that of all ends of
    /// its phases.
    fn append_remainder(&mut self, span: &PhaseSpan) {
        let Some(PeriodicStart { remainder, .. }) = &self.periodic_start else {
            return;
        };
        let accumulated = self.accumulated_integration_error.as_mut();
        if let (Some(error), 0) = (accumulated, span.phase) {
            error.add_uncertainty(remainder);
        }
        if let Some(bars) = self.spans.last_mut().map(|span| &mut span.error_estimate) {
            // of both ends
            let bar = bars
                .integration
                .map(|bar| bar + 2.0 * remainder.displacement);
            bars.integration = bar;
        }
    }

    /// Adds what is a sum over phase spans.
    fn append_costs_and_work(&mut self, result: &SpanResult) {
        self.solves += result.solves;
        self.lookups += result.lookups;
        for (table, solves) in result.tables.iter().enumerate().filter(|(_, n)| **n > 0) {
            enter_table(&mut self.tables, table, *solves);
        }
        self.error_estimate.accumulate(1.0, &result.error_estimate);
        self.rotation_error.accumulate(1.0, &result.rotation_error);
        self.work += result.work;
        LinkageWork::add_each(&mut self.linkage_works, &result.linkage_works);
        MeanFlowInTime::append(&mut self.mean_flow_integral, result.mean_flow.as_ref());
        self.work_error.accumulate(1.0, &result.work_error);
        self.holding.accumulate(1.0, &result.holding);
        self.seconds += result.seconds;
    }

    /// Replaces sums of error bars by those of the accumulated errors, which have signs.
    fn estimate_errors(&mut self, set: &Articulation, positions: &[Vector3<f64>]) {
        let accumulated = self.accumulated_error.as_ref();
        self.mesh_error = accumulated.map(|error| errors_of_bodies(set, error, positions));
        self.error_estimate.mesh = accumulated.map(|error| corrected_bar(set, error, positions));
        self.rotation_error.mesh = accumulated.map(AccumulatedError::rotation_error_bar);
        self.work_error.mesh = accumulated.map(AccumulatedError::work_error_bar);
        let of_model = uncorrected_bars(set, &self.accumulated_model_error, positions);
        for (bars, bar) in [
            (&mut self.error_estimate, of_model.displacement),
            (&mut self.rotation_error, of_model.rotation),
            (&mut self.work_error, of_model.work),
        ] {
            bars.model = bars.model.map(|_| bar);
        }
        let integration = self.accumulated_integration_error.as_ref();
        let bars = integration.map(|error| uncorrected_bars(set, error, positions));
        self.error_estimate.integration = bars.map(|bars| bars.displacement);
        self.rotation_error.integration = bars.map(|bars| bars.rotation);
        self.work_error.integration = bars.map(|bars| bars.work);
        let of_holding = bars.filter(|_| !self.holding.bodies.is_empty());
        self.holding.force_error.integration = of_holding.map(|bars| bars.holding[0]);
        self.holding.torque_error.integration = of_holding.map(|bars| bars.holding[1]);
    }
}

/// Values of the joints where a result ends.
fn end_of(span: &PhaseSpan, result: &SpanResult) -> Vec<f64> {
    match result.reached() < 1.0 {
        true => span.shape(result.reached()),
        false => span.to.clone(),
    }
}

/// Positions of all bodies.
pub fn positions(
    set: &Articulation,
    state: &State,
    shape: &[f64],
) -> Result<Vec<Vector3<f64>>, SwimError> {
    Ok(set
        .place(state, shape)?
        .iter()
        .map(|pose| pose.translation.vector)
        .collect())
}

#[cfg(test)]
mod tests {
    use models::UncorrectedBars;
    use nalgebra::UnitQuaternion;

    use super::*;

    /// Also of cycles that a resumed run appends.
    #[test]
    fn bug_each_cycle_after_a_periodic_start_has_the_bars_of_what_remains() {
        let text = r#"
            bodies = [
                { name = "a", radius = 1, position = [-2, 0, 0] },
                { name = "b", radius = 1, position = [2, 0, 0] },
            ]
            links = [{ name = "arm", body = "b", to = "a" }]
            gait.cycles = 3
            gait.phases = [{ link = "arm", length = 3.5 }, { link = "arm", length = 4 }]
        "#;
        let scene = Scene::parse(text).unwrap();
        let mut outcome = Interim::start(&scene).unwrap().outcome;
        outcome.periodic_start = Some(PeriodicStart {
            cycles: 3,
            residual: 0.0,
            energy_residual: 0.0,
            remainder: UncorrectedBars {
                displacement: 1.0,
                rotation: 2.0,
                work: 3.0,
                holding: [4.0, 5.0],
            },
            rotation: UnitQuaternion::identity(),
        });
        let shape = scene.articulation().initial_shape();
        for span in scene::spans(scene.gait(), shape).unwrap() {
            outcome.append_remainder(&span);
            let cycles = (span.number / 2 + 1) as f64;
            let error = outcome.accumulated_integration_error.as_ref().unwrap();
            let bars = error.uncorrected_error_bars(0.0);
            assert_eq!(
                [bars.displacement, bars.rotation, bars.work],
                [1.0, 2.0, 3.0].map(|bar| bar * cycles)
            );
            assert_eq!(bars.holding, [4.0 * cycles, 5.0 * cycles]);
        }
    }
}
