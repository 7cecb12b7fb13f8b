//! Solutions of a rigid body in a linear flow, superposed from a few orientations.
//!
//! Consider one rigid body in unbounded fluid. In the axes of the body, the flow around it is
//! linear in a vector `d` of few components: the external forces and torques, the rate of strain of
//! the background flow, and the slip. The solution depends on the position and the rotation `R` of
//! the body only through `d` and the background velocity:
//!
//! ```text
//! R^T (U - u(x)), R^T (ω - curl u / 2), R^T forces = linear functions of d
//! d = (R^T F, R^T T, R^T E R, slip)
//! ```
//!
//! with the undisturbed flow `u` and its rate of strain `E` (Brenner 1964; Kim & Karrila 1991,
//! section 5.2). A model solves for as many orientations `R` as `d` has independent components, at
//! most 15; the solution for any other orientation is a linear combination. A body that tumbles in
//! shear takes five solutions, and one more as a check, instead of hundreds. A model that uses
//! symmetry planes keeps the body in them: one plane leaves rotations about its normal, two none,
//! and `d` has fewer independent components.

mod drives;

use std::sync::Arc;

use nalgebra::{DMatrix, DVector, Isometry3, Translation3, UnitQuaternion, Vector3};
use rigid::State;
use scene::{Background, Scene};

use self::drives::{CANDIDATES, Drives};
use crate::discretisation_error::{DiscretisationError, Uncertainty};
use crate::error::ModelError;
use crate::flow_field::{FlowField, SolutionFlow};
use crate::hydrodynamics::{Capabilities, ErrorEstimates, Hydrodynamics};
use crate::query::{Configuration, Query};
use crate::response::Response;
use crate::solution::{ErrorEstimate, InstantaneousSolution};

/// Relative deviation from linearity that the error of the linear solver may cause.
const ROUNDING: f64 = 1e-6;

/// A model of one rigid body, or of a rigid assembly of bodies, whose solutions are superposed.
///
/// The model itself solves queries with rates of joints, with shapes other than that of the first
/// query, for stresslets, with masses, or with flows if the first query was without them.
pub struct Superposed {
    model: Box<dyn Hydrodynamics>,
    drives: Drives,
    basis: Basis,
}

enum Basis {
    Pending,
    Computed(Arc<Solved>),
    /// The model fails in an orientation, or its solutions are not linear in `d`.
    Impossible,
}

