//! A complete run: element sizes, model, tables, checkpoint, gait, files.

use std::path::Path;
use std::time::Instant;

use models::{Hydrodynamics, ModelError, NeglectedTerm};
use scene::{AcceptKind, Scene};

use crate::checkpoint::{self, Checkpoint};
use crate::decision::Decision;
use crate::efficiency::Efficiency;
use crate::error::SwimError;
use crate::integrate::Method;
use crate::neglected::{is_automatic, run_neglected, with_term};
use crate::observer::Progress;
use crate::output::{Folder, swimmers_csv};
use crate::periodic::start_of_gait;
use crate::planning::{Choice, ModelOfScene, SizeSearch, choose_for_run, with_tables};
use crate::run_files::{Files, Output, RunFiles};
use crate::run_report::Report;
use crate::simulate::continue_from;

/// Runs the gait of a scene and writes the results into the folder `out`.
///
/// The files are `summary.json`, `swimmers.csv` for several swimmers, `trajectory.csv` or
/// `trajectory.npy`, ParaView files for models with a mesh, and a checkpoint, and those that the
/// caller adds (`files`; the crate `pictures` has plots and a page).
///
/// The model is chosen, with tables over shapes where they save solves, and the gait is run. With
/// `fem.target` the element sizes are those of [`SizeSearch`], and a stroke that misses the target
/// is repeated with smaller ones; its files are replaced. So is a run whose error bar misses
/// `model.tolerance` although the model can do better (`model.tolerance_factor`). With `resume` the
/// run continues from the checkpoint in `out`.
///
/// # Errors
/// A scene without a gait, a folder that cannot be written to or in which another run is writing
/// ([`SwimError::Locked`]), a checkpoint of another scene or of changed files,
/// [`SwimError::Interrupted`], errors of the model and the integration before anything has moved. A
/// run that stops later, because bodies touch or the motion cannot be computed any further, is a
/// report up to there, with all files; [`Report::completed`] makes the error. Whether the error bar
/// is within the tolerance is told by [`Report::check_tolerance`].
pub fn run(
    scene: Scene,
    out: &Path,
    resume: bool,
    files: &mut dyn RunFiles,
    progress: &mut dyn Progress,
) -> Result<Report, SwimError> {
    let model = &choose_with_tables;
    run_with(scene, model, out, resume, true, files, progress)
}

/// Runs the gait of a scene as [`run`] does, with a model of the caller's choice.
///
/// Of several processes that compute the same run, one writes files (`writes`). All of them read
/// the checkpoint with `resume`.
///
/// # Errors
/// As [`run`].
pub fn run_with(
    scene: Scene,
    model: ModelOfScene,
    out: &Path,
    resume: bool,
    writes: bool,
    files: &mut dyn RunFiles,
    progress: &mut dyn Progress,
) -> Result<Report, SwimError> {
    let started = Instant::now();
    scene.require_gait()?;
    if resume && !out.join(checkpoint::FILE).exists() {
        // Before a folder is made.
        return Err(SwimError::Checkpoint {
            path: out.join(checkpoint::FILE),
            problem: "does not exist: no run of this folder was interrupted after a phase; name \
                      the folder of the run"
                .to_owned(),
        });
    }
    let folder = writes.then(|| Folder::create(out)).transpose()?;
    // Until the end of the run. What a process reads must not change meanwhile either.
    let _lock = folder.as_ref().map(Folder::lock).transpose()?;
    let checkpoint = resume.then(|| Checkpoint::read(out)).transpose()?;
    let output = folder.as_ref().map(|folder| (folder, files));
    run_to_target(scene, model, output, checkpoint, started, progress)
}

/// The model that [`choose_for_run`] chooses, with tables over shapes where they save solves.
fn choose_with_tables(scene: &Scene, progress: &mut dyn Progress) -> Result<Choice, ModelError> {
    with_tables(scene, choose_for_run(scene, progress)?)
}

/// Runs the gait of a scene as [`run`] does, without a folder: no files, no checkpoint.
///
/// # Errors
/// As [`run`].
pub fn run_without_files(scene: Scene, progress: &mut dyn Progress) -> Result<Report, SwimError> {
    scene.require_gait()?;
    run_to_target(
        scene,
        &choose_with_tables,
        None,
        None,
        Instant::now(),
        progress,
    )
}

