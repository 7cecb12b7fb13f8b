//! The best stroke of a scene: table, search, and a run of the winner by the full model.

use std::path::Path;

use models::{ShapeGeometry, TablePart};
use nalgebra::Vector3;
use scene::{Gait, ObjectiveKind, Scene, StrokeStart, spans};

use swimmer::{Efficiency, Folder, Method, Outcome, choose, simulate};

use super::farthest::farthest;
use super::limits::{StrokeLimits, drag_of_bodies};
use super::objective::{
    DisplacementMeasure, HighestEfficiency, LeastEnergy, LeastEnergyRotation, Objective,
};
use super::optimise::{Optimum, SearchOptions, optimise};
use super::optimum_scene;
use super::speed::fastest_stroke;
use super::stroke_path::SampledPath;
use super::table::{StrokeTable, tabulate};
use super::timing::{MotionBounds, Peaks, Timing, energy, peaks};
use super::totals::{Stroke, StrokeTotals};
use crate::best_wave::wave_variables;
use crate::error::{DesignError, DesignProgress};

/// Error of the table relative to the tolerance of the search.
const TABLE_SHARE: f64 = 1e-3;

/// Part by which a stroke is slower than its bounds allow, so that rounding does not exceed them.
const ROUNDING: f64 = 1e-9;

/// Number of shapes of the stroke in [`DesignedStroke::shapes`], first and last one included.
const SHAPE_COUNT: usize = 201;

/// The best stroke of a scene.
#[derive(Debug)]
#[non_exhaustive]
pub struct DesignedStroke {
    /// What the search found in the table.
    pub optimum: Optimum,
    /// The table.
    pub table: StrokeTable,
    /// The limits.
    pub limits: StrokeLimits,
    /// The scene of the stroke, as in `optimum.toml`.
    pub scene: Scene,
    /// Name of the model of the run.
    pub model: &'static str,
    /// Outcome of the run of that scene by the model, without a table.
    pub outcome: Outcome,
    /// Displacement of the frame in that run, to compare with the table: that of the first body of
    /// the linkage. The bodies of a swimmer that turns have different ones.
    pub run_displacement: f64,
    /// Period of the stroke.
    pub period: f64,
    /// Energy of the stroke in its period, by the table.
    pub energy: f64,
    /// Largest rates and power, by the table.
    pub peaks: Peaks,
    /// Values of all joints at equal steps of time, from the start to the end of the stroke.
    pub shapes: Vec<Vec<f64>>,
    /// Lighthill efficiency `6 π μ r Δ² / (E T)` with the sum `r` of the bounding radii of
    /// the bodies.
    pub efficiency: f64,
    /// Lighthill's efficiency of the run, with the drag of all bodies together; none if the stroke
    /// does not swim, or has springs.
    pub run_efficiency: Option<Efficiency>,
    /// Error bar of the displacement by the table, [`StrokeTable::displacement_error`].
    pub table_error: f64,
    /// The gait of the scene, if it has one that closes: totals, and energy times period at
    /// constant power.
    pub gait: Option<(StrokeTotals, f64)>,
}

