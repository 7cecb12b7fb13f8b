//! The outcome of a gait.

use models::{AccumulatedError, BodySolution, ErrorEstimate, NewMesh, Seconds, UncorrectedBars};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use rigid::{Articulation, State};
use scene::{PhaseSpan, Scene};
use serde::{Deserialize, Serialize};

use crate::added_mass::AddedMassForces;
use crate::error::SwimError;
use crate::holding_loads::HoldingLoads;
use crate::integrate::{SpanResult, TABLE_SHARE, UnsteadyState, enter_table};
use crate::kinetic_energy::KineticEnergy;
use crate::linkage_works::add_each;
use crate::motion::TIME_ROUNDING;
use crate::turning::Turning;

/// Points of the curve per piece of a phase span: enough for a smooth plot.
const CURVE_POINTS: usize = 12;

/// Largest number of points between two samples at which turns are counted.
const MAX_PARTS: f64 = 1e6;

/// Rounding of a net displacement, relative to the longest path: some hundred sums of positions.
const POSITION_ROUNDING: f64 = 1e-13;

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

/// The outcome of a gait, in the scene's units.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[non_exhaustive]
pub struct Outcome {
    /// Displacement of every body, including points.
    pub displacement: Vec<Vector3<f64>>,
    /// Rotation vector of the frame of the first linkage, with full turns
    /// ([`Turning::rotation_vector`]).
    pub rotation: Vector3<f64>,
    /// Rotation of that frame along its path.
    #[serde(default)]
    pub turning: Turning,
    /// Outcome of each phase span.
    pub spans: Vec<SpanOutcome>,
    /// Number of solutions: by a solve, or looked up in a table over shapes.
    pub solves: usize,
    /// Number of these that were looked up.
    #[serde(default)]
    pub lookups: usize,
    /// Number of solves that each of the tables is made of.
    #[serde(default)]
    pub tables: Vec<usize>,
    /// Error bars of the displacements.
    pub error_estimate: ErrorEstimate,
    /// Error bars of the rotation vectors, in radians.
    #[serde(default)]
    pub rotation_error: ErrorEstimate,
    /// Estimated discretisation errors that were subtracted from the displacements, computed minus
    /// exact, one per body.
    pub mesh_error: Option<Vec<Vector3<f64>>>,
    /// Accumulated discretisation error of the phase spans so far; none where a phase span has no
    /// estimate.
    #[serde(rename = "drift")]
    pub accumulated_error: Option<AccumulatedError>,
    /// Accumulated error by the model, computed minus exact; without a sign where solutions have
    /// none.
    #[serde(default)]
    pub accumulated_model_error: AccumulatedError,
    /// Accumulated integration error, computed minus exact; its uncertainty is all that is known
    /// where methods estimate a size. None where a phase span has no estimate.
    #[serde(default, rename = "integration_drift")]
    pub accumulated_integration_error: Option<AccumulatedError>,
    /// The error bar that `model.tolerance` limits, at the end of the gait; none if the integration
    /// error is not estimated.
    ///
    /// It is the sum of all error bars for a model that controls its own error
    /// ([`models::Capabilities::controls_error`]), and that of the integration for other models.
    #[serde(default)]
    pub limited_error: Option<f64>,
    /// Largest value of `limited_error` that meets the tolerance: `model.tolerance` times a length.
    ///
    /// The length is [`Outcome::reference_displacement`] or, if that is longer, `net_arc`; with
    /// slip or a background flow, `longest_arc`. Where all solutions are looked up in tables of a
    /// model that does not control its error, a tenth of its error bar is allowed as well: the
    /// integration asks for no less.
    #[serde(default)]
    pub allowed_error: f64,
    /// Largest distance that a point of a surface covers by the rotation of its body, over the
    /// gait; set at its end.
    #[serde(default)]
    pub longest_arc: f64,
    /// The same by the rotation of a body from the start to the end, with all full turns.
    #[serde(default)]
    pub net_arc: f64,
    /// Whether `limited_error` is at most `allowed_error`.
    pub tolerance_met: bool,
    /// Work of the bodies on the fluid.
    pub work: f64,
    /// Work of the bodies of each linkage on the fluid; empty where it is known in total only
    /// ([`SwimmerOutcome::work`](crate::SwimmerOutcome::work)).
    #[serde(default)]
    pub linkage_works: Vec<f64>,
    /// Error bars of the work.
    #[serde(default)]
    pub work_error: ErrorEstimate,
    /// Impulses of the loads that hold or drive bodies ([`Outcome::mean_holding`]).
    #[serde(default)]
    pub holding: HoldingLoads,
    /// Velocities `(U, ω)` of all bodies at the end, six per body; empty without masses.
    #[serde(default)]
    pub velocities: Vec<f64>,
    /// How the run began in the periodic state of a fluid with inertia; none for other starts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub periodic_start: Option<PeriodicStart>,
    /// Seconds of all solves, added up also where they ran at the same time.
    pub seconds: Seconds,
    /// The meshes that were generated, for models with a mesh.
    #[serde(default)]
    pub meshes: Vec<NewMesh>,
    /// The trajectory at the ends of phase spans and at the solves, in the order of time.
    pub samples: Vec<Sample>,
    /// The trajectory at equal intervals of time, if the scene asks for it (`output.samples`).
    ///
    /// Loads are those of the polynomial through the solves of a step; at the end of a phase, where
    /// rates jump, they are those before it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub uniform_samples: Vec<Sample>,
    /// Why the run stopped before its end, such as contact, in words; none for a completed run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stopped: Option<String>,
    /// The trajectory between the samples, for plots: times and positions of all bodies.
    pub curve: Vec<(f64, Vec<Vector3<f64>>)>,
}