/// Solutions for the orientations of the basis, in the axes of the body, without the background
/// flow.
struct Solved {
    shape: Vec<f64>,
    /// Inverse of the matrix whose columns are the vectors `d` of the orientations.
    inverse: DMatrix<f64>,
    solutions: Vec<InstantaneousSolution>,
    /// Flows of the solutions, if they were requested and the model has them.
    flows: Option<Vec<FlowField>>,
    /// Largest difference between superposed and direct velocities at one further orientation.
    deviation: f64,
    /// Radius of the largest body: the deviation of angular velocities is at most that over it.
    radius: f64,
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
        let drives = Drives::new(model.scene()).ok_or_else(|| {
            let what = "the superposition of solutions for a scene other than one rigid body, \
                        driven by loads, slip or a linear flow in unbounded fluid,";
            ModelError::unsupported(what, "use the model alone")
        })?;
        Ok(Self {
            model,
            drives,
            basis: Basis::Pending,
        })
    }

    /// Number of solutions of a scene that are superposed; `None` if they cannot be superposed.
    pub fn count(scene: &Scene) -> Option<usize> {
        Some(Drives::new(scene)?.count())
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
        response: &mut Response,
    ) -> Result<(), ModelError> {
        let set = self.model.scene().articulation();
        let (flow, spin) = (&self.drives.background, sign * self.drives.rotation_rate());
        let poses = set.place(state, shape)?;
        for (body, pose) in response.bodies.iter_mut().zip(&poses) {
            body.velocity += sign * flow.velocity(&pose.translation.vector);
            body.angular_velocity += spin;
        }
        let motion = &mut response.motion;
        for (twist, frame) in motion.frames.iter_mut().zip(&state.frames) {
            twist.linear += sign * flow.velocity(&frame.translation.vector);
            twist.angular += spin;
        }
        motion.spins.iter_mut().for_each(|own| *own += spin);
        Ok(())
    }

    /// Solution of the model in one orientation, in the axes of the body.
    fn respond(
        &mut self,
        rotation: &UnitQuaternion<f64>,
        shape: &[f64],
        flows: bool,
    ) -> Result<(InstantaneousSolution, Option<FlowField>), ModelError> {
        let state = &self.rotated(rotation);
        let rates = [vec![0.0; shape.len()]];
        let query = Query::new(Configuration::new(state, shape), &rates).with_flows(flows);
        let model = self.model.name();
        let mut solution =
            (self.model.solve(&query)?.pop()).ok_or(ModelError::NoSolution { model })?;
        solution.check(self.model.as_ref())?;
        self.add_background(-1.0, state, shape, &mut solution)?;
        solution.rotate(&rotation.inverse());
        let flow = match (solution.flow.take(), state.frames.first()) {
            (Some(flow), Some(frame)) => Some(self.flow_in_body(flow, frame, rotation)?),
            _ => None,
        };
        Ok((solution, flow))
    }

    /// The disturbance flow of a body with this frame and rotation, in the axes of the body.
    fn flow_in_body(
        &self,
        flow: SolutionFlow,
        frame: &Isometry3<f64>,
        rotation: &UnitQuaternion<f64>,
    ) -> Result<FlowField, ModelError> {
        let mut flow = flow.into_field()?;
        let about = frame.translation;
        let to_body = (about * rotation * about.inverse()).inverse();
        for (velocity, x) in flow.velocity.iter_mut().zip(flow.mesh.points()) {
            *velocity -= self.drives.background.velocity(x);
        }
        flow.move_by(&to_body)?;
        Ok(flow)
    }

    /// Solutions for all orientations of the basis; `None` if they are not linear.
    fn solve_basis(&mut self, shape: &[f64], flows: bool) -> Result<Option<Solved>, ModelError> {
        let Some((rotations, inverse)) = self.drives.basis() else {
            return Ok(None);
        };
        // The state after an interruption, so that resumed runs give bitwise equal results.
        let history = self.model.history()?;
        self.model.restore(&history)?;
        let responses = rotations
            .iter()
            .map(|rotation| self.respond(rotation, shape, flows))
            .collect::<Result<Vec<_>, _>>()?;
        let (solutions, flows): (Vec<_>, Vec<_>) = responses.into_iter().unzip();
        let mut solved = Solved {
            shape: shape.to_vec(),
            inverse,
            solutions,
            flows: flows.into_iter().collect(),
            deviation: 0.0,
            radius: f64::INFINITY,
        };
        let more = self.drives.orientation(CANDIDATES);
        let (direct, _) = self.respond(&more, shape, false)?;
        let coefficients = &solved.inverse * self.drives.data(&more);
        let superposed = solved.combination(&coefficients);
        let bodies = self.model.scene().bodies().iter();
        let radius = bodies
            .map(|body| body.bounding_radius())
            .fold(0.0, f64::max);
        solved.deviation = (&direct.response - &superposed.response).largest_speed(radius);
        solved.radius = radius;
        let allowed = direct.error_estimate.total()
            + superposed.error_estimate.total()
            + ROUNDING * direct.largest_speed(radius);
        // A larger deviation is not an error of the model: the solutions are not linear.
        Ok((solved.deviation <= allowed).then_some(solved))
    }

    /// Whether a query can be superposed: no joint moves, and the shape is that of the basis.
    fn serves(&self, query: &Query, rates: &[f64]) -> bool {
        let is_basis = match &self.basis {
            Basis::Pending => true,
            Basis::Computed(solved) => {
                let has_flows = solved.flows.is_some() || !self.model.capabilities().has_mesh;
                solved.shape == query.configuration.shape && (has_flows || !query.flows)
            }
            Basis::Impossible => false,
        };
        query.inertia.is_none()
            && query.random_loads.is_none()
            && query.accuracy.is_none()
            && !query.stresslets
            && rates.iter().all(|rate| *rate == 0.0)
            && is_basis
    }

    /// The superposed solution; `None` if the model has to solve the query.
    fn superpose(
        &mut self,
        query: &Query,
        rates: &[f64],
    ) -> Result<Option<InstantaneousSolution>, ModelError> {
        let Configuration { state, shape, .. } = query.configuration;
        if !self.serves(query, rates) {
            return Ok(None);
        }
        if let Basis::Pending = self.basis {
            // An error is not reported here: the model then solves the query itself.
            let solved = self.solve_basis(shape, query.flows).ok().flatten();
            self.basis = solved.map_or(Basis::Impossible, |s| Basis::Computed(Arc::new(s)));
        }
        let (Basis::Computed(solved), Some(pose)) = (&self.basis, self.pose(state)) else {
            return Ok(None);
        };
        let coefficients = &solved.inverse * self.drives.data(&pose.rotation);
        let mut solution = solved.combination(&coefficients);
        solution.rotate(&pose.rotation);
        self.add_background(1.0, state, shape, &mut solution)?;
        let initial = self.model.scene().initial_state();
        if let (true, Some(_), Some(frame)) = (query.flows, &solved.flows, initial.frames.first()) {
            let (solved, background) = (solved.clone(), self.drives.background);
            let motion = pose * Translation3::from(-frame.translation.vector);
            solution.flow = Some(SolutionFlow::new(move || {
                solved.flow(&coefficients, &motion, &background)
            }));
        }
        Ok(Some(solution))
    }
}

