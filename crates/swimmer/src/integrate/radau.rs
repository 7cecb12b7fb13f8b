//! Bodies with mass: the Radau IIA method with three stages, order 5.
//!
//! The equations of motion `dp/dt = F + C^T λ - R U` for the momenta `p = M U` of the bodies hold
//! with the constraints `C U = w` of the links: a differential-algebraic system of index 2, for
//! which the velocities of Radau IIA converge with order 5 (Hairer & Wanner 1996, VII.4). In the
//! limit of no mass it is the collocation of the massless motion. The stages
//!
//! ```text
//! p_i = p_0 + h sum_j a_ij f_j,   f = F + C^T λ - R U
//! ```
//!
//! are solved one after the other with the lower triangle L of the Crout factorisation `A = L U` in
//! place of A, until they converge (van der Houwen & de Swart 1997, SIAM J. Sci. Comput. 18): an
//! instantaneous solution with the resistance `M / (h l_ii)` in addition to that of the fluid, in
//! any model and formulation. The error decreases by a factor of 0.15 or better per iteration, for
//! any ratio of mass and resistance.

use models::BodyInertia;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Vector6};
use rigid::{ExternalLoad, Reduction, State, StateVelocity};
use scene::Scene;

use super::inverse_dexp::coordinate_rate;
use super::leg_evaluator::LegEvaluator;
use super::leg_solution::LegSolution;
use super::piece::{PathPiece, combination};
use super::radau_tableau::{STAGES, crout, tableau};
use super::result::{Approximation, IntegrationError, LegResult};
use super::step_size::{largest_displacement, step_tolerance};
use crate::error::SwimError;

/// Largest number of steps of a leg.
const MAX_STEPS: usize = 1 << 12;

/// Largest number of iterations of a step: 0.15^20 is rounding.
const MAX_ITERATIONS: usize = 20;

/// Part of the tolerance of a step to which its stages are iterated.
const ITERATION_SHARE: f64 = 0.01;

/// Least factor by which halving the steps reduces the error. Steps that are short compared with
/// all time scales have a factor of 32; where they are long, as for light bodies, it is at least
/// that of stage order 3.
const REDUCTION: f64 = 8.0;

/// Velocities `(U, ω)` of all bodies of the scene.
pub(super) type Velocities = Vec<Vector6<f64>>;

/// Integrates a leg: halves the steps until the change is below the tolerance.
///
/// `velocities` are those of the bodies at the start on entry and at the end on return; none for
/// bodies at rest. Where the rates of the links jump, the links transmit an impulse.
pub(super) fn leg(
    evaluator: &mut LegEvaluator,
    start: &State,
    velocities: &mut Option<Velocities>,
) -> Result<LegResult, SwimError> {
    let at_rest = || vec![Vector6::zeros(); evaluator.scene.bodies().len()];
    let before = velocities.take().unwrap_or_else(at_rest);
    let before = after_impulse(evaluator, start, &before)?;
    let mut coarser: Option<Run> = None;
    let mut steps = 1;
    loop {
        let run = run(evaluator, start, &before, steps)?;
        let tolerance = step_tolerance(evaluator, &run.whole(start), 1.0);
        let error = match &coarser {
            None => f64::INFINITY,
            Some(coarser) => run.difference(coarser, evaluator, start) / (REDUCTION - 1.0),
        };
        if error <= tolerance {
            let duration = evaluator.leg.duration;
            let work = |run: &Run| run.work(duration / run.steps.len() as f64);
            let work_change = coarser.as_ref().map_or(0.0, |c| work(c) - work(&run));
            *velocities = Some(run.velocities.clone());
            return run.into_result(
                evaluator,
                start,
                error,
                work_change.abs() / (REDUCTION - 1.0),
            );
        }
        if steps == MAX_STEPS {
            return Err(SwimError::NotIntegrated {
                phase: evaluator.leg.number + 1,
                link: evaluator.link_name(),
                error,
                tolerance,
                parts: MAX_STEPS,
            });
        }
        coarser = Some(run);
        steps *= 2;
    }
}

/// A leg in equal steps.
struct Run {
    steps: Vec<Approximation>,
    velocities: Velocities,
    /// Longest relaxation time of a body, for errors of the velocities.
    relaxation: f64,
}

impl Run {
    /// The sum of all steps.
    fn whole(&self, start: &State) -> StateVelocity {
        let steps: Vec<StateVelocity> = self.steps.iter().map(|step| step.piece.step()).collect();
        combination(steps.iter().map(|step| (step, 1.0)), start)
    }

