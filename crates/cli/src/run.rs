//! `swim run`: the simulation of the whole gait.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use pictures::RunPictures;
use signal_hook::consts::{SIGINT, SIGTERM};
use swimmer::Report;

use super::arguments::RunArguments;
use super::displacements::displacement_table;
use super::error::CliError;
use super::progress::Progress;
use super::sensitivities::{describe_sensitivities, sensitivities, sensitivities_json};
use super::text::{
    count, duration, entry, error_estimates, print, rounded, two_digits, warn, with_uncertainty,
};
use super::view::{open_page, page_entry, write_movie};

pub fn run(arguments: RunArguments, quiet: bool) -> Result<String, CliError> {
    let scene = arguments.scene.read()?;
    let out = (arguments.out).unwrap_or_else(|| PathBuf::from("out").join(scene.name()));
    let mut progress = Progress::new(&scene, watch_signals(), quiet);
    let report = swimmer::run(
        scene,
        &out,
        arguments.resume,
        &mut RunPictures::new(),
        &mut progress,
    );
    progress.finish();
    let text = |report: &Report| match arguments.json {
        true => format!("{}\n", report.summary()),
        false => describe(report, &out),
    };
    let report = report?;
    if let Err(missed) = report.check_tolerance() {
        print(&text(&report));
        return Err(missed.into());
    }
    for warning in warnings(&report) {
        warn(&warning);
    }
    let movie = match arguments.movie {
        true => write_movie(&out)?,
        false => String::new(),
    };
    let text = |report: &Report| match arguments.json {
        true => text(report),
        false => text(report) + &movie,
    };
    if arguments.open {
        open_page(&out);
    }
    if !arguments.sensitivities {
        return Ok(text(&report));
    }
    let found = sensitivities(&report.scene, &out, quiet)?;
    match arguments.json {
        true => {
            let mut summary = report.summary();
            summary["sensitivities"] = sensitivities_json(&found);
            Ok(format!("{summary}\n"))
        }
        false => Ok(text(&report) + &describe_sensitivities(&found)),
    }
}

/// A flag that the first Ctrl-C or termination signal sets; the second ends the program at once.
pub fn watch_signals() -> Arc<AtomicBool> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let register = || -> std::io::Result<()> {
        for signal in [SIGINT, SIGTERM] {
            // The order matters: the shutdown must read the flag before this signal sets it.
            signal_hook::flag::register_conditional_shutdown(signal, 130, interrupted.clone())?;
            signal_hook::flag::register(signal, interrupted.clone())?;
        }
        Ok(())
    };
    if let Err(error) = register() {
        warn(&format!(
            "cannot handle signals ({error}): Ctrl-C ends the run at once and the current phase \
             is lost; --resume continues with the last completed phase"
        ));
    }
    interrupted
}

/// The tolerances that were not met, with the remedies.
fn warnings(report: &Report) -> Vec<String> {
    let (scene, outcome) = (&report.scene, &report.outcome);
    let net = outcome.net();
    let mut warnings = Vec::new();
    if !outcome.tolerance_met {
        let tolerance = scene.model().tolerance;
        warnings.push(format!(
            "model.tolerance = {tolerance:e} allows an error bar of {} (absolute), {} was reached \
             at a net displacement of {}; increase model.tolerance",
            two_digits(outcome.allowed_error),
            two_digits(outcome.limited_error.unwrap_or(f64::INFINITY)),
            two_digits(net),
        ));
    }
    if let (Some(target), Some(error)) = (scene.fem().target, outcome.error_estimate.mesh)
        && error > target * outcome.reference_displacement()
    {
        warnings.push(format!(
            "fem.target = {target:e} allows a discretisation error of {} (absolute), the estimate \
             is {} at a net displacement of {}; reduce fem.size_factor = {:.3}",
            two_digits(target * outcome.reference_displacement()),
            two_digits(error),
            two_digits(net),
            scene.fem().size_factor.unwrap_or(1.0),
        ));
    }
    warnings
}

fn describe(report: &Report, out: &Path) -> String {
    let outcome = &report.outcome;
    let net = outcome.net();
    let rotation = outcome.rotation.map(|x| rounded(x, 5));
    let mut text = entry("scene", report.scene.name());
    text += &entry("model", report.model);
    text += "\n";
    text += &displacement_table(&report.scene, outcome);
    text += "\n";
    text += &entry(
        "net displacement",
        &with_uncertainty(net, outcome.error_estimate.total()),
    );
    text += &error_estimates(
        "error estimate",
        &outcome.error_estimate,
        net,
        "the net displacement",
    );
    text += &entry(
        "rotation vector",
        &format!(
            "({:.5}, {:.5}, {:.5}) rad",
            rotation.x, rotation.y, rotation.z
        ),
    );
    text += &entry(
        "work on the fluid",
        &with_uncertainty(outcome.work, outcome.work_error.total()),
    );
    text += &entry(
        "cost",
        &format!(
            "{}, {}",
            count(outcome.solves, "solve"),
            duration(report.seconds)
        ),
    );
    text += &entry("results", &out.display().to_string());
    text + &page_entry(out)
}