impl Outcome {
    /// The net displacement: the distance that the mean of the centres of the moving bodies covers.
    ///
    /// A rotation about that mean is no displacement. Fixed bodies do not count.
    pub fn net(&self) -> f64 {
        self.net_vector().norm()
    }

    /// The mean displacement of the centres of the moving bodies.
    pub fn net_vector(&self) -> Vector3<f64> {
        mean_of_moving(&self.displacement)
    }

    /// The work without the correction of its discretisation error.
    pub fn uncorrected_work(&self) -> f64 {
        self.work
            + self
                .accumulated_error
                .as_ref()
                .map_or(0.0, |error| error.work)
    }

    /// Mean force and torque, over the time of the gait so far, on each body whose velocity is
    /// given; none without such bodies.
    ///
    /// A fixed body that holds a swimmer receives the opposite of its mean thrust. Errors of the
    /// discretisation are those that remain after its correction, without regard to their signs.
    pub fn mean_holding(&self) -> Option<HoldingLoads> {
        let time = self.samples.last()?.time;
        let is_mean = time > 0.0 && !self.holding.bodies.is_empty();
        is_mean.then(|| self.holding.over(time))
    }

    /// Number of solves of the model, with those of its tables.
    pub fn model_solves(&self) -> usize {
        self.solves - self.lookups + self.tables.iter().sum::<usize>()
    }

    /// Size of net displacements that are rounding.
    pub fn rounding(&self) -> f64 {
        POSITION_ROUNDING * self.longest_path()
    }

    /// The net displacement, or zero if it is rounding.
    pub fn resolved_net(&self) -> f64 {
        let net = self.net();
        if net > self.rounding() { net } else { 0.0 }
    }

    /// The longest displacement of a body in one phase, or `longest_arc` if that is longer.
    fn longest_path(&self) -> f64 {
        let spans = self.spans.iter().flat_map(|span| &span.displacement);
        spans.fold(self.longest_arc.max(self.net()), |longest, d| {
            longest.max(d.norm())
        })
    }

    /// The displacement to which `model.tolerance` is relative: the net displacement.
    ///
    /// If the net displacement cannot be distinguished from zero, by its error bar or by the
    /// rounding of positions, as for reciprocal gaits and bodies that rotate in place, it is the
    /// longest displacement of a body in one phase or, if that is longer, `longest_arc`.
    pub fn reference_displacement(&self) -> f64 {
        let net = self.net();
        match net > self.error_estimate.total().max(self.rounding()) {
            true => net,
            false => self.longest_path(),
        }
    }