    /// Difference of the displacements, and of those that follow from the final velocities.
    fn difference(&self, other: &Self, evaluator: &LegEvaluator, start: &State) -> f64 {
        let change = &self.whole(start) + &(&other.whole(start) * -1.0);
        let velocities = self.velocities.iter().zip(&other.velocities);
        let speed = velocities
            .map(|(a, b)| (a - b).fixed_rows::<3>(0).norm())
            .fold(0.0, f64::max);
        let time = self.relaxation.min(evaluator.leg.duration);
        largest_displacement(evaluator, &change).max(time * speed)
    }

    fn work(&self, duration: f64) -> f64 {
        self.steps.iter().map(|step| step.work(duration)).sum()
    }

    fn into_result(
        self,
        evaluator: &LegEvaluator,
        start: &State,
        error: f64,
        work_error: f64,
    ) -> Result<LegResult, SwimError> {
        let mut result = LegResult::empty(start);
        let count = self.steps.len() as f64;
        let duration = evaluator.leg.duration / count;
        for step in self.steps {
            let accumulated = step.accumulated_error(duration);
            let share = IntegrationError {
                displacement: error / count,
                work: work_error / count,
            };
            result.append(evaluator, step, Some(share), accumulated.as_ref())?;
        }
        result.velocities = self.velocities.iter().flatten().copied().collect();
        Ok(result.with_totals(evaluator))
    }
}

fn run(
    evaluator: &mut LegEvaluator,
    start: &State,
    before: &Velocities,
    steps: usize,
) -> Result<Run, SwimError> {
    let set = evaluator.scene.articulation();
    let mut run = Run {
        steps: Vec::with_capacity(steps),
        velocities: before.clone(),
        relaxation: relaxation_time(evaluator.scene),
    };
    let mut state = start.clone();
    for k in 0..steps {
        let span = (k as f64 / steps as f64, (k + 1) as f64 / steps as f64);
        let step = step(evaluator, &state, &mut run.velocities, span)?;
        state = step.piece.state(set, span.1)?;
        run.steps.push(step);
    }
    Ok(run)
}

/// Mass over Stokes drag: bodies of other shapes and among others relax faster than a sphere of
/// their smallest size alone.
pub(crate) fn relaxation_time(scene: &Scene) -> f64 {
    let times = scene.bodies().iter().filter_map(|body| {
        let (mass, _) = body.mass_matrix()?;
        let drag = 6.0 * std::f64::consts::PI * scene.viscosity() * body.bounding_radius();
        Some(mass / drag)
    });
    times.fold(0.0, f64::max)
}

/// One step from `state`; `velocities` are those before it on entry and after it on return.
fn step(
    evaluator: &mut LegEvaluator,
    state: &State,
    velocities: &mut Velocities,
    span: (f64, f64),
) -> Result<Approximation, SwimError> {
    let scene = evaluator.scene;
    let set = scene.articulation();
    let width = span.1 - span.0;
    let h = evaluator.leg.duration * width;
    let (nodes, a) = tableau();
    let l = crout(&a);
    let momentum_before = momenta(evaluator, span.0, state, velocities)?;
    let zero = vec![Vector6::zeros(); velocities.len()];
    let mut forces = [(); STAGES].map(|()| zero.clone());
    let at_rest = combination(std::iter::empty(), state);
    let mut rates = vec![at_rest; STAGES];
    let mut piece = PathPiece::through(set, state, span, &nodes, &rates)?;
    let mut stages: Vec<LegSolution> = Vec::new();
    for _ in 0..MAX_ITERATIONS {
        let old_forces = forces.clone();
        let old_rates = rates.clone();
        stages.clear();
        for i in 0..STAGES {
            let s = span.0 + nodes[i] * width;
            let at = piece.state(set, s)?;
            let masses = mass_matrices(evaluator, s, &at)?;
            let known = |body: usize| -> Vector6<f64> {
                let mut known = momentum_before[body];
                for j in 0..STAGES {
                    let new = if j < i { l[i][j] } else { 0.0 };
                    known += h * new * forces[j][body];
                    known += h * (a[i][j] - l[i][j]) * old_forces[j][body];
                }
                known
            };
            let known: Velocities = (0..masses.len()).map(known).collect();
            let scale = 1.0 / (h * l[i][i]);
            let inertia: Vec<BodyInertia> = (0..masses.len())
                .map(|body| {
                    let load = scale * known[body];
                    BodyInertia {
                        damping: scale * masses[body],
                        load: ExternalLoad {
                            force: load.fixed_rows::<3>(0).into(),
                            torque: load.fixed_rows::<3>(3).into(),
                        },
                    }
                })
                .collect();
            let solution = evaluator.solve_with_inertia(s, &at, &inertia)?;
            for (body, solved) in solution.solution.bodies.iter().enumerate() {
                let velocity = twist(&solved.velocity, &solved.angular_velocity);
                forces[i][body] = scale * (masses[body] * velocity - known[body]);
            }
            let sigma = piece.coordinates(nodes[i]);
            rates[i] = &coordinate_rate(set, &sigma, &solution.solution.motion) * h;
            stages.push(solution);
        }
        let change = rates
            .iter()
            .zip(&old_rates)
            .map(|(new, old)| largest_displacement(evaluator, &(new + &(old * -1.0))));
        piece = PathPiece::through(set, state, span, &nodes, &rates)?;
        let allowed = ITERATION_SHARE * step_tolerance(evaluator, &piece.step(), width);
        if change.fold(0.0, f64::max) <= allowed {
            break;
        }
    }
    if let Some(last) = stages.last() {
        let bodies = last.solution.bodies.iter();
        *velocities = bodies
            .map(|body| twist(&body.velocity, &body.angular_velocity))
            .collect();
    }
    Ok(Approximation {
        piece,
        solutions: stages,
        weights: a[STAGES - 1].to_vec(),
    })
}

