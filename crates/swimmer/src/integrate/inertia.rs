//! Time stepping for bodies with mass and moment of inertia.
//!
//! The links leave the motions `U = S v + W` free. Their equation of motion is
//! `S^T (M dU/dt + R U) = S^T F` with the grand resistance matrix `R`; the fluid itself has no
//! inertia. Velocities relax within a time of order `m/R`, which for small bodies is much shorter
//! than a stroke. Explicit steps must be shorter than twice the relaxation time; implicit steps are
//! stable for any length.

use models::{BodySolution, InstantaneousSolution, ModelError};
use nalgebra::{DMatrix, DVector, Vector3};
use rigid::{Drive, ExternalLoad, Reduction, State};
use scene::{Scene, SceneError};

use super::leg_evaluator::LegEvaluator;
use super::leg_solution::LegSolution;
use super::piece::PathPiece;
use super::result::{Approximation, LegResult};
use crate::error::SwimError;

/// The velocity at which the resistance of the fluid is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scheme {
    /// The velocity before the step.
    Explicit,
    /// The velocity after the step, for the lengths after the step at the frames before it.
    Implicit,
}

/// Integrates a leg in equal steps.
///
/// `velocity` is `(U, omega)` of the bodies with surfaces, at the start on entry and at the end on
/// return; none for bodies at rest.
pub(super) fn leg(
    evaluator: &mut LegEvaluator,
    start: &State,
    steps: usize,
    scheme: Scheme,
    velocity: &mut Option<DVector<f64>>,
) -> Result<LegResult, SwimError> {
    let mut result = LegResult::empty(start);
    let mass = masses(evaluator.scene)?;
    let mut before = velocity
        .take()
        .unwrap_or_else(|| DVector::zeros(mass.len()));
    let dt = evaluator.leg.duration / steps as f64;
    for k in 0..steps {
        let span = (k as f64 / steps as f64, (k + 1) as f64 / steps as f64);
        let at = match scheme {
            Scheme::Explicit => span.0,
            Scheme::Implicit => span.1,
        };
        let (solution, after) = step(evaluator, &result.end, at, dt, scheme, &mass, &before)?;
        let rate = &solution.solution.motion * dt;
        let set = evaluator.scene.articulation();
        let approximation = Approximation {
            piece: PathPiece::new(set, &result.end, span, vec![rate])?,
            solutions: vec![solution],
            weights: vec![1.0],
        };
        result.append(evaluator, approximation, None, None)?;
        before = after;
    }
    *velocity = Some(before);
    Ok(result.with_totals(evaluator))
}

/// Diagonal of the mass matrix: per body with a surface, three times the mass and three times the
/// moment of inertia.
fn masses(scene: &Scene) -> Result<DVector<f64>, SwimError> {
    let mut diagonal = Vec::new();
    for (number, body) in scene.bodies().iter().enumerate() {
        if body.bounding_radius() == 0.0 {
            continue;
        }
        for (name, value) in [("mass", body.mass), ("inertia", body.inertia)] {
            if value <= 0.0 {
                let key = format!("bodies[{number}].{name}");
                return Err(SwimError::Scene(SceneError::BadValue {
                    place: scene.place(&key),
                    key,
                    problem:
                        "is zero, but integration with inertia needs a positive value for every \
                        body; set it, or integrate without inertia"
                            .to_owned(),
                }));
            }
            diagonal.extend([value; 3]);
        }
    }
    Ok(DVector::from_vec(diagonal))
}

