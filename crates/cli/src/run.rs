//! `swim run`: the simulation of the whole gait, and sensitivities of its net displacement.

use std::path::Path;

use design::sensitivities::Sensitivity;
use pictures::RunPictures;
use pictures::numbers::vector_with_bar;
use serde_json::json;
use swimmer::models::nalgebra::Vector3;
use swimmer::{Folder, InertiaNumbers, NoiseNumbers, Outcome, Report, Scene};

use super::arguments::RunArguments;
use super::design_files::{path_of, write};
use super::displacements::{displacement_table, swimmer_table};
use super::error::CliError;
use super::neglected::{self, inertia_words};
use super::progress::{DesignSpinner, RunBar, Waiting, watch_signals};
use super::text::{
    duration, entry, error, error_estimates, measured, open_gait, print, rotation_entry,
    solve_count, tolerance_statement, two_digits, warn, with_bar, with_uncertainty,
};
use super::view::{open_page, page_entry, write_movie};

pub fn run(arguments: RunArguments, quiet: bool) -> Result<String, CliError> {
    let scene = arguments.scene.read(quiet)?;
    let out = path_of(&scene, arguments.out);
    let mut progress = RunBar::new(&scene, watch_signals(), quiet);
    let report = swimmer::run(
        scene,
        &out,
        arguments.resume,
        &mut RunPictures::new(),
        &mut progress,
    );
    progress.finish();
    let mut report = report?;
    let stopped = report.stopped.take();
    let text = |movie: &str| match (arguments.json, quiet) {
        (true, _) => format!("{}\n", report.summary()),
        (false, true) => net_displacement(&report.outcome),
        (false, false) => describe(&report, &out) + movie,
    };
    if let Some(stopped) = stopped {
        print(&text(""))?;
        return Err(stopped.into());
    }
    if let Err(missed) = report.check_tolerance() {
        print(&text(""))?;
        return Err(missed.into());
    }
    for warning in warnings(&report) {
        warn(&warning);
    }
    // What fails after the run does not lose its numbers.
    let printed = |error: CliError| match print(&text("")) {
        Ok(()) => error,
        Err(unprinted) => unprinted,
    };
    let movie = match arguments.movie {
        true => {
            let _waiting = Waiting::new("drawing the movie", quiet);
            write_movie(&out).map_err(printed)?
        }
        false => String::new(),
    };
    if arguments.open {
        open_page(&out);
    }
    if !arguments.sensitivities {
        return Ok(text(&movie));
    }
    let found = sensitivities(&report.scene, &out, quiet).map_err(printed)?;
    if arguments.json {
        let mut summary = report.summary();
        summary["sensitivities"] = json!(found);
        return Ok(format!("{summary}\n"));
    }
    Ok(text(&movie) + &describe_sensitivities(&found))
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

/// The line of the error bar of the rotation, of one that is larger than its bar.
fn rotation_error(outcome: &Outcome) -> String {
    let (angle, bar) = (outcome.rotation.norm(), outcome.rotation_error.total());
    match angle > bar && bar > 0.0 {
        true => entry("error of rotation", error(bar, angle)),
        false => String::new(),
    }
}

/// Rounding of mean loads, relative to the largest: sums of loads that nearly cancel.
const MEAN_ROUNDING: f64 = 1e-12;

/// Mean force and torque on each body whose velocity is given, with their error bars.
fn mean_holding(scene: &Scene, outcome: &Outcome) -> String {
    let Some(means) = outcome.mean_holding() else {
        return String::new();
    };
    let bars = [&means.force_error, &means.torque_error];
    let is_estimated = bars.iter().any(|bars| bars.estimated().is_some());
    let [force, torque] = bars.map(|bars| bars.total());
    let sizes = (means.bodies.iter()).map(|load| load.force.norm().max(load.torque.norm()));
    let rounding = MEAN_ROUNDING * sizes.fold(0.0, f64::max);
    let line = |label: &str, vector: &Vector3<f64>, bar: f64| {
        let bar = is_estimated.then_some(bar);
        entry(label, vector_with_bar((*vector).into(), bar, rounding))
    };
    let mut text = String::new();
    for load in &means.bodies {
        text += &entry("mean loads on", &scene.bodies()[load.body].name);
        text += &line("  force", &load.force, force);
        text += &line("  torque", &load.torque, torque);
    }
    text
}

/// Mean flow and pressure gradient of a periodic box, the one that is not given with its error bar.
fn mean_flow(scene: &Scene, outcome: &Outcome) -> String {
    let Some(mean) = outcome.mean_flow() else {
        return String::new();
    };
    let (flow, bar) = (&mean.flow, mean.error.estimated());
    let finds_flow = scene.finds_mean_flow();
    let line = |label: &str, vector: &Vector3<f64>, is_found: bool| {
        let words = match is_found {
            true => vector_with_bar((*vector).into(), bar, MEAN_ROUNDING * vector.norm()),
            false => format!("({}, {}, {}), given", vector.x, vector.y, vector.z),
        };
        entry(label, words)
    };
    line("mean flow", &flow.velocity, finds_flow)
        + &line("pressure gradient", &flow.pressure_gradient, !finds_flow)
}

/// Forces of the bodies by added mass at the end, and torques where bodies turn, in fluids with
/// inertia.
fn added_mass(scene: &Scene, outcome: &Outcome) -> String {
    let Some(added_mass) = outcome.added_mass() else {
        return String::new();
    };
    let sizes = added_mass.bodies.iter().flatten();
    let largest = sizes.fold(0.0_f64, |m, load| m.max(load.norm()));
    let line = |label: &str, vector: &Vector3<f64>, part: usize| {
        let bar = added_mass.mesh_error.map(|bars| bars[part]);
        let rounding = MEAN_ROUNDING * largest;
        entry(label, vector_with_bar((*vector).into(), bar, rounding))
    };
    let mut text = String::new();
    for (body, [force, torque]) in scene.bodies().iter().zip(&added_mass.bodies) {
        if !body.shape.has_surface() {
            continue;
        }
        text += &entry("added mass, at the end", &body.name);
        text += &line("  force", force, 0);
        if torque.norm() > MEAN_ROUNDING * largest {
            text += &line("  torque", torque, 1);
        }
    }
    text
}

/// What flat facets from files leave out, if they stand for smooth surfaces.
fn facet_errors(scene: &Scene) -> String {
    let of_body = |(body, error): (usize, f64)| {
        let (name, percent) = (&scene.bodies()[body].name, two_digits(100.0 * error));
        entry(
            "facets",
            format!(
                "size of {name} {percent} % from that of the smooth surface through its vertices; \
                 no error bar contains it"
            ),
        )
    };
    scene.facet_errors().into_iter().map(of_body).collect()
}

/// Lighthill's efficiency of a run that swam.
fn efficiency(report: &Report) -> String {
    let Some(found) = &report.efficiency else {
        return String::new();
    };
    entry("Lighthill efficiency", with_bar(found.value, found.error))
}

fn net_displacement(outcome: &Outcome) -> String {
    let bar = outcome.error_estimate.total();
    measured("net displacement", outcome.resolved_net(), bar)
}

fn describe(report: &Report, out: &Path) -> String {
    let outcome = &report.outcome;
    let net = outcome.resolved_net();
    let cost = format!("{}, {}", solve_count(outcome), duration(report.seconds));
    let bars = &outcome.error_estimate;
    let limit = report.scene.model().tolerance;
    let is_plain = bars.total() <= limit * outcome.reference_displacement();
    let tolerance = match outcome.tolerance_met && !is_plain {
        true => entry("tolerance", tolerance_statement(outcome, limit)),
        false => String::new(),
    };
    let open = open_gait(&report.scene, outcome);
    let open = open.map_or(String::new(), |[shape, rigid]| {
        entry("shape", shape) + &entry("rigid part", rigid)
    });
    let repulsion = report.scene.repulsion();
    let repulsion = repulsion.map_or(String::new(), |repulsion| {
        let (range, strength) = (repulsion.range, repulsion.strength);
        entry(
            "repulsion",
            format!("of surfaces that nearly touch, range {range}, strength {strength}"),
        )
    });
    let noise = NoiseNumbers::new(&report.scene).ok().flatten();
    let noise = noise.zip(report.scene.noise());
    let noise = noise.map_or(String::new(), |(numbers, noise)| {
        let (energy, seed, step) = (noise.energy, noise.seed, numbers.time_step);
        let diffusion = numbers.diffusion;
        entry(
            "thermal noise",
            format!(
                "energy {energy:.3e}, seed {seed}, steps of {step:.3e}, diffusion of the first \
                 sphere {diffusion:.3e}; one realisation, whose spread no error bar contains"
            ),
        )
    });
    let inertia = InertiaNumbers::new(&report.scene, outcome);
    let inertia = inertia.map_or(String::new(), |numbers| {
        let terms = report.scene.inertia().kind.word();
        entry("inertia", format!("{terms}, {}", inertia_words(&numbers)))
    });
    let periodic = outcome.periodic_start.map_or(String::new(), |start| {
        let (cycles, remainder) = (start.cycles, start.remainder.displacement);
        let text = format!("after {cycles} cycles; of the start remains {remainder:.1e} per cycle");
        entry("periodic start", text)
    });
    let energy = outcome.kinetic_energy().map_or(String::new(), |energy| {
        // Errors of steps are not estimated.
        let [fluid, bodies] = [energy.fluid, energy.bodies].map(two_digits);
        entry(
            "kinetic energy",
            format!("fluid {fluid}, bodies {bodies}, at the end"),
        )
    });
    let reached = outcome.samples.last().map_or(0.0, |sample| sample.time);
    let stopped = match outcome.stopped {
        Some(_) => entry(
            "stopped",
            format!("at time {reached} of {}", report.scene.gait().duration()),
        ),
        None => String::new(),
    };
    entry("scene", report.scene.name())
        + &entry("model", report.model)
        + "\n"
        + &displacement_table(&report.scene, outcome)
        + &swimmer_table(&report.scene, outcome)
        + "\n"
        + &net_displacement(outcome)
        + &open
        + &noise
        + &repulsion
        + &inertia
        + &periodic
        + &energy
        + &added_mass(&report.scene, outcome)
        + &error_estimates("error estimate", bars, net, "the net displacement")
        + &rotation_entry(
            "rotation vector",
            &outcome.rotation,
            outcome.rotation_error.total(),
        )
        + &rotation_error(outcome)
        + &measured(
            "work on the fluid",
            outcome.work,
            outcome.work_error.total(),
        )
        + &efficiency(report)
        + &mean_holding(&report.scene, outcome)
        + &mean_flow(&report.scene, outcome)
        + &facet_errors(&report.scene)
        + &tolerance
        + &neglected::of_run(report)
        + &stopped
        + &entry("cost", cost)
        + &entry("results", out.display())
        + &page_entry(out)
}

/// Computes the sensitivities and writes `sensitivities.csv`.
fn sensitivities(scene: &Scene, out: &Path, quiet: bool) -> Result<Vec<Sensitivity>, CliError> {
    let found = design::sensitivities::sensitivities(scene, &mut DesignSpinner::new(quiet))?;
    let mut csv = "parameter,value,derivative,error\n".to_owned();
    for sensitivity in &found {
        let (parameter, derivative) = (&sensitivity.parameter, sensitivity.derivative);
        // Quotes in a quoted field are doubled.
        let name = parameter.name.replace('"', "\"\"");
        csv += &format!(
            "\"{name}\",{:?},{derivative:?},{:?}\n",
            parameter.value, sensitivity.error
        );
    }
    let folder = Folder::create(out)?;
    let _lock = folder.lock()?;
    write(&folder, "sensitivities.csv", &csv)?;
    Ok(found)
}

/// The sensitivities as text.
fn describe_sensitivities(found: &[Sensitivity]) -> String {
    let mut text = "\nderivative of the net displacement by\n".to_owned();
    for sensitivity in found {
        let parameter = &sensitivity.parameter;
        text += &format!(
            "  {:<38} {}\n",
            format!("{} = {}", parameter.name, parameter.value),
            with_uncertainty(sensitivity.derivative, sensitivity.error)
        );
    }
    text
}