fn twist(linear: &nalgebra::Vector3<f64>, angular: &nalgebra::Vector3<f64>) -> Vector6<f64> {
    let mut twist = Vector6::zeros();
    twist.fixed_rows_mut::<3>(0).copy_from(linear);
    twist.fixed_rows_mut::<3>(3).copy_from(angular);
    twist
}

/// Mass matrices of all bodies in the laboratory axes; zero for bodies without mass.
fn mass_matrices(
    evaluator: &LegEvaluator,
    s: f64,
    state: &State,
) -> Result<Vec<Matrix6<f64>>, SwimError> {
    let scene = evaluator.scene;
    let poses = scene
        .articulation()
        .place(state, &evaluator.leg.lengths(s))?;
    let matrix = |(body, pose): (&scene::Body, &nalgebra::Isometry3<f64>)| {
        let mut matrix = Matrix6::zeros();
        if let Some((mass, inertia)) = body.mass_matrix() {
            let rotation = pose.rotation.to_rotation_matrix();
            let inertia = rotation.matrix() * inertia * rotation.matrix().transpose();
            (matrix.fixed_view_mut::<3, 3>(0, 0)).copy_from(&(mass * Matrix3::identity()));
            matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia);
        }
        matrix
    };
    Ok(scene.bodies().iter().zip(&poses).map(matrix).collect())
}

fn momenta(
    evaluator: &LegEvaluator,
    s: f64,
    state: &State,
    velocities: &Velocities,
) -> Result<Velocities, SwimError> {
    let masses = mass_matrices(evaluator, s, state)?;
    Ok(masses.iter().zip(velocities).map(|(m, u)| m * u).collect())
}

/// The velocities after the impulse by which links enforce the rates at the start of the leg.
///
/// Of all velocities `S v + W` that the links allow, those are taken whose momenta differ from
/// those before by an impulse of the links alone: `S^T M (S v + W - U) = 0`.
fn after_impulse(
    evaluator: &LegEvaluator,
    state: &State,
    velocities: &Velocities,
) -> Result<Velocities, SwimError> {
    let set = evaluator.scene.articulation();
    let (lengths, rates) = (evaluator.leg.lengths(0.0), evaluator.leg.rates(0.0));
    let constraints = set.constraints(state, &lengths, &rates)?;
    let reduction = Reduction::of(set, &constraints)?;
    let masses = mass_matrices(evaluator, 0.0, state)?;
    let surfaced: Vec<usize> = (0..masses.len())
        .filter(|&body| evaluator.scene.bodies()[body].bounding_radius() > 0.0)
        .collect();
    let (basis, offset) = (&reduction.surface_basis, &reduction.surface_offset);
    let mut mass = DMatrix::zeros(basis.ncols(), basis.ncols());
    let mut rhs = DVector::zeros(basis.ncols());
    for (number, &body) in surfaced.iter().enumerate() {
        let rows = basis.fixed_rows::<6>(6 * number);
        mass += rows.transpose() * (masses[body] * rows);
        let difference = velocities[body] - offset.fixed_rows::<6>(6 * number);
        rhs += rows.transpose() * (masses[body] * difference);
    }
    // Motions without mass follow the flow at once, whatever they are here.
    let scale = mass.amax();
    let v = match mass.svd(true, true).solve(&rhs, 1e-12 * scale) {
        Ok(v) => v,
        Err(_) => DVector::zeros(basis.ncols()),
    };
    let after = basis * v + offset;
    let mut result = velocities.clone();
    for (number, &body) in surfaced.iter().enumerate() {
        result[body] = after.fixed_rows::<6>(6 * number).into();
    }
    Ok(result)
}
