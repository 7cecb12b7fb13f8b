//! The choice of a model for spheres: the cheapest one that meets the tolerance.
//!
//! Costs are predicted by counting operations, not measured, so that a resumed run and another
//! machine choose the same model.

use models::{
    AxisymmetricModel, Configuration, FemModel, Hydrodynamics, ModelError, SphereModel,
    SpheresModel,
};
use scene::{DomainKind, GeometryKind, Scene};

use super::target::LARGEST_CURVED_BAR;
use super::trial::{self, Evaluation, MAX_TRIAL_PHASES};
use crate::integrate::{TYPICAL_SOLVES_PER_SPAN, velocity_tolerance};
use crate::observer::Progress;

/// A kind of model for a scene of spheres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ModelForSpheres {
    /// Without a mesh.
    MeshFree(SphereModel),
    /// Finite elements in the meridian plane.
    MeridianPlane,
    /// Finite elements in three dimensions.
    Elements,
}

/// The chosen model, with the reasons in sentences.
pub(super) struct SphereModelChoice {
    pub model: ModelForSpheres,
    pub reasons: Vec<String>,
}

/// Largest number of bodies for which candidates are compared by a whole stroke; with more bodies
/// they are compared by the initial velocity, because a stroke would cost what the choice saves.
const MAX_BODIES_FOR_STROKE: usize = 6;

/// Largest error of the chosen model as a fraction of the tolerance; the rest is for the
/// integration and for the error of the reference.
const TOLERANCE_SHARE: f64 = 0.5;

/// Predicted seconds of all trials: half of the two seconds that the choice may take.
const TRIAL_SECONDS: f64 = 1.0;

/// Seconds of a solve below which the cost of a candidate does not matter.
const NEGLIGIBLE_SECONDS: f64 = 1e-3;

/// Predicted seconds of a run by expansions beyond which elements are considered. To know their
/// cost takes a mesh, a few seconds.
const LONG_RUN_SECONDS: f64 = 30.0;

/// Time of a run by elements over that of its linear systems.
///
/// Error estimates and new meshes take the rest: nine seconds of processor time where the systems
/// of a stroke near the wall of a ball take 1.8.
const ELEMENTS_OVERHEAD: f64 = 5.0;

/// Multipole expansions with an error that is small compared with the tolerance of the scene.
pub(super) fn expansion_for_tolerance(scene: &Scene) -> SphereModel {
    // Below 1e-13 rounding errors dominate.
    SphereModel::Multipole(velocity_tolerance(scene).clamp(1e-13, 1e-3))
}

/// The model of spheres for thermal noise, with the reason: expansions where a solution takes at
/// most [`NOISE_SECONDS`], as a run has thousands, and for surface velocities that they alone have;
/// else Rotne-Prager-Yamakawa, whose mobility is positive definite at all distances.
///
/// # Errors
/// Spheres that are too close.
pub(super) fn model_for_noise(scene: &Scene) -> Result<(SphereModel, String), ModelError> {
    let kind = expansion_for_tolerance(scene);
    let state = scene.initial_state();
    let seconds = SpheresModel::new(scene, kind)?.predicted_seconds(start(scene, &state))?;
    let has_walls = matches!(scene.domain().kind(), DomainKind::Ball | DomainKind::Wall);
    let needs_expansions = scene.background().is_some()
        || scene.deforms()
        || (scene.has_surface_velocity() && has_walls);
    let kind = match needs_expansions || seconds <= NOISE_SECONDS {
        true => kind,
        false => SphereModel::Rpy,
    };
    let reason = format!(
        "chosen for thermal noise: {}; a solution by expansions takes {seconds:.1e} s, as predicted",
        kind.describe()
    );
    Ok((kind, reason))
}

/// Predicted seconds of a solution by expansions with which steps of thermal noise are affordable.
const NOISE_SECONDS: f64 = 1e-2;