/// Searches for the best stroke of a scene by its group `optimise`, writes `optimum.toml` into the
/// folder and runs it.
///
/// # Errors
/// Limits or an objective that do not fit the scene, errors of the model,
/// [`DesignError::NoStroke`], [`DesignError::Stopped`], files that cannot be written.
pub fn design_stroke(
    scene: &Scene,
    out: &Path,
    progress: &mut dyn DesignProgress,
) -> Result<DesignedStroke, DesignError> {
    DesignError::check_rheology(scene)?;
    if !wave_variables(scene)?.is_empty() {
        return Err(DesignError::not_applicable(
            scene,
            "optimise",
            "the limits are those of a wave, which is no stroke; search for it by `swim optimise`, \
             in the library by `best_wave`, or give limits of the phase and leave out \
             optimise.waves",
        ));
    }
    let options = scene.optimise();
    let limits = StrokeLimits::from_scene(scene)?;
    let scene = &scene.with_tolerance(scene.model().tolerance.min(options.tolerance))?;
    let start = fixed_start(scene, &limits)?;
    let bounds = MotionBounds::from_scene(scene, &limits)?;
    if options.objective == ObjectiveKind::Speed && bounds.is_none() {
        return Err(DesignError::not_applicable(
            scene,
            "optimise.objective",
            "the largest displacement per time requires a bound; give optimise.max_rate or \
             optimise.max_power",
        ));
    }
    let folder = Folder::create(out)?;
    let table = tabulate(
        scene,
        &limits,
        TABLE_SHARE * options.tolerance,
        (Some(&folder), TablePart::Whole),
        progress,
    )?;
    let gait = gait_totals(scene, &limits, &table.geometry)?;
    let moving = limits.moving(&limits.ranges);
    let search = SearchOptions::default()
        .with_start(start)
        .with_terms(options.terms as usize)
        .with_tolerance(options.tolerance);
    let (geometry, measure) = (&table.geometry, measure_of(scene));
    let optimum = match (options.objective, &bounds) {
        (ObjectiveKind::Displacement, _) => farthest(geometry, measure, &moving)?,
        (ObjectiveKind::Speed, Some(bounds)) => {
            fastest_stroke(geometry, measure, (&moving, bounds), &search, progress)?
        }
        _ => {
            let objective = objective_of(scene, gait.as_ref().map(|gait| gait.0))?;
            optimise(geometry, objective.as_ref(), &moving, &search, progress)?
        }
    };
    progress.begins("running the stroke by the full model");
    let Timed {
        scene: found,
        timing,
        peaks,
        energy,
    } = timed(scene, &limits, geometry, &optimum, bounds.as_ref(), &folder)?;
    let mut model = choose(&found)?.model;
    let outcome = simulate(&found, model.as_mut(), Method::Collocation, &mut ())?;
    let run_efficiency = Efficiency::of_run(&found, model.as_mut(), &outcome)?;
    let shape = |k: usize| {
        let share = (k % (SHAPE_COUNT - 1)) as f64 / (SHAPE_COUNT - 1) as f64;
        limits.full_shape(&optimum.curve.shape(timing.parameter(share)))
    };
    let shapes: Vec<Vec<f64>> = (0..SHAPE_COUNT).map(shape).collect();
    let drag = drag_of_bodies(scene);
    let period = timing.period();
    Ok(DesignedStroke {
        efficiency: drag * optimum.totals.displacement.norm_squared() / (energy * period),
        run_efficiency,
        table_error: table.displacement_error(&shapes),
        shapes,
        model: model.name(),
        run_displacement: outcome.displacement[scene.articulation().linkages()[0].root].norm(),
        scene: found,
        optimum,
        table,
        limits,
        outcome,
        period,
        energy,
        peaks,
        gait,
    })
}

/// The scene of a stroke with its timing.
struct Timed {
    scene: Scene,
    timing: Timing,
    peaks: Peaks,
    energy: f64,
}

/// Writes the scene of the stroke: the fastest one within the bounds, or with the period or the
/// power of the scene.
///
/// A table of shapes and times exceeds the bounds between its rows by a little; the motion is as
/// much slower.
fn timed(
    scene: &Scene,
    limits: &StrokeLimits,
    geometry: &ShapeGeometry,
    optimum: &Optimum,
    bounds: Option<&MotionBounds>,
    folder: &Folder,
) -> Result<Timed, DesignError> {
    let options = scene.optimise();
    let curve = &optimum.curve;
    let product = optimum.period_energy_product;
    let Some(bounds) = bounds else {
        // E = P T.
        let of_power = options.power.map(|power| (product / power).sqrt());
        let timing = Timing::uniform(curve, of_power.unwrap_or(options.period));
        let scene = optimum_scene::write(scene, limits, curve, &timing, folder)?;
        return Ok(Timed {
            peaks: peaks(&scene, limits, geometry, None)?.0,
            energy: product / timing.period(),
            scene,
            timing,
        });
    };
    let fastest = Timing::fastest(geometry, curve, bounds)?;
    let first = optimum_scene::write(scene, limits, curve, &fastest, folder)?;
    let load = peaks(&first, limits, geometry, Some(bounds))?.1;
    // Rates are inversely proportional to the period.
    let timing = fastest.slower(load * (1.0 + ROUNDING));
    let found = optimum_scene::write(scene, limits, curve, &timing, folder)?;
    Ok(Timed {
        peaks: peaks(&found, limits, geometry, Some(bounds))?.0,
        energy: energy(&found, limits, geometry)?,
        scene: found,
        timing,
    })
}