/// One step: the solution and the velocities of the bodies at its end.
fn step(
    evaluator: &mut LegEvaluator,
    state: &State,
    s: f64,
    dt: f64,
    scheme: Scheme,
    mass: &DVector<f64>,
    before: &DVector<f64>,
) -> Result<(LegSolution, DVector<f64>), SwimError> {
    let resistance = evaluator.resistance(s, state)?;
    let scene = evaluator.scene;
    let set = scene.articulation();
    let constraints = set.constraints(state, &evaluator.leg.lengths(s), &evaluator.leg.rates(s))?;
    let reduction = Reduction::of(set, &constraints)?;
    let load = |body: &scene::Body| ExternalLoad {
        force: body.force,
        torque: body.torque,
    };
    let loads: Vec<ExternalLoad> = scene.bodies().iter().map(load).collect();
    let drive = Drive {
        set,
        constraints: &constraints,
        loads: &loads,
    };
    let (basis, offset) = (&reduction.surface_basis, &reduction.surface_offset);
    let inertia = DMatrix::from_diagonal(&(mass / dt));
    let external = reduction.all.basis.tr_mul(&drive.generalised_loads()?);
    let (matrix, rhs) = match scheme {
        Scheme::Explicit => {
            check_stability(evaluator, &resistance, mass, basis, dt)?;
            let rhs = &inertia * (before - offset) - &resistance * before;
            (inertia.clone(), rhs)
        }
        Scheme::Implicit => {
            let matrix = &inertia + &resistance;
            let rhs = &inertia * before - &matrix * offset;
            (matrix, rhs)
        }
    };
    let reduced = basis.tr_mul(&(&matrix * basis));
    let free_velocities = reduced
        .clone()
        .cholesky()
        .ok_or_else(|| {
            let remedy = "check bodies[].mass, the step size and the gaps between bodies";
            ModelError::not_positive_definite(
                "mass over time step plus resistance",
                &reduced,
                remedy,
            )
        })?
        .solve(&(external + basis.tr_mul(&rhs)));
    let generalised = reduction.velocities(&free_velocities)?;
    let after = generalised.select_rows(&set.surface_velocities());
    let forces = &resistance * &after;
    // The links also transmit the forces that accelerate the bodies.
    let link_loads = drive.link_loads(&(&forces + &inertia * (&after - before)), &generalised)?;
    let motion = set.state_velocity(generalised.as_slice())?;
    let layout = set.velocity_layout();
    let vector = |list: &DVector<f64>, first: usize| list.fixed_rows::<3>(first).into_owned();
    let mut surfaces = 0..;
    let bodies = (0..scene.bodies().len())
        .map(|body| {
            let mut entry = BodySolution {
                velocity: vector(&generalised, layout.bodies()[body]),
                angular_velocity: motion.spins[body],
                ..BodySolution::default()
            };
            if scene.bodies()[body].bounding_radius() > 0.0
                && let Some(number) = surfaces.next()
            {
                entry.force = vector(&forces, 6 * number);
                entry.torque = vector(&forces, 6 * number + 3);
            }
            entry
        })
        .collect();
    let rows = set.link_rows().into_iter();
    let link_forces = rows
        .map(|row| -> Vector3<f64> { vector(&link_loads, row) })
        .collect();
    let solution = InstantaneousSolution::new(bodies, link_forces, motion);
    Ok((evaluator.record(s, state, solution)?, after))
}

/// Refuses an explicit step longer than twice the shortest relaxation time.
///
/// The limit is `2 / lambda` with the largest eigenvalue of `S^T R S x = lambda S^T M S x`.
fn check_stability(
    evaluator: &LegEvaluator,
    resistance: &DMatrix<f64>,
    mass: &DVector<f64>,
    basis: &DMatrix<f64>,
    dt: f64,
) -> Result<(), SwimError> {
    let limit = 2.0 * shortest_relaxation_time(resistance, mass, basis);
    if dt <= limit {
        return Ok(());
    }
    Err(SwimError::Unstable {
        phase: evaluator.leg.number + 1,
        link: evaluator.link_name(),
        step: dt,
        limit,
        steps: (evaluator.leg.duration / limit).ceil(),
    })
}

/// The shortest relaxation time of the motions that the links leave free.
fn shortest_relaxation_time(
    resistance: &DMatrix<f64>,
    mass: &DVector<f64>,
    basis: &DMatrix<f64>,
) -> f64 {
    let reduced = basis.tr_mul(&(resistance * basis));
    let inertia = basis.tr_mul(&(DMatrix::from_diagonal(mass) * basis));
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