/// The model of spheres in a periodic box, with the reason: expansions where a run by them takes at
/// most [`LONG_RUN_SECONDS`], with thermal noise a solution at most [`NOISE_SECONDS`]; else
/// Rotne-Prager-Yamakawa, at the cost of Oseen with a smaller error.
pub(super) fn model_in_box(scene: &Scene) -> (SphereModel, String) {
    let kind = expansion_for_tolerance(scene);
    let state = scene.initial_state();
    let seconds = SpheresModel::new(scene, kind)
        .and_then(|model| model.predicted_seconds(start(scene, &state)));
    let most = match scene.noise() {
        Some(_) => NOISE_SECONDS,
        None => LONG_RUN_SECONDS / typical_solves(scene) as f64,
    };
    let (kind, why) = match seconds {
        Ok(seconds) => (
            if seconds <= most {
                kind
            } else {
                SphereModel::Rpy
            },
            format!("a solution by expansions takes {seconds:.1e} s, as predicted"),
        ),
        // Gaps too narrow for expansions, for example.
        Err(error) => (SphereModel::Rpy, error.to_string()),
    };
    (kind, format!("chosen: {}; {why}", kind.describe()))
}

/// A candidate with its predicted seconds per solve, the mean over the shapes of the trial.
#[derive(Clone, Copy)]
struct Candidate {
    kind: SphereModel,
    seconds: f64,
}

/// What the trials of candidates found.
struct Comparison {
    /// The candidate with the lowest cost that met the tolerance, or else the one with the smallest
    /// error; whether it met the tolerance is known from a trial, or not.
    chosen: Candidate,
    met: Option<bool>,
    /// Largest of the error and the error bar, relative, if there was a trial.
    error: f64,
    /// Whether the error is that of the net displacement of a stroke.
    of_stroke: bool,
    /// What was compared, in words.
    words: String,
}

/// How candidates are tried.
enum Trial {
    /// By the net displacement of a stroke.
    Stroke(Box<Scene>),
    /// By the velocities at the start.
    Start,
    /// By the error bars of expansions at the start.
    Bars,
}

/// Words for a gait with a collision, which the run reports with its place.
const FAILED_TRIAL: &str = "the trial of the gait failed before its end";

/// Chooses the model with the lowest predicted cost among those whose error and error bar are below
/// half the tolerance: Oseen, Rotne-Prager-Yamakawa, multipole expansions of increasing accuracy;
/// where none of them is, the meridian plane or elements; where expansions take long, elements.
///
/// The reference is an expansion a thousand times as accurate as the tolerance. The quantity is the
/// net displacement of one cycle, through at most [`MAX_TRIAL_PHASES`] shapes, or the initial
/// velocities for scenes without a gait or with many spheres. With slip or a background flow, or
/// where a stroke would take too long, expansions are judged by their own error bars at the start.
/// Where velocities are given, the forces that hold the bodies are compared too; only models that
/// are rougher than the tolerance asks for are refused by them.
///
/// # Errors
/// A scene for which the reference fails.
pub(super) fn choose_for_spheres(
    scene: &Scene,
    progress: &mut dyn Progress,
) -> Result<SphereModelChoice, ModelError> {
    let tolerance = scene.working_tolerance();
    let compared = match compare(scene, TOLERANCE_SHARE * tolerance, progress) {
        Ok(compared) => compared,
        // Gaps too narrow for expansions, for example.
        Err(error) if AxisymmetricModel::supports(scene) => {
            return Ok(in_meridian_plane(scene, error.to_string()));
        }
        Err(error) => return Err(error),
    };
    let Comparison { chosen, met, .. } = &compared;
    let symmetry = scene.describe_arrangement();
    let words = compared.words.clone();
    if *met == Some(false) {
        return beyond_expansions(scene, &compared, progress);
    }
    if chosen.seconds > TRIAL_SECONDS && AxisymmetricModel::supports(scene) {
        // Tenths of a second.
        return Ok(in_meridian_plane(scene, words));
    }
    let run = chosen.seconds * typical_solves(scene) as f64;
    if let Some(elements) = faster_elements(scene, run, progress) {
        return Ok(SphereModelChoice {
            model: ModelForSpheres::Elements,
            reasons: vec![
                symmetry,
                format!(
                    "{words}; predicted seconds of the run: {run:.0} by {}, {elements:.0} by \
                     elements",
                    chosen.kind.describe()
                ),
                "chosen: finite elements in three dimensions, the cheapest model".to_owned(),
            ],
        });
    }
    let why = match met {
        Some(_) => format!(
            ", the cheapest with an error bar below half of model.tolerance = {tolerance:e}"
        ),
        None => String::new(),
    };
    Ok(SphereModelChoice {
        model: ModelForSpheres::MeshFree(chosen.kind),
        reasons: vec![
            symmetry,
            words,
            format!("chosen: {}{why}", chosen.kind.describe()),
        ],
    })
}

