//! Time stepping for bodies with mass and moment of inertia.
//!
//! The joints leave the motions `U = S v + W` free. Their equation of motion is
//! `S^T (M dU/dt + R U) = S^T F` with the grand resistance matrix `R`; the fluid itself has no
//! inertia. Velocities relax within a time of order `m/R`, which for small bodies is much shorter
//! than a stroke. Explicit steps must be shorter than twice the relaxation time; implicit steps are
//! stable for any length.

use models::{BodySolution, InstantaneousSolution, ModelError};
use nalgebra::{DMatrix, DVector};
use rigid::{Drive, Reduction, State};
use scene::{Scene, SceneError};

use super::masses::{
    Velocities, at_rest, implicit_terms, mass_matrices, momenta, numbers_of, velocities_of,
};
use super::piece::PathPiece;
use super::result::{Approximation, SpanResult, Stopped};
use super::span_evaluator::{SpanEvaluator, SpanSolution};
use crate::error::SwimError;

/// The velocity at which the resistance of the fluid is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scheme {
    /// The velocity before the step.
    Explicit,
    /// The velocity after the step, for the shape after the step at the frames before it.
    Implicit,
}

/// Integrates a phase span in equal steps.
///
/// `velocities` are those of the bodies at the start on entry and at the end on return; none for
/// bodies at rest.
pub(super) fn span(
    evaluator: &mut SpanEvaluator,
    start: &State,
    steps: usize,
    scheme: Scheme,
    velocities: &mut Option<Velocities>,
) -> Result<SpanResult, Stopped> {
    let mut before = velocities
        .take()
        .unwrap_or_else(|| at_rest(evaluator.scene));
    let mut result = SpanResult::empty(start).with_velocities(&before);
    let dt = evaluator.span.duration / steps as f64;
    for k in 0..steps {
        let span = (k as f64 / steps as f64, (k + 1) as f64 / steps as f64);
        let solution = match scheme {
            Scheme::Explicit => explicit_step(evaluator, &result.end, span.0, dt, &before),
            Scheme::Implicit => implicit_step(evaluator, &result.end, span.1, dt, &before),
        };
        let solution = match solution {
            Err(error) => return Err(result.stopped(evaluator, error)),
            Ok(solution) => solution,
        };
        let rate = &solution.solution.motion * dt;
        let set = evaluator.scene.articulation();
        let piece = PathPiece::new(set, &result.end, span, vec![rate])?;
        if let Err(error) = evaluator.check_path(&piece) {
            return Err(result.stopped(evaluator, error));
        }
        before = velocities_of(&solution);
        let approximation = Approximation::new(piece, vec![solution], vec![1.0]);
        result.append(evaluator, approximation, None, None)?;
        result.velocities = numbers_of(&before);
    }
    *velocities = Some(before);
    Ok(result.with_totals(evaluator))
}

/// Backward Euler: the stage of Radau IIA of order 1.
fn implicit_step(
    evaluator: &mut SpanEvaluator,
    state: &State,
    s: f64,
    dt: f64,
    before: &Velocities,
) -> Result<SpanSolution, SwimError> {
    let masses = mass_matrices(evaluator, s, state)?;
    let known = momenta(evaluator, s, state, before)?;
    let terms = implicit_terms(&masses, &known, dt);
    evaluator.solve(s, state, true, Some(&terms))
}

