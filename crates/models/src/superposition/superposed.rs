//! A model whose solutions are superposed.

use nalgebra::{DMatrix, DVector, Isometry3, Translation3, UnitQuaternion, Vector3};
use rigid::{State, StateVelocity};
use scene::Scene;

use super::drives::{CANDIDATES, Drives};
use super::solved::{Response, Solved};

use crate::discretisation_error::{DiscretisationError, Uncertainty};
use crate::error::ModelError;
use crate::hydrodynamics::{Configuration, Cost, ErrorEstimates, History, Hydrodynamics, Query};
use crate::record::{Layout, numbers};
use crate::solution::{BodySolution, FlowField, InstantaneousSolution, PointFlow};

/// Relative deviation from linearity that the error of the linear solver may cause.
const ROUNDING: f64 = 1e-6;

/// A model of one rigid body, or of a rigid assembly of bodies, whose solutions are superposed.
///
/// The model itself solves queries with rates of joints, with shapes other than that of the first
/// query, for stresslets, or with masses.
pub struct Superposed {
    model: Box<dyn Hydrodynamics>,
    drives: Drives,
    basis: Basis,
    last: Option<Placed>,
}

enum Basis {
    Pending,
    Computed(Box<Solved>),
    /// The model fails in an orientation, or its solutions are not linear in `d`.
    Impossible,
}

/// The last solution: coefficients of the basis and pose of the body.
struct Placed {
    coefficients: DVector<f64>,
    pose: Isometry3<f64>,
}

impl Superposed {
    /// Superposes the solutions of a model.
    ///
    /// Cost: the first query solves for as many orientations as `d` has independent components, at
    /// most 15 and fewer where symmetry planes keep the body from turning freely, and for one more,
    /// at which the deviation from linearity is measured. The deviation is added to the error bar
    /// `model`. Every further solution takes microseconds.
    ///
    /// # Errors
    /// [`ModelError::Unsupported`] if solutions of the scene cannot be superposed.
    pub fn new(model: Box<dyn Hydrodynamics>) -> Result<Self, ModelError> {
        let drives = Drives::of(model.scene()).ok_or_else(|| ModelError::Unsupported {
            what:
                "the superposition of solutions for a scene other than one rigid body, driven by \
                   loads, slip or a linear flow in unbounded fluid,"
                    .to_owned(),
            instead: "use the model alone".to_owned(),
        })?;
        Ok(Self {
            model,
            drives,
            basis: Basis::Pending,
            last: None,
        })
    }

    /// Number of solutions of a scene that are superposed; `None` if they cannot be superposed.
    pub fn count(scene: &Scene) -> Option<usize> {
        Some(Drives::of(scene)?.count())
    }

    /// Pose of the first body of a state, relative to its initial attitude.
    fn pose(&self, state: &State) -> Option<Isometry3<f64>> {
        let set = self.model.scene().articulation();
        let (root, frame) = (set.linkages().first()?.root, state.frames.first()?);
        let rotation = match set.has_own_attitude(root) {
            true => *state.attitudes.get(root)?,
            false => {
                let initial = set.initial_state().frames.first()?.rotation;
                frame.rotation * initial.inverse()
            }
        };
        Some(Isometry3::from_parts(frame.translation, rotation))
    }

    /// The initial state, rotated about the first body.
    fn rotated(&self, rotation: &UnitQuaternion<f64>) -> State {
        let set = self.model.scene().articulation();
        let mut state = set.initial_state();
        for frame in &mut state.frames {
            frame.rotation = rotation * frame.rotation;
        }
        for body in (0..state.attitudes.len()).filter(|&body| set.has_own_attitude(body)) {
            state.attitudes[body] = rotation * state.attitudes[body];
        }
        state
    }

    /// Adds `sign` times the velocity and rotation of the undisturbed flow to all motions.
    fn add_background(
        &self,
        sign: f64,
        state: &State,
        shape: &[f64],
        solution: &mut InstantaneousSolution,
    ) -> Result<(), ModelError> {
        let set = self.model.scene().articulation();
        let (flow, spin) = (&self.drives.background, sign * self.drives.rotation_rate());
        let poses = set.place(state, shape)?;
        for (body, pose) in solution.bodies.iter_mut().zip(&poses) {
            body.velocity += sign * flow.velocity(&pose.translation.vector);
            body.angular_velocity += spin;
        }
        let StateVelocity { frames, spins, .. } = &mut solution.motion;
        for (twist, frame) in frames.iter_mut().zip(&state.frames) {
            twist.linear += sign * flow.velocity(&frame.translation.vector);
            twist.angular += spin;
        }
        spins.iter_mut().for_each(|own| *own += spin);
        Ok(())
    }