/// Runs the gait until its error bar meets `fem.target`.
fn run_to_target(
    mut scene: Scene,
    model: ModelOfScene,
    mut output: Option<(&Folder, &mut dyn RunFiles)>,
    mut checkpoint: Option<Checkpoint>,
    started: Instant,
    progress: &mut dyn Progress,
) -> Result<Report, SwimError> {
    for term in NeglectedTerm::ALL {
        if (checkpoint.as_ref()).is_some_and(|before| before.decided_for(&scene, term)) {
            scene = with_term(&scene, term)?;
        }
    }
    let mut search = SizeSearch::new(&scene)?;
    if let (Some(search), Some(checkpoint)) = (&mut search, &checkpoint) {
        search.continue_with(checkpoint.size_factor());
    }
    // A factor that the user gives is compared with that of the checkpoint, like all keys.
    let given = scene.model().tolerance_factor;
    let mut factor = given.or_else(|| checkpoint.as_ref()?.tolerance_factor());
    let mut repetition = Repetition::default();
    loop {
        let mut sized = scene.with_tolerance_factor(factor)?;
        if let (Some(search), Some(target)) = (&search, scene.fem().target) {
            sized = search.apply(&sized)?;
            progress.chose_size_factor(target, search.size_factor());
        }
        let reborrowed: Option<(&Folder, &mut dyn RunFiles)> = match &mut output {
            Some((folder, files)) => Some((folder, &mut **files)),
            None => None,
        };
        let (report, mut model_of_run) =
            run_once(sized, model, reborrowed, checkpoint.take(), progress)?;
        let completed = report.stopped.is_none();
        let missed = (search.as_mut())
            .filter(|_| completed)
            .and_then(|search| search.refine(&report.outcome));
        let tighter = match completed && missed.is_none() && given.is_none() {
            true => repetition.tighter_factor(&report),
            false => None,
        };
        if let Some(tighter) = tighter {
            let outcome = &report.outcome;
            let error = outcome.limited_error.unwrap_or(f64::INFINITY);
            progress.missed_tolerance(error, outcome.allowed_error, tighter);
            factor = Some(tighter);
            continue;
        }
        let Some(missed) = missed else {
            let outcome = &report.outcome;
            let neglected = run_neglected(&report.scene, model_of_run.as_mut(), outcome, progress)?;
            let mut reasons = report.reasons;
            let automatic = NeglectedTerm::ALL.into_iter().filter(|_| completed);
            let mut kept = None;
            for term in automatic.filter(|term| is_automatic(&scene, *term)) {
                let decision = Decision::after_run(term, &neglected, &scene, outcome);
                if decision.keeps {
                    progress.keeps_term(&decision.reason);
                    kept = Some(term);
                    break;
                }
                reasons.push(decision.reason);
            }
            if let Some(term) = kept {
                scene = with_term(&scene, term)?;
                continue;
            }
            let model = model_of_run.as_mut();
            let efficiency = Efficiency::of_run(&report.scene, model, outcome)?;
            let report = Report {
                reasons,
                neglected,
                efficiency,
                seconds: started.elapsed().as_secs_f64(),
                ..report
            };
            progress.works("writing the results", 0.0, 0.0);
            if let Some((folder, files)) = output {
                write_summary(&report, folder, files)?;
            }
            return Ok(report);
        };
        progress.missed_target(&missed);
    }
}

/// Files with results, not all of which every run writes.
const RESULTS: [&str; 4] = [
    "summary.json",
    "swimmers.csv",
    "trajectory.csv",
    "trajectory.npy",
];

/// Writes `summary.json`, `swimmers.csv` and the files of the caller that need it.
fn write_summary(
    report: &Report,
    folder: &Folder,
    files: &mut dyn RunFiles,
) -> Result<(), SwimError> {
    let summary = report.summary();
    folder.write("summary.json", |file| writeln!(file, "{summary:#}"))?;
    let swimmers = report.outcome.swimmers(&report.scene);
    if !swimmers.is_empty() {
        let csv = swimmers_csv(&report.scene, &swimmers);
        folder.write("swimmers.csv", |file| file.write_all(csv.as_bytes()))?;
    }
    files.run_done(report, &summary)
}

/// Share of the allowed error at which a repetition aims, because error bars do not decrease quite
/// in proportion to the tolerance.
const AIM_SHARE: f64 = 0.5;

/// Smallest factor: below it solutions have the accuracy of rounding for the default tolerance.
const LEAST_FACTOR: f64 = 1e-6;

/// Smallest ratio by which one repetition reduces the factor: a bar that is much too wide may be
/// so for another reason than the tolerance of single solutions, which would cost much in vain.
const LEAST_RATIO: f64 = 0.1;