/// Explicit Euler: `S^T M (S v + W - U) = dt S^T (F - R U)` with the velocities `U` before the
/// step.
fn explicit_step(
    evaluator: &mut SpanEvaluator,
    state: &State,
    s: f64,
    dt: f64,
    before: &Velocities,
) -> Result<SpanSolution, SwimError> {
    check_support(evaluator.scene)?;
    let resistance = evaluator.resistance(s, state)?;
    let scene = evaluator.scene;
    let set = scene.articulation();
    let (shape, rates) = (evaluator.span.shape(s), evaluator.span.rates(s));
    let time = evaluator.span.time(s);
    let mut constraints = scene.constraints(state, &shape, &rates, time)?;
    let oscillating = scene.joint_forces(time).unwrap_or_default();
    (constraints.joint_forces.iter_mut().zip(oscillating)).for_each(|(sum, force)| *sum += force);
    let reduction = Reduction::new(set, &constraints)?;
    let loads = scene.loads(time, &set.place(state, &shape)?);
    let drive = Drive {
        set,
        constraints: &constraints,
        loads: &loads,
    };
    let surfaced: Vec<usize> = (0..scene.bodies().len())
        .filter(|&body| scene.bodies()[body].bounding_radius() > 0.0)
        .collect();
    let masses = mass_matrices(evaluator, s, state)?;
    let mut mass = DMatrix::zeros(6 * surfaced.len(), 6 * surfaced.len());
    let mut velocities = DVector::zeros(6 * surfaced.len());
    for (number, &body) in surfaced.iter().enumerate() {
        let first = 6 * number;
        (mass.fixed_view_mut::<6, 6>(first, first)).copy_from(&masses[body]);
        (velocities.fixed_rows_mut::<6>(first)).copy_from(&before[body]);
    }
    let (basis, offset) = (&reduction.surface_basis, &reduction.surface_offset);
    check_stability(evaluator, &resistance, &mass, basis, dt)?;
    let inertia = mass / dt;
    let external = reduction.all.basis.tr_mul(&drive.generalised_loads()?);
    let rhs = &inertia * (&velocities - offset) - &resistance * &velocities;
    let reduced = basis.tr_mul(&(&inertia * basis));
    let free_velocities = reduced
        .clone()
        .cholesky()
        .ok_or_else(|| {
            let remedy = "check bodies[].mass, the step size and the gaps between bodies";
            ModelError::not_positive_definite("mass over time step", &reduced, remedy)
        })?
        .solve(&(external + basis.tr_mul(&rhs)));
    let generalised = reduction.velocities(&free_velocities)?;
    let after = generalised.select_rows(&set.surface_velocities());
    let forces = &resistance * &after;
    // The joints also transmit the forces that accelerate the bodies.
    let joint_loads =
        drive.joint_loads(&(&forces + &inertia * (&after - &velocities)), &generalised)?;
    let motion = set.state_velocity(generalised.as_slice())?;
    let layout = set.velocity_layout();
    let vector = |list: &DVector<f64>, first: usize| list.fixed_rows::<3>(first).into_owned();
    let body_solution = |body: usize| BodySolution {
        velocity: vector(&generalised, layout.bodies()[body]),
        angular_velocity: motion.spins[body],
        ..BodySolution::default()
    };
    let mut bodies: Vec<BodySolution> = (0..scene.bodies().len()).map(body_solution).collect();
    for (number, &body) in surfaced.iter().enumerate() {
        bodies[body].force = vector(&forces, 6 * number);
        bodies[body].torque = vector(&forces, 6 * number + 3);
    }
    let solution = InstantaneousSolution::new(bodies, joint_loads, motion);
    evaluator.record(s, state, solution)
}

/// Refuses what explicit steps cannot integrate: bodies without mass, which follow the flow at
/// once, and flows that the resistance of the bodies does not contain.
fn check_support(scene: &Scene) -> Result<(), SwimError> {
    if scene.has_surface_velocity() {
        return Err(SwimError::Model(ModelError::Unsupported {
            what: "explicit integration with inertia of slip or background flow".to_owned(),
            instead: "use an implicit method".to_owned(),
        }));
    }
    for (number, body) in scene.bodies().iter().enumerate() {
        if body.bounding_radius() == 0.0 {
            continue;
        }
        let (mass, inertia) = body.mass_matrix().unwrap_or_default();
        for (name, value) in [("mass", mass), ("inertia", inertia.trace())] {
            if value <= 0.0 {
                let key = format!("bodies[{number}].{name}");
                return Err(SwimError::Scene(SceneError::BadValue {
                    place: scene.place(&key),
                    key,
                    problem: "is zero, but explicit integration with inertia needs a positive \
                              value for every body; set it, or use an implicit method"
                        .to_owned(),
                }));
            }
        }
    }
    Ok(())
}

/// Refuses an explicit step longer than twice the shortest relaxation time.
///
/// The limit is `2 / lambda` with the largest eigenvalue of `S^T R S x = lambda S^T M S x`.
fn check_stability(
    evaluator: &SpanEvaluator,
    resistance: &DMatrix<f64>,
    mass: &DMatrix<f64>,
    basis: &DMatrix<f64>,
    dt: f64,
) -> Result<(), SwimError> {
    let limit = 2.0 * shortest_relaxation_time(resistance, mass, basis);
    if dt <= limit {
        return Ok(());
    }
    Err(SwimError::Unstable {
        phase: evaluator.span.number + 1,
        joint: evaluator.joint_name(),
        step: dt,
        limit,
        steps: (evaluator.span.duration / limit).ceil(),
    })
}

/// The shortest relaxation time of the motions that the joints leave free.
fn shortest_relaxation_time(
    resistance: &DMatrix<f64>,
    mass: &DMatrix<f64>,
    basis: &DMatrix<f64>,
) -> f64 {
    let reduced = basis.tr_mul(&(resistance * basis));
    let inertia = basis.tr_mul(&(mass * basis));
    let Some(factor) = inertia.cholesky() else {
        return 0.0;
    };
    // L^-1 (S^T R S) L^-T
    let half = factor
        .l()
        .solve_lower_triangular(&reduced)
        .map(|h| h.transpose());
    let Some(whole) = half.and_then(|h| factor.l().solve_lower_triangular(&h)) else {
        return 0.0;
    };
    let largest = whole.symmetric_eigenvalues().max();
    1.0 / largest
}