    /// Solution of the model in one orientation, in the axes of the body.
    fn respond(
        &mut self,
        rotation: &UnitQuaternion<f64>,
        shape: &[f64],
    ) -> Result<Response, ModelError> {
        let state = self.rotated(rotation);
        let configuration = Configuration {
            state: &state,
            shape,
        };
        let rates = vec![0.0; shape.len()];
        let mut solution = self.model.solve_one(configuration, &rates)?;
        solution.check(self.model.as_ref())?;
        self.add_background(-1.0, &state, shape, &mut solution)?;
        solution.rotate(&rotation.inverse());
        let flow = self.model.last_flow().and_then(|mut flow| {
            let about = state.frames.first()?.translation;
            let to_body = (about * rotation * about.inverse()).inverse();
            for (velocity, x) in flow.velocity.iter_mut().zip(flow.mesh.points()) {
                *velocity = to_body.rotation * (*velocity - self.drives.background.velocity(x));
            }
            flow.mesh = moved(&flow, &to_body)?;
            Some(flow)
        });
        Ok(Response {
            numbers: numbers(&solution),
            solution,
            flow,
        })
    }

    /// Solutions for all orientations of the basis; `None` if they are not linear.
    fn solve_basis(&mut self, shape: &[f64]) -> Result<Option<Solved>, ModelError> {
        let Some((rotations, inverse)) = self.drives.basis() else {
            return Ok(None);
        };
        // The state after an interruption, so that resumed runs give bitwise equal results.
        let history = self.model.history()?;
        self.model.restore(&history)?;
        let responses = rotations
            .iter()
            .map(|rotation| self.respond(rotation, shape));
        let solutions = responses.collect::<Result<Vec<_>, _>>()?;
        let scene = self.model.scene();
        let layout = Layout {
            bodies: scene.bodies().len(),
            joints: scene.articulation().joints().len(),
            mesh_errors: solutions[0].solution.mesh_error.is_some(),
        };
        let mut solved = Solved {
            shape: shape.to_vec(),
            layout,
            inverse,
            solutions,
            deviation: 0.0,
        };
        let more = self.drives.orientation(CANDIDATES);
        let direct = self.respond(&more, shape)?;
        let coefficients = &solved.inverse * self.drives.data(&more);
        let superposed = solved.combination(&coefficients);
        let bodies = self.model.scene().bodies().iter();
        let reach = bodies.map(|body| body.bounding_radius());
        let reach = reach.fold(0.0, f64::max);
        let difference =
            DiscretisationError::between(&direct.solution, &superposed, Uncertainty::default());
        solved.deviation = fastest(&difference.motion, &difference.bodies, reach);
        let allowed = direct.solution.error_estimate.total()
            + superposed.error_estimate.total()
            + ROUNDING * fastest(&direct.solution.motion, &direct.solution.bodies, reach);
        // A larger deviation is not an error of the model: the solutions are not linear.
        Ok((solved.deviation <= allowed).then_some(solved))
    }

    /// Whether a query can be superposed: no joint moves, and the shape is that of the basis.
    fn serves(&self, query: &Query, rates: &[f64]) -> bool {
        let is_basis = |shape: &[f64]| match &self.basis {
            Basis::Pending => true,
            Basis::Computed(solved) => solved.shape == shape,
            Basis::Impossible => false,
        };
        query.inertia.is_none()
            && query.joint_forces.is_none()
            && query.accuracy.is_none()
            && !query.stresslets
            && rates.iter().all(|rate| *rate == 0.0)
            && is_basis(query.configuration.shape)
    }

    /// The superposed solution; `None` if the model has to solve the query.
    fn superpose(
        &mut self,
        query: &Query,
        rates: &[f64],
    ) -> Result<Option<InstantaneousSolution>, ModelError> {
        let Configuration { state, shape } = query.configuration;
        if !self.serves(query, rates) {
            return Ok(None);
        }
        if let Basis::Pending = self.basis {
            // An error is not reported here: the model then solves the query itself.
            let solved = self.solve_basis(shape).ok().flatten();
            self.basis = solved.map_or(Basis::Impossible, |s| Basis::Computed(Box::new(s)));
        }
        let (Basis::Computed(solved), Some(pose)) = (&self.basis, self.pose(state)) else {
            return Ok(None);
        };
        let coefficients = &solved.inverse * self.drives.data(&pose.rotation);
        let mut solution = solved.combination(&coefficients);
        solution.rotate(&pose.rotation);
        self.add_background(1.0, state, shape, &mut solution)?;
        self.last = Some(Placed { coefficients, pose });
        Ok(Some(solution))
    }
}