/// Reduction of the factor, without a smaller error bar, at which a model cannot do better.
///
/// The accuracy of models increases in steps, with the order of their expansions or elements; an
/// order reduces the error by a factor of two to ten.
const MAX_REDUCTION_IN_VAIN: f64 = 0.05;

/// Ratio of error bars that counts as smaller.
const REDUCED: f64 = 0.9;

/// Repetitions of a run with smaller tolerances of single solutions.
#[derive(Default)]
struct Repetition {
    /// Smallest error bar so far, with its factor.
    best: Option<(f64, f64)>,
}

impl Repetition {
    /// The factor on the tolerance of single solutions with which a run whose error bar misses the
    /// tolerance is expected to meet it.
    ///
    /// None if it meets it, if the scene accepts the best result, if the model does not control its
    /// own error, so that nothing but the integration depends on the tolerance, or if the last
    /// repetitions did not reduce the error bar.
    fn tighter_factor(&mut self, report: &Report) -> Option<f64> {
        let (options, outcome) = (report.scene.model(), &report.outcome);
        let limited = outcome.limited_error?;
        let controls_error = limited >= outcome.error_estimate.total();
        if outcome.tolerance_met || options.accept == AcceptKind::Best || !controls_error {
            return None;
        }
        let factor = options.tolerance_factor.unwrap_or(1.0);
        match self.best {
            Some((bar, at)) if limited > REDUCED * bar => {
                if factor <= MAX_REDUCTION_IN_VAIN * at {
                    return None;
                }
            }
            _ => self.best = Some((limited, factor)),
        }
        let ratio = AIM_SHARE * outcome.allowed_error / limited;
        let tighter = factor * ratio.max(LEAST_RATIO);
        (ratio > 0.0 && tighter >= LEAST_FACTOR).then_some(tighter)
    }
}

/// Runs the gait of a scene with its element sizes, from its beginning or from a checkpoint, and
/// returns the model too.
fn run_once(
    scene: Scene,
    model: ModelOfScene,
    output: Option<(&Folder, &mut dyn RunFiles)>,
    checkpoint: Option<Checkpoint>,
    progress: &mut dyn Progress,
) -> Result<(Report, Box<dyn Hydrodynamics>), SwimError> {
    let folder = output.as_ref().map(|(folder, _)| *folder);
    let Choice { mut model, reasons } = model(&scene, progress)?;
    let (interim, flows) = match checkpoint {
        None => {
            let method = Method::from_scene(&scene);
            let interim = start_of_gait(&scene, model.as_mut(), method, progress)?;
            if let Some(folder) = folder {
                // If this run ends early, or writes others, files of an older run must not be taken
                // for its results.
                for name in RESULTS {
                    folder.remove_old(name)?;
                }
                Checkpoint::new(
                    &scene,
                    &interim.state,
                    &interim.outcome,
                    model.as_ref(),
                    &[],
                )?
                .with_fluid(interim.fluid.as_ref())
                .write(folder)?;
            }
            (interim, Vec::new())
        }
        Some(checkpoint) => {
            let path = folder.map_or(Path::new(""), Folder::path);
            checkpoint.restore(&scene, model.as_mut(), path)?
        }
    };
    let done = interim.outcome.spans.len();
    let output = output.map(|(folder, files)| {
        files.begins(&scene, folder, done)?;
        Ok::<_, SwimError>(Output::new(&scene, folder, files, &flows))
    });
    let output = output.transpose()?;
    progress.begins(&scene, done);
    let mut files = Files {
        scene: &scene,
        output,
        progress,
        done,
        stopped: None,
    };
    let method = Method::from_scene(&scene);
    let outcome = continue_from(&scene, model.as_mut(), method, &mut files, interim);
    files.write_pending()?;
    let Files {
        output,
        stopped,
        progress,
        ..
    } = files;
    let (outcome, stopped) = match (outcome, stopped) {
        (Ok(outcome), _) => (outcome, None),
        // The files of what was reached may fail as well; then their error is the one.
        (Err(error), Some(so_far)) if error.ends_motion() => (so_far, Some(error)),
        (Err(error), _) => return Err(error),
    };
    let report = Report {
        model: model.name(),
        scene: scene.clone(),
        reasons,
        outcome,
        neglected: Vec::new(),
        efficiency: None,
        stopped,
        seconds: 0.0,
    };
    if let Some(output) = output {
        output.files.gait_done(model.as_mut(), progress)?;
    }
    Ok((report, model))
}
