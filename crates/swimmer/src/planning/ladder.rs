//! The choice of the least model without a mesh: every rung is tried on what is asked, and judged by a better one.

use std::time::Instant as Clock;

use nalgebra::DVector;

use crate::integrate::Method;
use crate::simulate::simulate;
use crate::start::solve_start;
use models::{ModelError, SphereModel, SpheresModel};
use scene::Scene;

/// The rung taken, and why, in three sentences.
pub(super) struct Rung {
    pub kind: SphereModel,
    pub reasons: Vec<String>,
}

/// Scenes of more spheres are judged by their velocity at the start: a stroke of many spheres costs what the choice should save.
const MOST_FOR_A_STROKE: usize = 6;

/// A rung errs by less than this part of the tolerance: the rest is for the integration, and for the judge's own error.
const SHARE: f64 = 0.5;

/// What a rung gave for the quantity that the tolerance is about.
struct Trial {
    value: DVector<f64>,
    /// What the value is relative to when it vanishes, as the displacement of a reciprocal stroke does.
    scale: f64,
    /// Seconds of one solve.
    seconds: f64,
}

/// Tries Oseen, Rotne-Prager-Yamakawa and expansions of rising accuracy until one errs by less than the tolerance allows.
///
/// The judge is an expansion a thousand times as accurate as the tolerance asks. The quantity is the net displacement of one
/// cycle, or the velocities of one instant where there is no gait or there are many spheres.
///
/// # Errors
/// A scene that the judge cannot compute.
pub(super) fn climb(scene: &Scene) -> Result<Rung, ModelError> {
    let tolerance = scene.model().tolerance;
    let stroke = !scene.gait().phases.is_empty() && scene.bodies().len() <= MOST_FOR_A_STROKE;
    let judge_kind = SphereModel::Multipole((1e-3 * tolerance).clamp(1e-13, 1e-5));
    let symmetry = scene.arrangement().describe().to_owned();
    let Some(judge) = attempt(scene, judge_kind, stroke)? else {
        // a stroke that runs into something: the run itself says so, and where
        return Ok(Rung {
            kind: SphereModel::for_displacement(scene),
            reasons: vec![
                symmetry,
                "the gait cannot be tried to its end".to_owned(),
                "took multipole expansions".to_owned(),
            ],
        });
    };
    let candidates = [
        SphereModel::Oseen,
        SphereModel::Rpy,
        SphereModel::Multipole((10.0 * tolerance).min(0.1)),
        SphereModel::Multipole(tolerance.min(1e-2)),
        SphereModel::Multipole((0.1 * tolerance).min(1e-3)),
        SphereModel::Multipole((0.01 * tolerance).clamp(1e-12, 1e-5)),
    ];
    let mut tried = Vec::new();
    let mut taken = judge_kind;
    for kind in candidates {
        // a lesser model may fail where spheres are close, or not know the domain
        let Ok(Some(trial)) = attempt(scene, kind, stroke) else {
            tried.push(format!("{} fails", kind.describe()));
            continue;
        };
        let error = (&trial.value - &judge.value).norm() / judge.scale;
        tried.push(format!(
            "{} errs {error:.1e} at {:.0} µs a solve",
            kind.describe(),
            1e6 * trial.seconds
        ));
        if error <= SHARE * tolerance {
            taken = kind;
            break;
        }
    }
    let what = if stroke {
        "net displacement"
    } else {
        "velocity at the start"
    };
    Ok(Rung {
        kind: taken,
        reasons: vec![
            symmetry,
            format!("{what}: {}", tried.join(", ")),
            format!(
                "took {}, the least below half of model.tolerance = {tolerance:e}",
                taken.describe()
            ),
        ],
    })
}

/// The quantity by one rung; `None` when the gait cannot be followed to its end.
fn attempt(scene: &Scene, kind: SphereModel, stroke: bool) -> Result<Option<Trial>, ModelError> {
    let mut model = SpheresModel::new(scene, kind)?;
    let clock = Clock::now();
    if !stroke {
        let instant = match solve_start(scene, &mut model) {
            Ok(instant) => instant,
            Err(crate::SwimError::Model(error)) => return Err(error),
            Err(_) => return Ok(None),
        };
        let value = DVector::from_iterator(
            3 * instant.bodies.len(),
            instant
                .bodies
                .iter()
                .flat_map(|b| b.velocity.iter().copied().collect::<Vec<_>>()),
        );
        return Ok(Some(Trial {
            scale: if value.norm() > 0.0 {
                value.norm()
            } else {
                1.0
            },
            value,
            seconds: clock.elapsed().as_secs_f64(),
        }));
    }
    // the share of the integration is small, so that rungs differ by what they are
    let tolerance = (0.1 * scene.model().tolerance).clamp(1e-12, 1e-4);
    let once = scene
        .with_cycles(1)
        .and_then(|once| once.with_tolerance(tolerance));
    let Ok(once) = once else { return Ok(None) };
    let outcome = match simulate(&once, &mut model, Method::Collocation, &mut ()) {
        Ok(outcome) => outcome,
        Err(crate::SwimError::Model(error)) => return Err(error),
        Err(_) => return Ok(None),
    };
    let bodies = outcome.displacement.len().max(1) as f64;
    let net = outcome.displacement.iter().sum::<nalgebra::Vector3<f64>>() / bodies;
    let longest = outcome
        .legs
        .iter()
        .flat_map(|leg| leg.displacement.iter().map(|d| d.norm()))
        .fold(0.0, f64::max);
    let scale = if net.norm() > 1e-6 * longest {
        net.norm()
    } else {
        longest
    };
    Ok(Some(Trial {
        value: DVector::from_column_slice(net.as_slice()),
        scale: if scale > 0.0 { scale } else { 1.0 },
        seconds: clock.elapsed().as_secs_f64() / outcome.solves.max(1) as f64,
    }))
}