/// Upper bound of the speed of all bodies and frames: `|U| + reach |ω|`.
fn fastest(motion: &StateVelocity, bodies: &[BodySolution], reach: f64) -> f64 {
    let of_bodies = bodies
        .iter()
        .map(|body| (body.velocity, body.angular_velocity));
    let of_frames = motion
        .frames
        .iter()
        .map(|twist| (twist.linear, twist.angular));
    let of_spins = motion.spins.iter().map(|spin| (Vector3::zeros(), *spin));
    let all = of_bodies.chain(of_frames).chain(of_spins);
    all.map(|(linear, angular)| linear.norm() + reach * angular.norm())
        .fold(0.0, f64::max)
}

/// The mesh of a flow field after a rigid motion.
fn moved(flow: &FlowField, motion: &Isometry3<f64>) -> Option<mesh::TetMesh> {
    let points = flow.mesh.points().iter();
    let points = points.map(|x| motion.rotation * x + motion.translation.vector);
    flow.mesh.with_points(points.collect()).ok()
}

impl Hydrodynamics for Superposed {
    fn name(&self) -> &'static str {
        self.model.name()
    }

    fn scene(&self) -> &Scene {
        self.model.scene()
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        let mut solutions = Vec::with_capacity(query.rates.len());
        for rates in query.rates {
            match self.superpose(query, rates)? {
                Some(solution) => solutions.push(solution),
                None => {
                    self.last = None;
                    return self.model.solve(query);
                }
            }
        }
        Ok(solutions)
    }

    fn error_estimates(&self) -> ErrorEstimates {
        match (&self.basis, self.model.error_estimates()) {
            (Basis::Impossible, given) | (_, given @ ErrorEstimates::Never) => given,
            _ => ErrorEstimates::Always,
        }
    }

    fn controls_error(&self) -> bool {
        self.model.controls_error()
    }

    fn resistance(&mut self, configuration: Configuration<'_>) -> Result<DMatrix<f64>, ModelError> {
        self.model.resistance(configuration)
    }

    fn resistance_errors(
        &mut self,
        configuration: Configuration<'_>,
    ) -> Result<Option<DMatrix<f64>>, ModelError> {
        self.model.resistance_errors(configuration)
    }

    fn history(&self) -> Result<History, ModelError> {
        self.model.history()
    }

    fn restore(&mut self, history: &History) -> Result<(), ModelError> {
        self.model.restore(history)
    }

    fn mesh(
        &mut self,
        configuration: Configuration<'_>,
    ) -> Result<Option<mesh::TetMesh>, ModelError> {
        self.model.mesh(configuration)
    }

    fn last_flow(&self) -> Option<FlowField> {
        let (Basis::Computed(solved), Some(last)) = (&self.basis, &self.last) else {
            return self.model.last_flow();
        };
        let mut sum = solved.solutions.first()?.flow.clone()?;
        sum.velocity.fill(Vector3::zeros());
        sum.pressure.fill(0.0);
        for (response, &c) in solved.solutions.iter().zip(&last.coefficients) {
            let flow = response.flow.as_ref()?;
            let velocities = sum.velocity.iter_mut().zip(&flow.velocity);
            velocities.for_each(|(sum, u)| *sum += c * u);
            let pressures = sum.pressure.iter_mut().zip(&flow.pressure);
            pressures.for_each(|(sum, p)| *sum += c * p);
        }
        let initial = self
            .model
            .scene()
            .initial_state()
            .frames
            .first()?
            .translation;
        let motion = last.pose * Translation3::from(-initial.vector);
        sum.mesh = moved(&sum, &motion)?;
        let rotation = last.pose.rotation;
        for (velocity, x) in sum.velocity.iter_mut().zip(sum.mesh.points()) {
            *velocity = rotation * *velocity + self.drives.background.velocity(x);
        }
        Some(sum)
    }

    fn flow(
        &mut self,
        configuration: Configuration<'_>,
        rates: &[f64],
    ) -> Result<FlowField, ModelError> {
        self.last = None;
        self.model.flow(configuration, rates)
    }

    fn flow_at(
        &mut self,
        configuration: Configuration<'_>,
        rates: &[f64],
        points: &[Vector3<f64>],
    ) -> Result<Vec<Option<PointFlow>>, ModelError> {
        self.last = None;
        self.model.flow_at(configuration, rates, points)
    }

    fn joint_responses(
        &mut self,
        configuration: Configuration<'_>,
    ) -> Result<Vec<StateVelocity>, ModelError> {
        self.model.joint_responses(configuration)
    }

    fn cost(&mut self, configuration: Configuration<'_>) -> Result<Cost, ModelError> {
        self.model.cost(configuration)
    }
}
