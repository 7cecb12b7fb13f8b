//! A complete run: element sizes, model, tables, checkpoint, gait, files.

use std::path::Path;
use std::time::Instant;

use models::{Hydrodynamics, ModelError};
use scene::{AcceptKind, Scene};
use serde_json::Value;

use crate::checkpoint::Checkpoint;
use crate::error::SwimError;
use crate::integrate::{Method, SpanSolution};
use crate::outcome::Outcome;
use crate::output::{Folder, summary_json};
use crate::periodic::start_of_gait;
use crate::planning::{Choice, SizeSearch, choose, with_tables};
use crate::progress::Progress;
use crate::run_files::{Files, Output, RunFiles};
use crate::simulate::continue_from;

/// A finished run.
#[derive(Debug)]
#[non_exhaustive]
pub struct Report {
    /// The scene as it was run, with the element sizes chosen for `fem.target`.
    pub scene: Scene,
    /// Name of the model.
    pub model: &'static str,
    /// Reasons for the choice of the model.
    pub reasons: Vec<String>,
    /// Outcome of the gait.
    pub outcome: Outcome,
    /// Wall-clock time of the whole run in seconds.
    pub seconds: f64,
}

/// Runs the gait of a scene and writes the results into the folder `out`.
///
/// The files are `summary.json`, `trajectory.csv`, ParaView files for models with a mesh, and a
/// checkpoint, and those that the caller adds (`files`; the crate `pictures` has plots and a page).
///
/// The model is chosen, with tables over shapes where they save solves, and the gait is run. With
/// `fem.target` the element sizes are those of [`SizeSearch`], and a stroke that misses the target
/// is repeated with smaller ones; its files are replaced. With `resume` the run continues from the
/// checkpoint in `out`.
///
/// # Errors
/// A scene without a gait, a folder that cannot be written to, a checkpoint of another scene,
/// [`SwimError::Interrupted`], errors of the model and the integration. Whether the error bar is
/// within the tolerance is told by [`Report::check_tolerance`].
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

/// How a run gets the model of a scene.
pub type ModelOfScene<'a> = &'a dyn Fn(&Scene) -> Result<Choice, ModelError>;

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
    let checkpoint = resume.then(|| Checkpoint::read(out)).transpose()?;
    let folder = writes.then(|| Folder::create(out)).transpose()?;
    let output = folder.as_ref().map(|folder| (folder, files));
    run_to_target(scene, model, output, checkpoint, started, progress)
}

/// The model that [`choose`] chooses, with tables over shapes where they save solves.
fn choose_with_tables(scene: &Scene) -> Result<Choice, ModelError> {
    with_tables(scene, choose(scene)?)
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
    scene: Scene,
    model: ModelOfScene,
    mut output: Option<(&Folder, &mut dyn RunFiles)>,
    mut checkpoint: Option<Checkpoint>,
    started: Instant,
    progress: &mut dyn Progress,
) -> Result<Report, SwimError> {
    let mut search = SizeSearch::new(&scene)?;
    if let (Some(search), Some(checkpoint)) = (&mut search, &checkpoint) {
        search.continue_with(checkpoint.size_factor());
    }
    loop {
        let mut sized = scene.clone();
        if let (Some(search), Some(target)) = (&search, scene.fem().target) {
            sized = search.apply(&scene)?;
            progress.chose_size_factor(target, search.size_factor());
        }
        let reborrowed: Option<(&Folder, &mut dyn RunFiles)> = match &mut output {
            Some((folder, files)) => Some((folder, &mut **files)),
            None => None,
        };
        let report = run_once(sized, model, reborrowed, checkpoint.take(), progress)?;
        let missed = search
            .as_mut()
            .and_then(|search| search.refine(&report.outcome));
        let Some(missed) = missed else {
            let seconds = started.elapsed().as_secs_f64();
            let report = Report { seconds, ..report };
            if let Some((folder, files)) = output {
                let summary = report.summary();
                folder.write("summary.json", |file| writeln!(file, "{summary:#}"))?;
                files.run_done(&report, &summary)?;
            }
            return Ok(report);
        };
        progress.missed_target(&missed);
    }
}

