//! Time stepping for bodies with mass and moment of inertia.
//!
//! Newton's equations of the motions that links leave free, $U = S v + W$, are $S^T (M \dot U + R\, U) = S^T F$ with the grand resistance
//! `R`. The fluid itself has no inertia. Velocities relax within $m/R$, which for small bodies is far shorter than a stroke: explicit steps must
//! stay below twice that, implicit ones need not.

use nalgebra::{DMatrix, DVector, Vector3};
use rigid::{Drive, ExternalLoad, Reduction, State};

use super::leg_evaluator::LegEvaluator;
use super::leg_solution::LegSolution;
use super::piece::PathPiece;
use super::result::{LegResult, Rung};
use crate::SwimError;
use models::{BodySolution, InstantaneousSolution, ModelError};
use scene::{Scene, SceneError};

/// When the fluid's resistance is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scheme {
    /// At the velocity before the step.
    Explicit,
    /// At the velocity after the step; the bodies are where the frame was before it, with the lengths after it.
    Implicit,
}

/// Integrates a leg in equal steps.
///
/// `velocity` holds `(U, omega)` of the bodies with surfaces at the start and, when it is done, at the end; none at rest.
pub(super) fn leg(
    evaluator: &mut LegEvaluator,
    start: &State,
    steps: usize,
    scheme: Scheme,
    velocity: &mut Option<DVector<f64>>,
) -> Result<LegResult, SwimError> {
    let mut result = LegResult::at(start);
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
        let (solved, after) = step(evaluator, &result.end, at, dt, scheme, &mass, &before)?;
        let rate = &solved.solution.motion * dt;
        let set = evaluator.scene.articulation();
        let rung = Rung {
            piece: PathPiece::new(set, &result.end, span, vec![rate])?,
            solved: vec![solved],
            weights: vec![1.0],
        };
        result.append(evaluator, rung, None, None)?;
        before = after;
    }
    *velocity = Some(before);
    Ok(result.closed(evaluator))
}

/// Mass, three times, and moment of inertia, three times, of every body with a surface.
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
                    problem: "is zero, but time stepping with inertia needs one for every body; give it, or integrate without inertia".to_owned(),
                }));
            }
            diagonal.extend([value; 3]);
        }
    }
    Ok(DVector::from_vec(diagonal))
}

/// One step: the answer at its end and the bodies' velocities there.
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
    let constraints = set.constraints(state, &evaluator.leg.lengths(s), &evaluator.leg.rates())?;
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
    let (matrix, rest) = match scheme {
        Scheme::Explicit => {
            check_step(evaluator, &resistance, mass, basis, dt)?;
            let rest = &inertia * (before - offset) - &resistance * before;
            (inertia.clone(), rest)
        }
        Scheme::Implicit => {
            let matrix = &inertia + &resistance;
            let rest = &inertia * before - &matrix * offset;
            (matrix, rest)
        }
    };
    let reduced = basis.tr_mul(&(&matrix * basis));
    let unknowns = reduced
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
        .solve(&(external + basis.tr_mul(&rest)));
    let generalised = reduction.velocities(&unknowns);
    let after = generalised.select_rows(&set.surface_velocities());
    let forces = &resistance * &after;
    // Links carry what accelerates the bodies too.
    let carried = drive.link_loads(&(&forces + &inertia * (&after - before)))?;
    let motion = set.state_velocity(generalised.as_slice())?;
    let layout = set.velocity_layout();
    let vector = |list: &DVector<f64>, first: usize| list.fixed_rows::<3>(first).into_owned();
    let mut surfaces = 0..;
    let bodies = (0..scene.bodies().len())
        .map(|body| {
            let mut entry = BodySolution {
                velocity: vector(&generalised, layout.body(body)),
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
    let link_forces = (0..set.links().len())
        .map(|link| -> Vector3<f64> { vector(&carried, 3 * link) })
        .collect();
    let solution = InstantaneousSolution::new(bodies, link_forces, motion);
    Ok((evaluator.record(s, state, solution)?, after))
}

/// Refuses an explicit step beyond twice the shortest relaxation time: `2 / lambda` with the largest eigenvalue of
/// $S^T R S\, x = \lambda\, S^T M S\, x$.
fn check_step(
    evaluator: &LegEvaluator,
    resistance: &DMatrix<f64>,
    mass: &DVector<f64>,
    basis: &DMatrix<f64>,
    dt: f64,
) -> Result<(), SwimError> {
    let limit = 2.0 * shortest_relaxation(resistance, mass, basis);
    if dt <= limit {
        return Ok(());
    }
    Err(SwimError::Unstable {
        phase: evaluator.leg.number + 1,
        what: evaluator.what(),
        step: dt,
        limit,
        steps: (evaluator.leg.duration / limit).ceil(),
    })
}

/// The shortest time in which velocities of the free motions relax.
fn shortest_relaxation(
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