    /// The change of the shape over the gait; none if the prescribed joints return to their values.
    pub fn shape_change(&self, scene: &Scene) -> Option<ShapeChange> {
        let (first, last) = self.samples.first().zip(self.samples.last())?;
        let joints = scene.shape_changes(&first.shape, &last.shape);
        let body = scene.articulation().linkages().first()?.root;
        (!joints.is_empty()).then_some(ShapeChange {
            joints,
            body,
            displacement: self.displacement.get(body).copied()?,
            rotation: self.rotation,
        })
    }

    /// Largest distances that a point of a surface covers by the rotation of its body: along the
    /// whole path, and about the axis of the whole rotation.
    fn arcs(&self, scene: &Scene) -> [f64; 2] {
        let turnings = self.samples.last().map_or(&[][..], |last| &last.turnings);
        let largest = |angle: fn(&Turning) -> f64| {
            let bodies = scene.bodies().iter().zip(turnings);
            bodies
                .map(|(body, turning)| angle(turning) * body.bounding_radius())
                .fold(0.0, f64::max)
        };
        [
            largest(|turning| turning.angle),
            largest(|turning| turning.vector.norm()),
        ]
    }

    /// Compares the error bar that `model.tolerance` limits with it, at the end of the gait.
    ///
    /// `controls_error` says whether the model keeps its own error below its share of the tolerance
    /// ([`models::Capabilities::controls_error`]).
    ///
    /// The rounding of positions, `ε n (x + p)` with the coordinates `x` and the longest path `p`
    /// after `n` phase spans, is added to the bar of the integration.
    pub fn check_tolerance(&mut self, scene: &Scene, controls_error: bool) {
        let poses = self.samples.last().map_or(&[][..], |last| &last.poses);
        let distance = poses
            .iter()
            .fold(0.0_f64, |far, pose| far.max(pose.translation.vector.norm()));
        let sums = self.spans.len() as f64 * (distance + self.longest_path());
        let bars = &mut self.error_estimate;
        bars.integration = bars.integration.map(|bar| bar + f64::EPSILON * sums);
        self.limited_error = bars.integration.map(|error| match controls_error {
            true => bars.total(),
            false => error,
        });
        [self.longest_arc, self.net_arc] = self.arcs(scene);
        let arc = match scene.has_surface_velocity() {
            // Bodies may tumble in place.
            true => self.longest_arc,
            false => self.net_arc,
        };
        self.allowed_error = scene.model().tolerance * self.reference_displacement().max(arc);
        if !controls_error && self.solves > 0 && self.lookups == self.solves {
            let bars = &self.error_estimate;
            let [mesh, integration] = [bars.mesh, bars.integration].map(|bar| bar.unwrap_or(0.0));
            let left = TABLE_SHARE * (bars.total() - mesh - integration);
            self.allowed_error = self.allowed_error.max(left);
        }
        // Methods without an error estimate do not meet a tolerance. With thermal noise there is no
        // exact displacement, and the tolerance limits single solutions.
        let limited = self.limited_error;
        self.tolerance_met = match scene.noise() {
            Some(_) => true,
            None => limited.is_some_and(|error| error <= self.allowed_error),
        };
    }
}

/// The mean of the nonzero displacements; only those of fixed bodies are exactly zero.
pub fn mean_of_moving(displacement: &[Vector3<f64>]) -> Vector3<f64> {
    let moving = displacement.iter().filter(|d| **d != Vector3::zeros());
    let count = moving.clone().count().max(1);
    moving.sum::<Vector3<f64>>() / count as f64
}

/// The change of the shape over a gait that is not closed.
///
/// The displacements of the bodies, and their mean, then contain the change of the shape, which
/// depends on the joints alone. The rigid part is the motion of the frame in which the shape is
/// described, that of the first body of the first linkage.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ShapeChange {
    /// The joints whose values differ at the end, with the changes.
    pub joints: Vec<(usize, f64)>,
    /// The body whose motion is the rigid part.
    pub body: usize,
    /// Displacement of the rigid part.
    pub displacement: Vector3<f64>,
    /// Rotation vector of the rigid part, with all full turns.
    pub rotation: Vector3<f64>,
}

