//! `swim run`: the whole gait.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use signal_hook::consts::{SIGINT, SIGTERM};
use swimmer::model::{Choice, Hydrodynamics, choose};
use swimmer::output::{FlowSeries, summary_json, trajectory_csv, trajectory_svg};
use swimmer::shape_space::speed_up;
use swimmer::{
    Checkpoint, Folder, Interim, Leg, LegResult, Method, Observer, Outcome, Scene, Solved,
    SwimError, go_on, size_factor_for_target,
};

use super::progress::Progress;
use super::{SceneArguments, duration, errors, say};

pub fn run(
    arguments: &SceneArguments,
    out: Option<PathBuf>,
    resume: bool,
) -> Result<String, SwimError> {
    let started = Instant::now();
    let mut scene = arguments.read()?;
    let out = out.unwrap_or_else(|| PathBuf::from("out").join(&scene.name));
    scene.require_gait()?;
    let checkpoint = resume.then(|| Checkpoint::read(&out)).transpose()?;
    let folder = Folder::create(&out)?;
    let interrupted = watch_signals()?;
    let chosen = match &checkpoint {
        Some(checkpoint) => checkpoint.size_factor(),
        None => size_factor(&scene, &interrupted)?,
    };
    if scene.fem.target.is_some() {
        scene.fem.size_factor = scene.fem.size_factor.or(chosen);
    }
    let Choice { mut model, reasons } = speed_up(&scene, choose(&scene)?);
    let mut files = Files {
        scene: &scene,
        flows: FlowSeries::new(&folder),
        folder,
        progress: Progress::new(&scene),
        legs: scene.gait.phases.len() * scene.gait.cycles as usize,
        done: 0,
        interrupted,
    };
    let method = Method::Collocation;
    let interim = match checkpoint {
        None => {
            let Interim { state, outcome } = Interim::start(&scene)?;
            // An older run's must not look like this one's if this one ends early.
            files.folder.remove_old("summary.json")?;
            // Replaces an older run's, which must not outlive its files.
            Checkpoint::new(&scene, &state, &outcome, model.as_ref(), &[]).write(&files.folder)?;
            Interim { state, outcome }
        }
        Some(checkpoint) => {
            let (interim, flows) = checkpoint.restore(&scene, model.as_mut(), &out)?;
            files.flows = FlowSeries::resumed(&files.folder, &flows);
            files.done = interim.outcome.legs.len();
            files.progress.resumed(files.done);
            interim
        }
    };
    let outcome = go_on(&scene, model.as_mut(), method, &mut files, interim);
    files.progress.finish();
    let outcome = outcome?;
    let seconds = started.elapsed().as_secs_f64();
    let summary = summary_json(&scene, model.name(), &reasons, &outcome, seconds);
    files
        .folder
        .write("summary.json", |file| writeln!(file, "{summary:#}"))?;
    Ok(describe(
        &scene,
        model.as_ref(),
        &outcome,
        seconds,
        &files.folder,
    ))
}

/// The factor on element sizes that `fem.target` needs, if it chooses; says what it tries.
fn size_factor(scene: &Scene, interrupted: &Arc<AtomicBool>) -> Result<Option<f64>, SwimError> {
    struct Trials<'a>(&'a AtomicBool);
    impl Observer for Trials<'_> {
        fn solved(&mut self, _: &Leg, _: &Solved, _: &dyn Hydrodynamics) -> Result<(), SwimError> {
            match self.0.load(Ordering::Relaxed) {
                true => Err(SwimError::Interrupted { phases: 0, all: 0 }),
                false => Ok(()),
            }
        }
    }
    let started = Instant::now();
    let chosen = size_factor_for_target(scene, &mut Trials(interrupted), &mut |trial| {
        say(&format!(
            "a stroke with elements {:.2} times the default ones errs by {:.1e} by the mesh, {}",
            trial.size_factor,
            trial.relative_error,
            duration(started.elapsed().as_secs_f64())
        ));
    })?;
    if let (Some(factor), Some(target)) = (chosen, scene.fem.target) {
        say(&format!(
            "fem.target = {target:e} asks for fem.size_factor = {factor:.3}"
        ));
    }
    Ok(chosen)
}

/// A flag that the first Ctrl-C or termination raises; the second one ends the program at once.
fn watch_signals() -> Result<Arc<AtomicBool>, SwimError> {
    let raised = Arc::new(AtomicBool::new(false));
    let register = || -> std::io::Result<()> {
        for signal in [SIGINT, SIGTERM] {
            // In this order: the shutdown looks at the flag before it is raised.
            signal_hook::flag::register_conditional_shutdown(signal, 130, raised.clone())?;
            signal_hook::flag::register(signal, raised.clone())?;
        }
        Ok(())
    };
    register().map_err(|error| SwimError::NotApplicable {
        place: "signals".to_owned(),
        problem: format!("cannot be watched: {error}"),
    })?;
    Ok(raised)
}

