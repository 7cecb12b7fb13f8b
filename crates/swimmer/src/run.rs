//! A whole run: element sizes, model, tables, checkpoint, gait, files.

use std::io::Write as _;
use std::path::Path;
use std::time::Instant;

use models::Hydrodynamics;
use scene::{Leg, Scene};

use crate::SwimError;
use crate::checkpoint::Checkpoint;
use crate::integrate::{LegResult, LegSolution, Method};
use crate::observer::Observer;
use crate::outcome::{Interim, Outcome};
use crate::output::{FlowSeries, Folder, summary_json, trajectory_csv, trajectory_svg};
use crate::planning::{Choice, Trial, TrialObserver, choose, size_factor_for_target, with_tables};
use crate::simulate::continue_from;

/// What a run tells its caller while it goes on.
pub trait Progress {
    /// Whether the caller wants the run to end; asked after every solve.
    fn is_interrupted(&self) -> bool {
        false
    }

    /// A stroke on a coarse mesh was tried for `fem.target`.
    fn tried(&mut self, trial: &Trial) {
        let _ = trial;
    }

    /// The element sizes that `fem.target` needs are known.
    fn chose_size_factor(&mut self, target: f64, size_factor: f64) {
        let _ = (target, size_factor);
    }

    /// The gait begins, or continues after `done` phases of an earlier run.
    fn begins(&mut self, scene: &Scene, done: usize) {
        let _ = (scene, done);
    }

    /// A solve is done.
    fn solved(&mut self, leg: &Leg, solution: &LegSolution) {
        let _ = (leg, solution);
    }

    /// A phase is done.
    fn leg_done(&mut self, leg: &Leg, result: &LegResult) {
        let _ = (leg, result);
    }
}

/// A caller that wants to know nothing.
impl Progress for () {}

/// A finished run.
pub struct Report {
    /// The scene as it was run, with the element sizes that `fem.target` needed.
    pub scene: Scene,
    /// Name of the model.
    pub model: &'static str,
    /// Why this model.
    pub reasons: Vec<String>,
    /// What the gait did.
    pub outcome: Outcome,
    /// Wall-clock seconds of everything.
    pub seconds: f64,
}

/// Runs the gait of a scene and writes `summary.json`, `trajectory.csv`, `trajectory.svg`,
/// ParaView files and a checkpoint into the folder `out`.
///
/// In this order: with `resume` the checkpoint in `out` is read; otherwise coarse strokes choose
/// the element sizes that `fem.target` needs. Then the model is chosen, with tables over shapes
/// where they save solves, and the gait is run or continued.
///
/// # Errors
/// A scene without gait, a folder that cannot be written to, a checkpoint of another scene;
/// [`SwimError::Interrupted`]; what the model and the integration fail with.
pub fn run(
    mut scene: Scene,
    out: &Path,
    resume: bool,
    progress: &mut dyn Progress,
) -> Result<Report, SwimError> {
    let started = Instant::now();
    scene.require_gait()?;
    let checkpoint = resume.then(|| Checkpoint::read(out)).transpose()?;
    let folder = Folder::create(out)?;
    let size_factor = match &checkpoint {
        Some(checkpoint) => checkpoint.size_factor(),
        None => size_factor(&scene, progress)?,
    };
    if scene.fem().target.is_some() {
        scene = scene.with_size_factor(scene.fem().size_factor.or(size_factor))?;
    }
    let Choice { mut model, reasons } = with_tables(&scene, choose(&scene)?);
    let (interim, flows) = match checkpoint {
        None => {
            let interim = Interim::start(&scene)?;
            // The files of an older run must not look like this one's if this one ends early.
            folder.remove_old("summary.json")?;
            Checkpoint::new(
                &scene,
                &interim.state,
                &interim.outcome,
                model.as_ref(),
                &[],
            )?
            .write(&folder)?;
            (interim, FlowSeries::new(&folder))
        }
        Some(checkpoint) => {
            let (interim, flows) = checkpoint.restore(&scene, model.as_mut(), out)?;
            let flows = FlowSeries::resumed(&folder, &flows);
            (interim, flows)
        }
    };
    let done = interim.outcome.legs.len();
    progress.begins(&scene, done);
    let mut files = Files {
        scene: &scene,
        folder: &folder,
        flows,
        progress,
        done,
    };
    let method = Method::Collocation;
    let outcome = continue_from(&scene, model.as_mut(), method, &mut files, interim)?;
    let seconds = started.elapsed().as_secs_f64();
    let name = model.name();
    let summary = summary_json(&scene, name, &reasons, &outcome, seconds);
    folder.write("summary.json", |file| writeln!(file, "{summary:#}"))?;
    Ok(Report {
        scene,
        model: name,
        reasons,
        outcome,
        seconds,
    })
}

/// The factor on element sizes that `fem.target` needs, if it has to be chosen.
fn size_factor(scene: &Scene, progress: &mut dyn Progress) -> Result<Option<f64>, SwimError> {
    let chosen = size_factor_for_target(scene, &mut Trials(progress))?;
    if let (Some(size_factor), Some(target)) = (chosen, scene.fem().target) {
        progress.chose_size_factor(target, size_factor);
    }
    Ok(chosen)
}

/// Coarse strokes that can be interrupted.
struct Trials<'a>(&'a mut dyn Progress);

impl Observer for Trials<'_> {
    fn solved(&mut self, _: &Leg, _: &LegSolution, _: &dyn Hydrodynamics) -> Result<(), SwimError> {
        match self.0.is_interrupted() {
            true => Err(SwimError::Interrupted { phases: 0, all: 0 }),
            false => Ok(()),
        }
    }
}

impl TrialObserver for Trials<'_> {
    fn tried(&mut self, trial: &Trial) {
        self.0.tried(trial);
    }
}

/// Writes the files of a run as it goes on, so that a run that ends early leaves everything up to
/// that point.
struct Files<'a> {
    scene: &'a Scene,
    folder: &'a Folder,
    flows: FlowSeries,
    progress: &'a mut dyn Progress,
    /// Legs that are done.
    done: usize,
}

impl Observer for Files<'_> {
    fn solved(
        &mut self,
        leg: &Leg,
        solved: &LegSolution,
        model: &dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        if self.progress.is_interrupted() {
            let gait = self.scene.gait();
            return Err(SwimError::Interrupted {
                phases: self.done,
                all: gait.phases.len() * gait.cycles as usize,
            });
        }
        self.progress.solved(leg, solved);
        match model.last_flow() {
            Some(flow) => self.flows.add(solved.number, &flow),
            None => Ok(()),
        }
    }

    fn leg_done(
        &mut self,
        leg: &Leg,
        result: &LegResult,
        so_far: &Outcome,
        model: &dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        self.flows
            .finish_leg(leg, result, so_far.solves - result.solves)?;
        let csv = trajectory_csv(self.scene, &so_far.samples);
        self.folder
            .write("trajectory.csv", |file| file.write_all(csv.as_bytes()))?;
        let svg = trajectory_svg(self.scene, so_far)?;
        self.folder
            .write("trajectory.svg", |file| file.write_all(svg.as_bytes()))?;
        // The checkpoint last: every file that it names is complete.
        let flows = self.flows.files();
        Checkpoint::new(self.scene, &result.end, so_far, model, flows)?.write(self.folder)?;
        self.done = so_far.legs.len();
        self.progress.leg_done(leg, result);
        Ok(())
    }
}