/// The choice of the meridian plane, with the reason why expansions do not serve.
fn in_meridian_plane(scene: &Scene, why: String) -> SphereModelChoice {
    SphereModelChoice {
        model: ModelForSpheres::MeridianPlane,
        reasons: vec![
            scene.describe_arrangement(),
            why,
            "chosen: finite elements in the meridian plane".to_owned(),
        ],
    }
}

/// The choice where no expansion meets the tolerance: the meridian plane; elements, if their usual
/// error is smaller; or else the best expansion.
fn beyond_expansions(
    scene: &Scene,
    compared: &Comparison,
    progress: &mut dyn Progress,
) -> Result<SphereModelChoice, ModelError> {
    let allowed = TOLERANCE_SHARE * scene.working_tolerance();
    let why = format!("{}; {allowed:.1e} is allowed", compared.words);
    // On an axis without slip, expansions resolve all gaps along a stroke to rounding.
    if AxisymmetricModel::supports(scene) && !compared.of_stroke {
        progress.works(
            "choosing the model: velocities in the meridian plane",
            0.0,
            0.0,
        );
        let mut plane =
            AxisymmetricModel::new(scene)?.with_velocity_accuracy(velocity_tolerance(scene));
        // A gap that is too narrow for its triangles too leaves the best expansion.
        if let Ok(Some(found)) = trial::at_start(scene, &mut plane)
            && found.error_bar < compared.error
        {
            let why = format!("{why}; in the meridian plane {:.1e}", found.error_bar);
            return Ok(in_meridian_plane(scene, why));
        }
    } else if compared.error > LARGEST_CURVED_BAR.max(allowed) && can_use_elements(scene) {
        return Ok(SphereModelChoice {
            model: ModelForSpheres::Elements,
            reasons: vec![
                scene.describe_arrangement(),
                format!("{why}; elements usually have at most {LARGEST_CURVED_BAR:.0e}"),
                "chosen: finite elements in three dimensions".to_owned(),
            ],
        });
    }
    let kind = compared.chosen.kind;
    Ok(SphereModelChoice {
        model: ModelForSpheres::MeshFree(kind),
        reasons: vec![
            scene.describe_arrangement(),
            why,
            format!(
                "chosen: {}, which has the smallest error; no model meets half of model.tolerance \
                 = {:e}",
                kind.describe(),
                scene.working_tolerance()
            ),
        ],
    })
}

/// Whether elements support the scene: masses in unbounded fluid they do not.
fn can_use_elements(scene: &Scene) -> bool {
    let can_move = !scene.has_masses() || scene.domain().kind() == DomainKind::Ball;
    can_move && FemModel::new(scene).is_ok()
}

/// Predicted seconds of a run by elements, if they are fewer than those by expansions and the
/// elements meet the tolerance.
///
/// Only in balls, whose walls elements have: they represent unbounded fluid by a large ball.
fn faster_elements(scene: &Scene, by_expansions: f64, progress: &mut dyn Progress) -> Option<f64> {
    let is_accurate = scene.working_tolerance() >= LARGEST_CURVED_BAR
        && scene.fem().geometry == GeometryKind::Curved;
    let is_long = by_expansions > LONG_RUN_SECONDS;
    let is_ball = scene.domain().kind() == DomainKind::Ball;
    if !(is_long && is_accurate && is_ball) {
        return None;
    }
    // Elements that cannot be used, in a gap for example, are no faster.
    let mut elements = FemModel::new(scene).ok()?;
    progress.works(
        "choosing the model: a mesh for the cost of elements",
        0.0,
        0.0,
    );
    let per_solve = elements
        .cost(start(scene, &scene.initial_state()))
        .ok()?
        .seconds;
    let run = ELEMENTS_OVERHEAD * per_solve * typical_solves(scene) as f64;
    (run < by_expansions).then_some(run)
}

