//! First-order changes by neglected terms: by inertia from finite-element flows beside each other
//! on a path, by a viscosity law from one flow.

use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3, Vector6};
use rigid::{BodyKind, Constraints, ExternalLoad, FlowSolution, StateVelocity, Twist};
use scene::Domain;
use stokes::{ChangingFlow, InitialGuesses};

use super::far_field::total_force;
use super::meshes::Meshes;
use super::placed_query::PlacedQuery;
use super::{FemModel, MeshAt, NAME};
use crate::error::ModelError;
use crate::neglected_terms::{FirstOrderChange, NeglectedTerm, NeglectedTerms, PathPoint};
use crate::query::{Configuration, Query};
use crate::response::Response;
use crate::scaled_scene::ScaledResponse;

/// Distance in time over which flows are differenced, relative to that of the motion.
///
/// The truncation of the difference has a relative error of 1e-6, or of 1e-3 in a gap of a
/// thirtieth of a radius.
const RELATIVE_STEP: f64 = 1e-3;

/// Relative residual to which flows are solved that are differenced.
///
/// Velocities have up to ten times this error, and their difference is a thousandth of them.
const DIFFERENCE_RTOL: f64 = 1e-10;

/// Relative residual to which changes are solved: a tenth of a percent of an effect is more than
/// the elements resolve.
const CHANGE_RTOL: f64 = 1e-4;

/// Total force on the fluid that counts as none, relative to the largest force of a body or, in
/// scaled units, the largest speed: forces sum to zero up to the residual of the solve.
const FORCE_ROUNDING: f64 = 1e-5;

/// Mass of a body, and its moments of inertia in the axes of the scene at the start.
type Mass = (f64, Matrix3<f64>);

/// Flows at one time of a path, in scaled units.
struct Solved {
    query: PlacedQuery,
    /// One flow per set of rates.
    flows: Vec<FlowSolution>,
}

/// What is differenced in time: velocities and positions of the nodes, momenta of the bodies.
struct Moment {
    velocity: Vec<Vector3<f64>>,
    points: Vec<Vector3<f64>>,
    momenta: Vec<Vector6<f64>>,
}

/// What a change follows from, in scaled units and in the frame of the mesh.
struct Accelerations {
    velocity: Vec<Vector3<f64>>,
    derivative: Vec<Vector3<f64>>,
    mesh_velocity: Vec<Vector3<f64>>,
    /// Rate of change of the momentum and angular momentum of each body.
    momenta: Vec<Vector6<f64>>,
}

impl FemModel {
    /// Refuses scenes to which no first-order change by a term belongs.
    fn check_neglected(&self, term: NeglectedTerm) -> Result<(), ModelError> {
        let scene = &self.scaled.scene;
        let effect = format!("the effect of neglecting {}", term.name());
        self.scaled.check_constant_viscosity(&effect)?;
        let refused = |what: &str, instead: &str| {
            Err(ModelError::unsupported(format!("{effect} {what}"), instead))
        };
        if scene.background().is_some() {
            return refused("in a background flow", "let the fluid be at rest");
        }
        if scene.has_masses() {
            return refused(
                "with the inertia of bodies, which is not neglected",
                "give densities of bodies in place of their masses",
            );
        }
        if scene.deforms() && term == NeglectedTerm::Inertia {
            return refused(
                "with bodies that deform",
                "its size is unknown; the results are those without the term",
            );
        }
        if self.engine.is_some() {
            return refused("by an engine", "run it by `swim`");
        }
        Ok(())
    }

    /// Flows at one time of a path.
    fn solved(
        &mut self,
        configuration: Configuration,
        rates: &[Vec<f64>],
        mesh_at: MeshAt,
        guesses: &mut InitialGuesses,
    ) -> Result<Solved, ModelError> {
        let query = Query::new(configuration, rates).without_estimates();
        let query = self.place_by(&query, mesh_at)?;
        if query.has_other_cells() {
            // The next query of a run must not start from solutions on other cells.
            self.guesses.clear();
        }
        let options = self.solver_options().with_rtol(DIFFERENCE_RTOL);
        let (solutions, _) = self.flows(&query, &options, guesses)?;
        let flows = solutions.into_iter().map(|solved| solved.flow).collect();
        Ok(Solved { query, flows })
    }