/// How a run with inertia of the fluid began in its periodic state.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PeriodicStart {
    /// Number of cycles before the run.
    pub cycles: usize,
    /// Difference of the displacement since the start of the cycle to that in the cycle before, of
    /// all bodies and ends of phases the largest, with the rotation of the body times its radius,
    /// in the axes of its linkage at the start of the cycle; the larger of the last two.
    pub residual: f64,
    /// Difference of the kinetic energies before and after a cycle, relative to the largest one in
    /// it; the larger of the last two.
    pub energy_residual: f64,
    /// Error bars of displacement, rotation, work and holding impulses in a cycle by what remains
    /// of the start.
    pub remainder: UncorrectedBars,
    /// Rotation of the frame of the first linkage where the run begins.
    pub rotation: UnitQuaternion<f64>,
}

/// The outcome of one phase span.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[non_exhaustive]
pub struct SpanOutcome {
    /// The joints that changed their values.
    pub joints: Vec<usize>,
    /// Displacement of every body.
    pub displacement: Vec<Vector3<f64>>,
    /// Number of solutions.
    pub solves: usize,
    /// Number of these that were looked up in tables.
    #[serde(default)]
    pub lookups: usize,
    /// Error bars of the displacements.
    pub error_estimate: ErrorEstimate,
}

/// One point of the trajectory.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[non_exhaustive]
pub struct Sample {
    /// Time.
    pub time: f64,
    /// Number of the phase span from zero, over all cycles.
    pub span: usize,
    /// Values of the joints.
    pub shape: Vec<f64>,
    /// Pose of every body.
    pub poses: Vec<Isometry3<f64>>,
    /// Rotation of every body since the start.
    #[serde(default)]
    pub turnings: Vec<Turning>,
    /// Velocities and forces, if they were solved for at this time; none at the ends of phase
    /// spans.
    pub bodies: Option<Vec<BodySolution>>,
    /// Velocities and forces where nothing was solved, at the start and at the ends of phase spans:
    /// those of the polynomial through the solves of the step before ([`SpanResult::bodies`]), at
    /// the start of the first step after. None where a phase span has no solves, and at the start
    /// where fluid or bodies have inertia.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interpolated: Option<Vec<BodySolution>>,
    /// Kinetic energy of fluid and bodies, for fluids with inertia; none at equal intervals of
    /// time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kinetic_energy: Option<KineticEnergy>,
    /// Forces that accelerate the fluid, as the kinetic energy; in the meridian plane at every
    /// second step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub added_mass: Option<AddedMassForces>,
}

impl Sample {
    /// Whether the model was solved at this time: at no time that the scene asks for at equal
    /// intervals, where all numbers are interpolated.
    pub fn is_solved(&self, scene: &Scene) -> bool {
        self.bodies.is_some() && scene.output().samples.is_none()
    }

    /// Velocities and forces of the bodies: solved for or, where nothing is solved, interpolated.
    pub fn loads(&self) -> Option<&[BodySolution]> {
        self.bodies.as_deref().or(self.interpolated.as_deref())
    }
}