/// The shape of the scene, if strokes start there.
fn fixed_start(scene: &Scene, limits: &StrokeLimits) -> Result<Option<Vec<f64>>, DesignError> {
    if scene.optimise().start == StrokeStart::Closed {
        return Ok(None);
    }
    let initial = scene.articulation().initial_shape();
    for &joint in &limits.variables {
        let (range, value) = (limits.ranges[joint], initial[joint]);
        // At a limit, every small excess near the start would be outside.
        if !(range.0 < value && value < range.1) {
            let problem = format!(
                "the stroke starts at {value} of \"{}\", which must be strictly between the limits \
                 {} and {}; widen optimise.lower or optimise.upper",
                scene.articulation().joints()[joint].name,
                range.0,
                range.1
            );
            return Err(DesignError::not_applicable(
                scene,
                "optimise.start",
                problem,
            ));
        }
    }
    Ok(Some(limits.moving(initial)))
}

/// Totals of one cycle of the gait of a scene, and its energy times period at constant power.
///
/// None for a scene without a gait, or one whose cycle does not close or leaves the table.
///
/// # Errors
/// A gait that cannot be followed.
pub fn gait_totals(
    scene: &Scene,
    limits: &StrokeLimits,
    geometry: &ShapeGeometry,
) -> Result<Option<(StrokeTotals, f64)>, DesignError> {
    let path = closed_gait(scene, limits)?;
    let stroke = path.and_then(|path| Stroke::along(geometry, &path).ok());
    Ok(stroke.map(|stroke| (stroke.totals, stroke.length.powi(2))))
}

/// Shapes along one cycle of the gait of a scene; none without a gait that closes.
///
/// # Errors
/// A gait that cannot be followed.
pub fn gait_shapes(scene: &Scene, limits: &StrokeLimits) -> Result<Vec<Vec<f64>>, DesignError> {
    Ok(closed_gait(scene, limits)?.map_or(Vec::new(), |path| path.shapes))
}

fn closed_gait(scene: &Scene, limits: &StrokeLimits) -> Result<Option<SampledPath>, DesignError> {
    let gait = Gait {
        cycles: 1,
        phases: scene.gait().phases.clone(),
    };
    let start = scene.articulation().initial_shape();
    let cycle: Vec<_> = spans(&gait, start)?.collect();
    let is_closed = cycle
        .last()
        .is_some_and(|last| scene.shape_changes(start, &last.to).is_empty());
    Ok(is_closed.then(|| SampledPath::from_spans(cycle.into_iter(), &limits.variables)))
}

/// Which displacement counts, by `optimise.direction`.
fn measure_of(scene: &Scene) -> DisplacementMeasure {
    match scene.optimise().direction {
        Some(direction) => DisplacementMeasure::Along(Vector3::from(direction).normalize()),
        None => DisplacementMeasure::Length,
    }
}

/// The objective of the group `optimise`, for a gait with these totals.
///
/// # Errors
/// [`DesignError::NotApplicable`] for an objective without its displacement or rotation.
pub fn objective_of(
    scene: &Scene,
    gait: Option<StrokeTotals>,
) -> Result<Box<dyn Objective>, DesignError> {
    let options = scene.optimise();
    let measure = measure_of(scene);
    let of_gait = gait
        .map(|totals| measure.of(&totals).0.abs())
        .filter(|x| *x > 0.0);
    let missing = |key: &str, problem: &str| {
        Err(DesignError::not_applicable(
            scene,
            key,
            format!("{key} is missing: {problem}"),
        ))
    };
    Ok(match options.objective {
        // The largest displacement has no search of this kind, see [`farthest`]; the largest
        // displacement per time has its own, see [`fastest_stroke`].
        ObjectiveKind::Efficiency | ObjectiveKind::Displacement | ObjectiveKind::Speed => {
            Box::new(HighestEfficiency { measure })
        }
        ObjectiveKind::Energy => match options.displacement.or(of_gait) {
            Some(displacement) => Box::new(LeastEnergy {
                measure,
                displacement,
            }),
            None => {
                return missing(
                    "optimise.displacement",
                    "say how far the stroke goes, the scene has no gait that does",
                );
            }
        },
        ObjectiveKind::Rotation => match options.rotation.filter(|angle| *angle != 0.0) {
            Some(angle) => Box::new(LeastEnergyRotation {
                axis: Vector3::from(options.axis).normalize(),
                angle,
            }),
            None => return missing("optimise.rotation", "say by which angle the stroke turns"),
        },
    })
}
