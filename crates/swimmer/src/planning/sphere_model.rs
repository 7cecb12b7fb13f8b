//! The choice of the cheapest mesh-free model: candidates are compared with a reference expansion.

use std::time::Instant;

use models::{ModelError, SphereModel, SpheresModel};
use nalgebra::{DVector, Vector3};
use scene::Scene;

use crate::error::SwimError;
use crate::integrate::{Method, velocity_tolerance};
use crate::simulate::simulate;
use crate::start::solve_start;

/// The chosen model, with the reasons in three sentences.
pub(super) struct SphereModelChoice {
    pub kind: SphereModel,
    pub reasons: Vec<String>,
}

/// Largest number of bodies for which candidates are compared by a whole stroke; with more bodies
/// they are compared by the initial velocity, because a stroke would cost what the choice saves.
const MAX_BODIES_FOR_STROKE: usize = 6;

/// Largest error of the chosen model as a fraction of the tolerance; the rest is for the
/// integration and for the error of the reference.
const TOLERANCE_SHARE: f64 = 0.5;

/// The quantity to which the tolerance refers, computed with one model.
struct Evaluation {
    value: DVector<f64>,
    /// Error bar of the value by the model.
    error_bar: f64,
    /// Scale of the relative error, also where the value vanishes, as the net displacement of a
    /// reciprocal stroke does.
    scale: f64,
    /// Seconds per solve.
    seconds: f64,
}

/// Multipole expansions with an error that is small compared with the tolerance of the scene.
pub(super) fn expansion_for_tolerance(scene: &Scene) -> SphereModel {
    // Below 1e-13 rounding errors dominate.
    SphereModel::Multipole(velocity_tolerance(scene).clamp(1e-13, 1e-3))
}

/// Chooses the first of the models Oseen, Rotne-Prager-Yamakawa and multipole expansions of
/// increasing accuracy whose error and error bar are below the tolerance.
///
/// The reference is an expansion a thousand times as accurate as the tolerance. The quantity is the
/// net displacement of one cycle, or the initial velocities for scenes without a gait or with many
/// spheres.
///
/// # Errors
/// A scene for which the reference fails.
pub(super) fn choose_sphere_model(scene: &Scene) -> Result<SphereModelChoice, ModelError> {
    let tolerance = scene.working_tolerance();
    let stroke = !scene.gait().phases.is_empty() && scene.bodies().len() <= MAX_BODIES_FOR_STROKE;
    let reference_kind = SphereModel::Multipole((1e-3 * tolerance).clamp(1e-13, 1e-5));
    let symmetry = scene.describe_arrangement();
    let Some(reference) = evaluate(scene, reference_kind, stroke)? else {
        // A stroke with a collision, for example: the run itself reports it with its place.
        return Ok(SphereModelChoice {
            kind: expansion_for_tolerance(scene),
            reasons: vec![
                symmetry,
                "the trial of the gait failed before its end".to_owned(),
                "chosen: multipole expansions".to_owned(),
            ],
        });
    };
    // Models of point forces know rigid spheres in fluid at rest alone.
    let mut candidates = match scene.has_surface_velocity() {
        true => Vec::new(),
        false => vec![SphereModel::Oseen, SphereModel::Rpy],
    };
    if !stroke {
        candidates
            .extend([(10.0 * tolerance).min(0.1), tolerance.min(1e-2)].map(SphereModel::Multipole));
    }
    // Along a stroke an expansion of lower accuracy would save little: its order changes with the
    // shape, and the integration would resolve the jumps.
    candidates.push(expansion_for_tolerance(scene));
    let mut compared = Vec::new();
    let mut chosen = reference_kind;
    let allowed = TOLERANCE_SHARE * tolerance;
    for kind in candidates {
        // A less accurate model may fail for close spheres, or not support the domain.
        let Ok(Some(evaluation)) = evaluate(scene, kind, stroke) else {
            compared.push(format!("{}: failed", kind.describe()));
            continue;
        };
        let error = (&evaluation.value - &reference.value).norm() / reference.scale;
        compared.push(format!(
            "{}: {error:.1e} at {:.0} µs per solve",
            kind.describe(),
            1e6 * evaluation.seconds
        ));
        if error.max(evaluation.error_bar / reference.scale) <= allowed {
            chosen = kind;
            break;
        }
    }
    let quantity = if stroke {
        "net displacement"
    } else {
        "initial velocities"
    };
    Ok(SphereModelChoice {
        kind: chosen,
        reasons: vec![
            symmetry,
            format!(
                "relative error of the {quantity} by {}",
                compared.join("; ")
            ),
            format!(
                "chosen: {}, the cheapest with an error bar below half of model.tolerance = {tolerance:e}",
                chosen.describe()
            ),
        ],
    })
}

/// The quantity computed with one model; none if the gait cannot be followed to its end.
fn evaluate(
    scene: &Scene,
    kind: SphereModel,
    stroke: bool,
) -> Result<Option<Evaluation>, ModelError> {
    let mut model = SpheresModel::new(scene, kind)?;
    let started = Instant::now();
    if !stroke {
        let solution = match solve_start(scene, &mut model) {
            Ok(solution) => solution,
            Err(SwimError::Model(error)) => return Err(error),
            Err(_) => return Ok(None),
        };
        let value = DVector::from_iterator(
            3 * solution.bodies.len(),
            solution
                .bodies
                .iter()
                .flat_map(|b| b.velocity.iter().copied().collect::<Vec<_>>()),
        );
        return Ok(Some(Evaluation {
            scale: if value.norm() > 0.0 {
                value.norm()
            } else {
                1.0
            },
            value,
            error_bar: solution.error_estimate.total(),
            seconds: started.elapsed().as_secs_f64(),
        }));
    }
    // The integration error must be small compared with the differences between the models.
    let tolerance = (0.1 * scene.working_tolerance()).clamp(1e-12, 1e-4);
    let one_cycle = scene
        .with_cycles(1)
        .and_then(|one_cycle| one_cycle.with_tolerance(tolerance));
    let Ok(one_cycle) = one_cycle else {
        return Ok(None);
    };
    let outcome = match simulate(&one_cycle, &mut model, Method::Collocation, &mut ()) {
        Ok(outcome) => outcome,
        Err(SwimError::Model(error)) => return Err(error),
        Err(_) => return Ok(None),
    };
    let bodies = outcome.displacement.len().max(1) as f64;
    let net = outcome.displacement.iter().sum::<Vector3<f64>>() / bodies;
    let longest = outcome
        .spans
        .iter()
        .flat_map(|span| span.displacement.iter().map(|d| d.norm()))
        .fold(0.0, f64::max);
    let scale = if net.norm() > 1e-6 * longest {
        net.norm()
    } else {
        longest
    };
    Ok(Some(Evaluation {
        value: DVector::from_column_slice(net.as_slice()),
        error_bar: outcome.error_estimate.model.unwrap_or(0.0),
        scale: if scale > 0.0 { scale } else { 1.0 },
        seconds: started.elapsed().as_secs_f64() / outcome.solves.max(1) as f64,
    }))
}