/// Positions on a phase span, up to `reached`, of the times at equal intervals that follow the
/// first `known` ones; none unless the scene asks for them.
fn uniform_times(scene: &Scene, span: &PhaseSpan, known: usize, reached: f64) -> Vec<f64> {
    let Some(intervals) = scene.output().samples else {
        return Vec::new();
    };
    let step = scene.gait().duration() / f64::from(intervals);
    let position = |number: usize| (number as f64 * step - span.start) / span.duration;
    (known..=intervals as usize)
        .map(position)
        .take_while(|s| *s <= reached + TIME_ROUNDING)
        .map(|s| s.clamp(0.0, reached))
        .collect()
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
    /// The samples that `trajectory.csv` shows: those at equal intervals of time, if the scene asks
    /// for them, else all.
    pub fn trajectory(&self) -> &[Sample] {
        match self.uniform_samples.is_empty() {
            true => &self.samples,
            false => &self.uniform_samples,
        }
    }

    /// Kinetic energy of fluid and bodies at the end, for fluids with inertia.
    pub fn kinetic_energy(&self) -> Option<KineticEnergy> {
        self.samples.last()?.kinetic_energy
    }

    /// Forces that accelerate the fluid at the end, for fluids with inertia.
    pub fn added_mass(&self) -> Option<&AddedMassForces> {
        self.samples.last()?.added_mass.as_ref()
    }

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
        add_each(&mut self.linkage_works, &result.linkage_works);
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

/// Error bars of displacements by the accumulated errors of mesh, model and integration, of which
/// `largest` is the largest of a body; other sources have their given bars.
pub(crate) fn displacement_bars(
    bars: &ErrorEstimate,
    (mesh, model, integration): (
        Option<&AccumulatedError>,
        &AccumulatedError,
        Option<&AccumulatedError>,
    ),
    largest: impl Fn(&AccumulatedError) -> f64,
) -> ErrorEstimate {
    let uncorrected =
        |error: &AccumulatedError| error.uncorrected_error_bars(largest(error)).displacement;
    ErrorEstimate {
        mesh: mesh.map(|error| error.displacement_error_bar(largest(error))),
        model: bars.model.map(|_| uncorrected(model)),
        integration: integration.map(uncorrected),
        ..*bars
    }
}

/// Error bar of displacements from which an accumulated error was subtracted.
fn corrected_bar(set: &Articulation, error: &AccumulatedError, positions: &[Vector3<f64>]) -> f64 {
    error.displacement_error_bar(largest_error(set, error, positions))
}

/// Error bars by the model or the integration, whose errors are not subtracted.
fn uncorrected_bars(
    set: &Articulation,
    error: &AccumulatedError,
    positions: &[Vector3<f64>],
) -> UncorrectedBars {
    error.uncorrected_error_bars(largest_error(set, error, positions))
}

fn largest_error(set: &Articulation, error: &AccumulatedError, positions: &[Vector3<f64>]) -> f64 {
    let linkages = 0..set.linkages().len();
    linkages.fold(0.0, |largest, number| {
        largest.max(largest_error_of(set, number, error, positions))
    })
}

/// Largest error of the displacement of a body of a linkage.
pub(crate) fn largest_error_of(
    set: &Articulation,
    number: usize,
    error: &AccumulatedError,
    positions: &[Vector3<f64>],
) -> f64 {
    let errors = errors_of_linkage(set, number, error, positions);
    errors.fold(0.0, |largest, (_, error)| largest.max(error.norm()))
}

/// Errors of the displacements of the bodies, from the errors of the frames of their linkages.
fn errors_of_bodies(
    set: &Articulation,
    error: &AccumulatedError,
    positions: &[Vector3<f64>],
) -> Vec<Vector3<f64>> {
    let mut errors = vec![Vector3::zeros(); positions.len()];
    for number in 0..set.linkages().len() {
        for (body, error) in errors_of_linkage(set, number, error, positions) {
            errors[body] = error;
        }
    }
    errors
}

/// The bodies of a linkage with the errors of their displacements.
fn errors_of_linkage<'a>(
    set: &'a Articulation,
    number: usize,
    error: &'a AccumulatedError,
    positions: &'a [Vector3<f64>],
) -> impl Iterator<Item = (usize, Vector3<f64>)> + 'a {
    let linkage = &set.linkages()[number];
    let arm = move |body: usize| positions[body] - positions[linkage.root];
    (linkage.bodies.iter()).map(move |&body| (body, error.of_body(number, &arm(body))))
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

    #[test]
    fn fixed_bodies_do_not_dilute_the_net_displacement() {
        let [fixed, moving] = [Vector3::zeros(), Vector3::new(3.0, 4.0, 0.0)];
        assert_eq!(mean_of_moving(&[moving, fixed, moving]), moving);
        assert_eq!(mean_of_moving(&[fixed]), fixed);
    }
}