    /// Refuses a total force on unbounded fluid, in which inertia has an effect of lower order.
    fn check_total_force(&self, solved: &Solved) -> Result<(), ModelError> {
        let is_unbounded = *self.scaled.scene.domain() == Domain::Unbounded;
        for flow in solved.flows.iter().filter(|_| is_unbounded) {
            let speed = flow.velocity.iter().map(Vector3::norm).fold(0.0, f64::max);
            if total_force(flow).norm() > FORCE_ROUNDING * flow.forces.amax().max(speed) {
                return Err(ModelError::unsupported(
                    "the effect of neglecting inertia on unbounded fluid with a total force",
                    "enclose the fluid: without walls the effect is of the order sqrt(S), of the \
                     frequency parameter S, and far away of that of Oseen",
                ));
            }
        }
        Ok(())
    }

    /// Scaled masses of all bodies; none for points.
    fn masses(&self) -> Result<Vec<Option<Mass>>, ModelError> {
        let (scene, scale) = (&self.scaled.scene, &self.scaled.scale);
        let mass = |body: &scene::Body| {
            if body.kind() != BodyKind::Rigid {
                return Ok(None);
            }
            let density = body.density.unwrap_or(0.0);
            let unsupported = || {
                let what = format!("the neglected inertia of the body '{}'", body.name);
                ModelError::unsupported(
                    what,
                    "use a shape with known moments of inertia, or set density = 0",
                )
            };
            let moments = match density > 0.0 {
                true => (body.shape.inertia_per_mass()).ok_or_else(unsupported)?,
                false => Matrix3::zeros(),
            };
            let mass = density * body.shape.volume();
            Ok(Some(scale.mass(mass, &(mass * moments))))
        };
        scene.bodies().iter().map(mass).collect()
    }

    /// Momentum and angular momentum of each body in a flow.
    fn momenta(
        &self,
        masses: &[Option<Mass>],
        poses: &[Isometry3<f64>],
        flow: &FlowSolution,
    ) -> Vec<Vector6<f64>> {
        let layout = self.scaled.set.velocity_layout();
        let momentum = |(body, (mass, pose)): (usize, (&Option<_>, &Isometry3<f64>))| {
            let (Some((mass, moments)), Some(first)) = (mass, layout.body(body)) else {
                return Vector6::zeros();
            };
            let vector = |row| flow.generalised.fixed_rows::<3>(row).into_owned();
            let rotation = pose.rotation.to_rotation_matrix();
            let spin: Vector3<f64> = vector(first + 3);
            let angular: Vector3<f64> = rotation * (moments * (rotation.inverse() * spin));
            joined(&(vector(first) * *mass), &angular)
        };
        (masses.iter().zip(poses).enumerate())
            .map(momentum)
            .collect()
    }

    /// What is differenced, of the first flow and in another frame.
    fn moment(
        &self,
        solved: &Solved,
        masses: &[Option<Mass>],
        to_frame: &Isometry3<f64>,
    ) -> Result<Moment, ModelError> {
        let (flow, query, rotation) = (solved.flow()?, &solved.query, to_frame.rotation);
        let points = query.placed.mesh.points().iter();
        let momenta = self.momenta(masses, &query.placement.poses, flow);
        let turned = |momentum: &Vector6<f64>| {
            let [linear, angular] = [0, 3].map(|row| rotation * momentum.fixed_rows::<3>(row));
            joined(&linear, &angular)
        };
        Ok(Moment {
            velocity: flow.velocity.iter().map(|u| rotation * u).collect(),
            points: points
                .map(|x| rotation * x + to_frame.translation.vector)
                .collect(),
            momenta: momenta.iter().map(turned).collect(),
        })
    }

    /// Time over which flows are differenced: a small part of the times in which bodies move by a
    /// radius, their velocities change, and loads oscillate.
    fn time_step(&self, flow: &FlowSolution, accelerations: &[f64]) -> f64 {
        let largest = |values: &[f64]| values.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let speed = flow.generalised.amax();
        let acceleration = largest(&self.scaled.values(accelerations));
        let period = (self.scaled.scene.shortest_period()).unwrap_or(f64::INFINITY);
        let time = (1.0 / speed)
            .min(1.0 / acceleration.sqrt())
            .min(period / std::f64::consts::TAU);
        // without any motion all differences are zero
        RELATIVE_STEP * if time.is_finite() { time } else { 1.0 }
    }