impl Solved {
    /// The linear combination of the solutions, in the axes of the body, with its error bars.
    pub fn combination(&self, coefficients: &DVector<f64>) -> InstantaneousSolution {
        let first = &self.solutions[0];
        let mut response = first.response.clone().zero();
        let mut error = (first.mesh_error.clone()).map(|error| error.response.zero());
        let mut error_estimate = ErrorEstimate::default();
        let [
            mut angular_velocity_error,
            mut force_error,
            mut torque_error,
            mut power_error,
        ] = [ErrorEstimate::default(); 4];
        let mut uncertainty = Uncertainty::default();
        // Powers are quadratic: roots of their uncertainties are summed.
        let mut root_of_power = 0.0;
        for (solution, &c) in self.solutions.iter().zip(coefficients) {
            response.accumulate(c, &solution.response);
            error_estimate.accumulate(c.abs(), &solution.error_estimate);
            angular_velocity_error.accumulate(c.abs(), &solution.angular_velocity_error);
            force_error.accumulate(c.abs(), &solution.force_error);
            torque_error.accumulate(c.abs(), &solution.torque_error);
            power_error.accumulate(c.abs(), &solution.power_error);
            if let (Some(sum), Some(term)) = (&mut error, &solution.mesh_error) {
                sum.accumulate(c, &term.response);
                uncertainty.relative = uncertainty.relative.max(term.uncertainty.relative);
                uncertainty.velocity += c.abs() * term.uncertainty.velocity;
                uncertainty.angular_velocity += c.abs() * term.uncertainty.angular_velocity;
                uncertainty.force += c.abs() * term.uncertainty.force;
                root_of_power += c.abs() * term.uncertainty.power.sqrt();
            }
        }
        uncertainty.power = root_of_power * root_of_power;
        let add = |bars: &mut ErrorEstimate, deviation: f64| {
            bars.model = Some(bars.model.unwrap_or(0.0) + deviation);
        };
        add(&mut error_estimate, self.deviation);
        add(&mut angular_velocity_error, self.deviation / self.radius);
        let mut solution = InstantaneousSolution {
            dofs: first.dofs,
            solver: first.solver.clone(),
            error_estimate,
            angular_velocity_error,
            force_error,
            torque_error,
            power_error,
            ..response.into()
        };
        if let Some(response) = error {
            solution.set_mesh_error(DiscretisationError {
                response,
                uncertainty,
            });
        }
        solution
    }

    /// The linear combination of the flows after a rigid motion, with the background flow.
    ///
    /// # Errors
    /// Flows that were not requested; points that overflow.
    fn flow(
        &self,
        coefficients: &DVector<f64>,
        motion: &Isometry3<f64>,
        background: &Background,
    ) -> Result<FlowField, ModelError> {
        let flows = self.flows.as_deref().unwrap_or_default();
        let mut sum = flows.first().ok_or(ModelError::NoMesh)?.clone();
        sum.velocity.fill(Vector3::zeros());
        sum.pressure.fill(0.0);
        for (flow, &c) in flows.iter().zip(coefficients) {
            let velocities = sum.velocity.iter_mut().zip(&flow.velocity);
            velocities.for_each(|(sum, u)| *sum += c * u);
            let pressures = sum.pressure.iter_mut().zip(&flow.pressure);
            pressures.for_each(|(sum, p)| *sum += c * p);
        }
        sum.move_by(motion)?;
        for (velocity, x) in sum.velocity.iter_mut().zip(sum.mesh.points()) {
            *velocity += background.velocity(x);
        }
        Ok(sum)
    }
}

impl Hydrodynamics for Superposed {
    fn scene(&self) -> &Scene {
        self.model.scene()
    }

    fn name(&self) -> &'static str {
        self.model.name()
    }

    fn inner(&self) -> Option<&dyn Hydrodynamics> {
        Some(self.model.as_ref())
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Hydrodynamics> {
        Some(self.model.as_mut())
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        let mut solutions = Vec::with_capacity(query.rates.len());
        for rates in query.rates {
            match self.superpose(query, rates)? {
                Some(solution) => solutions.push(solution),
                None => return self.model.solve(query),
            }
        }
        Ok(solutions)
    }

    fn capabilities(&self) -> Capabilities {
        let own = self.model.capabilities();
        let error_estimates = match (&self.basis, own.error_estimates) {
            (Basis::Impossible, given) | (_, given @ ErrorEstimates::Never) => given,
            _ => ErrorEstimates::Always,
        };
        Capabilities {
            error_estimates,
            solves_together: false,
            ..own
        }
    }
}
