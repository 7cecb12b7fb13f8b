//! `swim run`: the whole gait.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use signal_hook::consts::{SIGINT, SIGTERM};
use swimmer::{Report, SwimError};

use super::progress::Progress;
use super::{SceneArguments, duration, errors, say};

pub fn run(
    arguments: &SceneArguments,
    out: Option<PathBuf>,
    resume: bool,
) -> Result<String, SwimError> {
    let scene = arguments.read()?;
    let out = out.unwrap_or_else(|| PathBuf::from("out").join(scene.name()));
    let mut progress = Progress::new(&scene, watch_signals());
    let report = swimmer::run(scene, &out, resume, &mut progress);
    progress.finish();
    Ok(describe(&report?, &out))
}

/// A flag that the first Ctrl-C or termination raises; the second one ends the program at once.
fn watch_signals() -> Arc<AtomicBool> {
    let raised = Arc::new(AtomicBool::new(false));
    let register = || -> std::io::Result<()> {
        for signal in [SIGINT, SIGTERM] {
            // In this order: the shutdown reads the flag before it is raised.
            signal_hook::flag::register_conditional_shutdown(signal, 130, raised.clone())?;
            signal_hook::flag::register(signal, raised.clone())?;
        }
        Ok(())
    };
    if let Err(error) = register() {
        say(&format!(
            "warning: signals cannot be watched ({error}): Ctrl-C ends the run at once, without its last phase"
        ));
    }
    raised
}

/// More rows than this are left out of the table; `summary.json` has them all.
const MOST_ROWS: usize = 24;

fn describe(report: &Report, out: &Path) -> String {
    let Report {
        scene,
        model,
        outcome,
        seconds,
        ..
    } = report;
    let mut text = String::new();
    let mut line = |content: String| {
        text.push_str(content.trim_end());
        text.push('\n');
    };
    let links = scene.articulation().links();
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
        scene.name(),
        model
    ));
    let names = scene
        .bodies()
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
            scene.model().tolerance,
        ));
    }
    if let (Some(target), Some(bar)) = (scene.fem().target, outcome.error_estimate.mesh)
        && bar > target * outcome.net()
    {
        line(format!(
            "warning: the mesh errs by up to {:.1e} of the net displacement, more than fem.target = {target:e} allows: lower fem.size_factor = {:.3}",
            bar / outcome.net(),
            scene.fem().size_factor.unwrap_or(1.0),
        ));
    }
    line(format!(
        "{} solves in {}",
        outcome.solves,
        duration(*seconds)
    ));
    line(format!("see {}", out.join("trajectory.svg").display()));
    text
}