/// Solves of a run; one without a gait.
fn typical_solves(scene: &Scene) -> usize {
    let phases = TYPICAL_SOLVES_PER_SPAN * scene.gait().phases.len();
    phases.saturating_mul(scene.gait().cycles as usize).max(1)
}

fn start<'a>(scene: &'a Scene, state: &'a rigid::State) -> Configuration<'a> {
    Configuration::new(state, scene.articulation().initial_shape())
}

/// Tries the candidates, in the order of their predicted cost.
fn compare(
    scene: &Scene,
    allowed: f64,
    progress: &mut dyn Progress,
) -> Result<Comparison, ModelError> {
    let tolerance = scene.working_tolerance();
    let state = scene.initial_state();
    let has_surfaces = scene.has_surface_velocity() || scene.deforms();
    let has_stroke =
        !scene.gait().phases.is_empty() && scene.bodies().len() <= MAX_BODIES_FOR_STROKE;
    let stroke = (has_stroke && !has_surfaces)
        .then(|| trial::stroke(scene))
        .flatten();
    let shapes = stroke.as_ref().map(trial::shapes).unwrap_or_default();
    let candidate = |kind: SphereModel| -> Result<Candidate, ModelError> {
        let model = SpheresModel::new(scene, kind)?;
        let at = |shape: &[f64]| model.predicted_seconds(Configuration::new(&state, shape));
        let mut all = vec![at(scene.articulation().initial_shape())?];
        // The run reports shapes that are too narrow, with their place.
        all.extend(shapes.iter().filter_map(|shape| at(shape).ok()));
        Ok(Candidate {
            kind,
            seconds: all.iter().sum::<f64>() / all.len() as f64,
        })
    };
    let cost = |candidate: &Candidate| candidate.seconds.max(NEGLIGIBLE_SECONDS);
    let fine = candidate(expansion_for_tolerance(scene))?;
    let reference = candidate(SphereModel::Multipole(
        (1e-3 * tolerance).clamp(1e-13, 1e-5),
    ))?;
    let points = [SphereModel::Oseen, SphereModel::Rpy].map(candidate);
    // Models of point forces know rigid spheres in fluid at rest alone.
    let mut candidates = match has_surfaces {
        true => Vec::new(),
        false => points.into_iter().collect::<Result<Vec<_>, _>>()?,
    };
    if !has_stroke && !has_surfaces {
        let rougher = [(10.0 * tolerance).min(0.1), tolerance.min(1e-2)];
        for tolerance in rougher {
            candidates.push(candidate(SphereModel::Multipole(tolerance))?);
        }
    }
    // Along a stroke an expansion of lower accuracy would save little: its order changes with the
    // shape, and the integration would resolve the jumps.
    candidates.push(fine);
    // The simpler model is first among those with negligible costs.
    candidates.sort_by(|a, b| cost(a).total_cmp(&cost(b)));

    let per_point = candidates.iter().map(cost).sum::<f64>() + cost(&reference);
    let phases = scene.gait().phases.len().min(MAX_TRIAL_PHASES);
    let of_stroke = per_point * (TYPICAL_SOLVES_PER_SPAN * phases) as f64;
    let trial = match has_stroke && !has_surfaces {
        true if of_stroke <= TRIAL_SECONDS => match stroke {
            Some(stroke) => Trial::Stroke(Box::new(stroke)),
            None => return Ok(untried(fine, FAILED_TRIAL)),
        },
        false if per_point <= TRIAL_SECONDS && !has_surfaces => Trial::Start,
        _ => {
            candidates = vec![fine];
            Trial::Bars
        }
    };
    if matches!(trial, Trial::Bars) && fine.seconds > TRIAL_SECONDS {
        let words = format!(
            "not compared: a solution by {} takes {:.1} s, as predicted",
            fine.kind.describe(),
            fine.seconds
        );
        return Ok(untried(fine, &words));
    }
    let evaluate = |kind: SphereModel| match &trial {
        Trial::Stroke(stroke) => trial::follow(stroke, kind),
        Trial::Start | Trial::Bars => trial::at_start(scene, &mut SpheresModel::new(scene, kind)?),
    };
    let quantity = match (&trial, scene.has_held_bodies()) {
        (Trial::Stroke(_), false) => "net displacement",
        (Trial::Stroke(_), true) => "net displacement and mean loads",
        (Trial::Start, true) => "initial velocities and loads",
        _ => "initial velocities",
    };
    // All candidates at most: the first that meets the tolerance is the last.
    let mut costs = candidates.iter().map(cost).sum::<f64>();
    let mut done = 0.0;
    let mut begins = |candidate: &Candidate, costs: f64| {
        let kind = candidate.kind.describe();
        let work = format!("choosing the model: {quantity} by {kind}");
        progress.works(&work, done, done + costs);
        done += cost(candidate);
    };
    let standard = match trial {
        Trial::Bars => None,
        _ => {
            begins(&reference, cost(&reference) + costs);
            match evaluate(reference.kind)? {
                Some(standard) => Some(standard),
                // A stroke with a collision, for example: the run itself reports it with its place.
                None => return Ok(untried(fine, FAILED_TRIAL)),
            }
        }
    };
    let mut words = Vec::new();
    let mut best: Option<(Candidate, f64)> = None;
    let last = (fine.seconds + reference.seconds <= TRIAL_SECONDS).then_some(reference);
    for candidate in candidates.into_iter().chain(last) {
        let kind = candidate.kind.describe();
        // The reference is known.
        if standard.is_none() || candidate.kind != reference.kind {
            begins(&candidate, costs);
            costs -= cost(&candidate);
        }
        let is_rough = candidate.kind != fine.kind;
        // A less accurate model may fail for close spheres, or not support the domain.
        let Ok(Some(found)) = evaluate_once((candidate, is_rough), reference, &standard, &evaluate)
        else {
            words.push(format!("{kind}: failed"));
            continue;
        };
        words.push(format!("{kind}: {found:.1e}"));
        if best.is_none_or(|(_, error)| found < error) {
            best = Some((candidate, found));
        }
        if found <= allowed {
            best = Some((candidate, found));
            break;
        }
    }
    let Some((chosen, error)) = best else {
        return Ok(untried(fine, "all trials failed"));
    };
    Ok(Comparison {
        chosen,
        met: Some(error <= allowed),
        error,
        of_stroke: matches!(trial, Trial::Stroke(_)),
        words: format!("relative error of the {quantity} by {}", words.join("; ")),
    })
}

/// Largest of the error bar of a candidate and of its difference from the standard, relative; that
/// of the reference is known from the standard.
fn evaluate_once(
    (candidate, is_rough): (Candidate, bool),
    reference: Candidate,
    standard: &Option<Evaluation>,
    evaluate: &dyn Fn(SphereModel) -> Result<Option<Evaluation>, ModelError>,
) -> Result<Option<f64>, ModelError> {
    match standard {
        Some(standard) if candidate.kind == reference.kind => Ok(Some(standard.error_bar)),
        Some(standard) => Ok(evaluate(candidate.kind)?.map(|found| {
            let error = found.difference(standard).max(found.error_bar);
            // Prescribed velocities have no error, forces by rough models a large one; those of the
            // finest candidate are as good as they can be.
            match is_rough {
                true => error.max(found.error_of_loads(standard)),
                false => error,
            }
        })),
        None => Ok(evaluate(candidate.kind)?.map(|found| found.error_bar)),
    }
}

/// A choice without a comparison.
fn untried(chosen: Candidate, words: &str) -> Comparison {
    Comparison {
        chosen,
        met: None,
        error: f64::INFINITY,
        of_stroke: false,
        words: words.to_owned(),
    }
}