    /// Constraints of a query with all rates and forces on joints zero.
    fn at_rest(query: &PlacedQuery) -> Result<Constraints, ModelError> {
        // a query has rates
        let mut at_rest = query.constraints.first().ok_or(ModelError::NoMesh)?.clone();
        at_rest.rates.fill(0.0);
        at_rest.joint_forces.fill(0.0);
        Ok(at_rest)
    }

    /// A part of a change in the units of the scene and the laboratory frame.
    fn part_to_scene(
        &self,
        query: &PlacedQuery,
        flow: &FlowSolution,
    ) -> Result<Response, ModelError> {
        let scaled_response = ScaledResponse::of_flow(flow, 0.0, Vec::new(), &self.scaled.set)?;
        let mut response = self.scaled.change_to_scene(scaled_response);
        if let Some(frame) = &query.frame {
            response.rotate(&frame.rotation());
        }
        Ok(response)
    }

    /// The changes by accelerations of the flow of a query, in the units of the scene and the
    /// laboratory frame.
    fn change_by(
        &self,
        query: &PlacedQuery,
        accelerations: &Accelerations,
    ) -> Result<FirstOrderChange, ModelError> {
        let (scaled, mesh) = (&self.scaled, &query.placed.mesh);
        let surfaces = self.meshes.boundary_surfaces(&query.placement);
        let problem = query.with_space(self.problem(mesh, &query.placement, &surfaces)?);
        let at_rest = Self::at_rest(query)?;
        let load = |rate: &Vector6<f64>| ExternalLoad {
            force: -rate.fixed_rows::<3>(0).into_owned(),
            torque: -rate.fixed_rows::<3>(3).into_owned(),
        };
        let loads: Vec<_> = accelerations.momenta.iter().map(load).collect();
        let flow = ChangingFlow {
            velocity: &accelerations.velocity,
            derivative: &accelerations.derivative,
            mesh_velocity: &accelerations.mesh_velocity,
        };
        let density = scaled.scale.density(scaled.scene.fluid_density());
        let options = self.solver_options().with_rtol(CHANGE_RTOL);
        let drive = self.drive(&at_rest, &loads);
        let change = problem.inertial_change(&drive, &flow, density, &options)?;
        let part = |name, flow| Ok((name, self.part_to_scene(query, flow)?));
        let parts = [
            part("unsteady", &change.unsteady),
            part("convective", &change.convective),
            part("bodies", &change.bodies),
        ];
        let parts = parts.into_iter().collect::<Result<_, ModelError>>()?;
        Ok(FirstOrderChange { parts })
    }

    /// The change by inertia at a point of a path.
    fn inertial_change(&mut self, at: &PathPoint<'_>) -> Result<FirstOrderChange, ModelError> {
        let masses = self.masses()?;
        // two, so that the last solve starts from an extrapolation
        let mut guesses = InitialGuesses::new(2);
        let rates = [at.rates.to_vec()];
        let now = self.solved(at.configuration, &rates, Meshes::at, &mut guesses)?;
        self.check_total_force(&now)?;
        let (flow, frame) = (now.flow()?, now.query.frame);
        let mut motion = self.scaled.motion_to_scene(&flow.state);
        if let Some(frame) = &frame {
            motion = rotated(&frame.rotation(), &motion);
        }
        let step = self.time_step(flow, at.accelerations);
        let set = self.scaled.scene.articulation().clone();
        let mut beside = |time: f64| {
            let moved = |values: &[f64], rates: &[f64]| -> Vec<f64> {
                let pairs = values.iter().zip(rates);
                pairs.map(|(value, rate)| value + time * rate).collect()
            };
            let configuration = Configuration {
                state: &set.advance(at.configuration.state, &(&motion * time))?,
                shape: &moved(at.configuration.shape, at.rates),
                time: at.configuration.time + time,
            };
            let rates = [moved(at.rates, at.accelerations)];
            let mesh_at = Meshes::at_by_current;
            let solved = self.solved(configuration, &rates, mesh_at, &mut guesses)?;
            let frames = frame.zip(solved.query.frame);
            let to_frame = frames
                .map(|(now, then)| self.to_laboratory(now).inverse() * self.to_laboratory(then));
            self.moment(&solved, &masses, &to_frame.unwrap_or_default())
        };
        let (before, after) = (beside(-step)?, beside(step)?);
        let per_time = 1.0 / (2.0 * step);
        let accelerations = Accelerations {
            velocity: flow.velocity.clone(),
            derivative: difference(&before.velocity, &after.velocity, per_time),
            mesh_velocity: difference(&before.points, &after.points, per_time),
            momenta: difference(&before.momenta, &after.momenta, per_time),
        };
        self.change_by(&now.query, &accelerations)
    }