/// Runs the gait of a scene with its element sizes, from its beginning or from a checkpoint.
fn run_once(
    scene: Scene,
    model: ModelOfScene,
    output: Option<(&Folder, &mut dyn RunFiles)>,
    checkpoint: Option<Checkpoint>,
    progress: &mut dyn Progress,
) -> Result<Report, SwimError> {
    let folder = output.as_ref().map(|(folder, _)| *folder);
    let resumed = checkpoint.is_some();
    let Choice { mut model, reasons } = model(&scene)?;
    let (interim, flows) = match checkpoint {
        None => {
            let mut observe =
                |_: &SpanSolution, _: &dyn Hydrodynamics| match progress.is_interrupted() {
                    true => Err(SwimError::Interrupted {
                        phases: 0,
                        all: scene.gait().phases.len() * scene.gait().cycles as usize,
                    }),
                    false => Ok(()),
                };
            let method = Method::of(&scene);
            let interim = start_of_gait(&scene, model.as_mut(), method, &mut observe)?;
            if let Some(folder) = folder {
                // If this run ends early, the summary of an older run must not be taken for its
                // result.
                folder.remove_old("summary.json")?;
                Checkpoint::new(
                    &scene,
                    &interim.state,
                    &interim.outcome,
                    model.as_ref(),
                    &[],
                )?
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
        files.begins(&scene, folder, resumed)?;
        Ok::<_, SwimError>(Output::new(&scene, folder, files, &flows))
    });
    let output = output.transpose()?;
    progress.begins(&scene, done);
    let mut files = Files {
        scene: &scene,
        output,
        progress,
        done,
    };
    let method = Method::of(&scene);
    let outcome = continue_from(&scene, model.as_mut(), method, &mut files, interim);
    files.write_pending()?;
    let outcome = outcome?;
    if let Some(output) = files.output {
        output.files.gait_done(model.as_mut())?;
    }
    Ok(Report {
        model: model.name(),
        scene,
        reasons,
        outcome,
        seconds: 0.0,
    })
}

impl Report {
    /// The summary of the run, as in `summary.json`.
    pub fn summary(&self) -> Value {
        summary_json(
            &self.scene,
            self.model,
            &self.reasons,
            &self.outcome,
            self.seconds,
        )
    }

    /// Whether the error bar is within the tolerance, or the scene accepts the best result.
    ///
    /// # Errors
    /// [`SwimError::ToleranceMissed`].
    pub fn check_tolerance(&self) -> Result<(), SwimError> {
        let (model, outcome) = (self.scene.model(), &self.outcome);
        if outcome.tolerance_met || model.accept == AcceptKind::Best {
            return Ok(());
        }
        Err(SwimError::ToleranceMissed {
            error: outcome.limited_error.unwrap_or(f64::INFINITY),
            tolerance: model.tolerance,
            allowed: outcome.allowed_error,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::Interim;

    fn report(accept: &str, tolerance_met: bool) -> Report {
        let scene = Scene::parse(&format!(
            "model = {{ tolerance = 1e-4, accept = \"{accept}\" }}\n\
             bodies = [{{ name = \"a\", radius = 1, position = [0, 0, 0] }}]\n"
        ))
        .unwrap();
        let mut outcome = Interim::start(&scene).unwrap().outcome;
        outcome.displacement = vec![nalgebra::Vector3::x()];
        outcome.error_estimate.integration = Some(1e-3);
        outcome.limited_error = Some(1e-3);
        outcome.allowed_error = 1e-4;
        outcome.tolerance_met = tolerance_met;
        Report {
            scene,
            model: "rpy",
            reasons: Vec::new(),
            outcome,
            seconds: 0.0,
        }
    }

    #[test]
    fn a_missed_tolerance_is_an_error_with_what_was_reached_unless_the_best_is_accepted() {
        assert!(report("tolerance", true).check_tolerance().is_ok());
        assert!(report("best", false).check_tolerance().is_ok());
        let missed = report("tolerance", false);
        let error = missed.check_tolerance().unwrap_err();
        assert_eq!(error.exit_code(), 3);
        let text = error.to_string();
        for part in ["is 1.0e-3", "1e-4 allows 1.0e-4", "accept = \"best\""] {
            assert!(text.contains(part), "{text}");
        }
        assert!(matches!(error, SwimError::ToleranceMissed { error, .. } if error == 1e-3));
        assert_eq!(missed.outcome.net(), 1.0);
    }
}