/// Writes the files of a run as it goes on, so that a run that ends early leaves everything up to there.
struct Files<'a> {
    scene: &'a Scene,
    folder: Folder,
    flows: FlowSeries,
    progress: Progress,
    legs: usize,
    done: usize,
    interrupted: Arc<AtomicBool>,
}

impl Observer for Files<'_> {
    fn solved(
        &mut self,
        leg: &Leg,
        solved: &Solved,
        model: &dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        if self.interrupted.load(Ordering::Relaxed) {
            return Err(SwimError::Interrupted {
                phases: self.done,
                all: self.legs,
            });
        }
        self.progress
            .solved(leg, solved.number, solved.instant.solver.iterations);
        match model.flow() {
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
        // The checkpoint last: whatever it promises is on disk.
        let flows = self.flows.files();
        Checkpoint::new(self.scene, &result.end, so_far, model, flows).write(&self.folder)?;
        self.done = so_far.legs.len();
        self.progress.leg_done(leg, result);
        Ok(())
    }
}

/// More rows than this are left out of the table; `summary.json` has them all.
const MOST_ROWS: usize = 24;

fn describe(
    scene: &Scene,
    model: &dyn Hydrodynamics,
    outcome: &Outcome,
    seconds: f64,
    folder: &Folder,
) -> String {
    let mut text = String::new();
    let mut line = |content: String| {
        text.push_str(content.trim_end());
        text.push('\n');
    };
    let links = scene.articulation.links();
    let what: Vec<String> = outcome
        .legs
        .iter()
        .map(|leg| {
            leg.link
                .map_or("held".to_owned(), |l| links[l].name.clone())
        })
        .collect();
    let first = what
        .iter()
        .map(|name| name.chars().count())
        .max()
        .unwrap_or(0)
        .max(12);
    let row = |name: &str, displacement: &[nalgebra::Vector3<f64>]| {
        let mut row = format!("{name:<first$}");
        for d in displacement {
            // Rounded first, and plus zero, so that no "-0.00000" is printed.
            let d = d.map(|x| (1e5 * x).round() / 1e5 + 0.0);
            let _ = write!(row, "  {:>9.5} {:>9.5} {:>9.5}", d.x, d.y, d.z);
        }
        row
    };
    line(format!(
        "{} by {}: displacements (x, y, z) in the scene's unit of length",
        scene.name,
        model.name()
    ));
    let names = scene
        .bodies
        .iter()
        .fold(format!("{:<first$}", "phase"), |h, b| {
            format!("{h}  {:<29}", b.name)
        });
    line(names);
    for (leg, name) in outcome.legs.iter().zip(&what).take(MOST_ROWS) {
        line(row(name, &leg.displacement));
    }
    if outcome.legs.len() > MOST_ROWS {
        line(format!(
            "... {} more phases in summary.json",
            outcome.legs.len() - MOST_ROWS
        ));
    }
    line(row("net", &outcome.displacement));
    let r = outcome.rotation.map(|x| (1e5 * x).round() / 1e5 + 0.0);
    line(format!(
        "rotation ({:.5}, {:.5}, {:.5}), work on the fluid {:.6}",
        r.x, r.y, r.z, outcome.work
    ));
    line(errors(&outcome.error_estimate));
    if !outcome.tolerance_met {
        let bar = outcome.error_estimate.integration.unwrap_or(0.0);
        line(format!(
            "warning: the integration errs by up to {bar:.1e} in a net displacement of {:.1e}, more than \
             model.tolerance = {:e} allows: lower it, or refine fem.surface_size if that does not help",
            outcome.net(),
            scene.model.tolerance,
        ));
    }
    if let (Some(target), Some(bar)) = (scene.fem.target, outcome.error_estimate.mesh)
        && bar > target * outcome.net()
    {
        line(format!(
            "warning: the mesh errs by up to {:.1e} of the net displacement, more than fem.target = {target:e} allows: lower fem.size_factor = {:.3}",
            bar / outcome.net(),
            scene.fem.size_factor.unwrap_or(1.0),
        ));
    }
    line(format!(
        "{} solves in {}",
        outcome.solves,
        duration(seconds)
    ));
    line(format!(
        "see {}",
        folder.path().join("trajectory.svg").display()
    ));
    text
}