    /// The change by the viscosity law that the flow neglects.
    fn law_change(&mut self, at: &PathPoint<'_>) -> Result<FirstOrderChange, ModelError> {
        let law = self.scaled.neglected_law()?;
        let (rates, mut guesses) = ([at.rates.to_vec()], InitialGuesses::new(0));
        let now = self.solved(at.configuration, &rates, Meshes::at, &mut guesses)?;
        let query = &now.query;
        let surfaces = self.meshes.boundary_surfaces(&query.placement);
        let problem = self.problem(&query.placed.mesh, &query.placement, &surfaces)?;
        let problem = query.with_space(problem);
        let (at_rest, loads) = (
            Self::at_rest(query)?,
            vec![ExternalLoad::default(); query.placement.poses.len()],
        );
        let (drive, velocity) = (self.drive(&at_rest, &loads), &now.flow()?.velocity);
        let options = self.solver_options().with_rtol(CHANGE_RTOL);
        let change = problem.viscosity_change(&drive, velocity, &law, &options)?;
        let part = |flow: &FlowSolution| self.part_to_scene(query, flow);
        FirstOrderChange::by_law(&change.full, change.second_order.as_ref(), part)
    }
}

impl NeglectedTerms for FemModel {
    fn change(
        &mut self,
        term: NeglectedTerm,
        at: &PathPoint<'_>,
    ) -> Result<FirstOrderChange, ModelError> {
        self.check_neglected(term)?;
        match term {
            NeglectedTerm::Inertia => self.inertial_change(at),
            NeglectedTerm::Rheology => self.law_change(at),
        }
    }

    fn jump(
        &mut self,
        configuration: Configuration<'_>,
        before: &[f64],
        after: &[f64],
    ) -> Result<FirstOrderChange, ModelError> {
        self.check_neglected(NeglectedTerm::Inertia)?;
        let masses = self.masses()?;
        let rates = [before.to_vec(), after.to_vec()];
        let mut guesses = InitialGuesses::new(0);
        let solved = self.solved(configuration, &rates, Meshes::at, &mut guesses)?;
        self.check_total_force(&solved)?;
        let [before, after] = solved.flows.as_slice() else {
            return Err(ModelError::NoSolution { model: NAME });
        };
        let [of_before, of_after] =
            [before, after].map(|flow| self.momenta(&masses, &solved.query.placement.poses, flow));
        let at_rest = vec![Vector3::zeros(); after.velocity.len()];
        let accelerations = Accelerations {
            // a jump takes no time, in which nothing is convected
            velocity: at_rest.clone(),
            derivative: difference(&before.velocity, &after.velocity, 1.0),
            mesh_velocity: at_rest,
            momenta: difference(&of_before, &of_after, 1.0),
        };
        self.change_by(&solved.query, &accelerations)
    }
}

impl Solved {
    /// The flow of the first set of rates.
    fn flow(&self) -> Result<&FlowSolution, ModelError> {
        (self.flows.first()).ok_or(ModelError::NoSolution { model: NAME })
    }
}

/// `(after - before) factor`, vector by vector.
fn difference<const N: usize>(
    before: &[nalgebra::SVector<f64, N>],
    after: &[nalgebra::SVector<f64, N>],
    factor: f64,
) -> Vec<nalgebra::SVector<f64, N>> {
    let pairs = before.iter().zip(after);
    pairs.map(|(b, a)| (a - b) * factor).collect()
}

/// The two vectors one after the other.
fn joined(first: &Vector3<f64>, second: &Vector3<f64>) -> Vector6<f64> {
    Vector6::from_iterator(first.iter().chain(second).copied())
}

/// A rate of change of the state with all vectors rotated.
fn rotated(rotation: &UnitQuaternion<f64>, motion: &StateVelocity) -> StateVelocity {
    StateVelocity {
        frames: (motion.frames.iter())
            .map(|twist| Twist {
                linear: rotation * twist.linear,
                angular: rotation * twist.angular,
            })
            .collect(),
        spins: motion.spins.iter().map(|spin| rotation * spin).collect(),
        joints: motion.joints.clone(),
    }
}
