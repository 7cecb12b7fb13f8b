//! `swim sizes`: the best radii and arm lengths for a gait.

use design::{BestSizes, DesignError, SizeRun, SizeSlice, best_sizes, size_slices};
use pictures::{SliceCurve, size_slices_svg};
use serde_json::{Map, Value, json};

use super::arguments::DesignArguments;
use super::design_files::{folder_of, write};
use super::design_progress::Progress;
use super::error::CliError;
use super::text::{entry, warn, with_uncertainty};

pub fn sizes(arguments: DesignArguments, quiet: bool) -> Result<String, CliError> {
    let DesignArguments { scene, out, json } = arguments;
    let scene = scene.read()?;
    let folder = folder_of(&scene, out)?;
    let mut progress = Progress::new(quiet);
    let found = best_sizes(&scene, &mut progress)?;
    let toml = found.scene.to_toml_in(folder.path())?;
    write(&folder, "optimum.toml", &toml)?;
    write(&folder, "sizes.csv", &csv(&found))?;
    let objective = scene.optimise().objective.word();
    match size_slices(&scene, &found, &mut progress) {
        Ok(slices) => {
            let curve = |slice| curve(&found, slice);
            let curves: Vec<_> = slices.iter().map(curve).collect();
            let chart = size_slices_svg(&curves, objective)?;
            write(&folder, "sizes.svg", &chart)?;
        }
        Err(error @ DesignError::Stopped { .. }) => return Err(error.into()),
        // The best sizes are known and written.
        Err(error) => warn(&format!("sizes.svg was not drawn: {error}")),
    }
    drop(progress);
    if json {
        return Ok(format!("{}\n", answer(&found, objective)));
    }
    let mut text = entry("scene", scene.name());
    text += &entry("objective", objective);
    text += &entry("kept", &kept(&found));
    text += &entry("runs", &found.runs.len().to_string());
    text.push('\n');
    let sizes = found.parameters.iter().zip(&found.values);
    for ((parameter, value), error) in sizes.zip(&found.errors) {
        // At a limit the value is as exact as the limit.
        let value = match *error > 0.0 {
            true => with_uncertainty(*value, *error),
            false => format!("{value:.6}, the limit"),
        };
        let before = format!("{value}; in the scene {}", parameter.value);
        text += &entry(&parameter.name, &before);
    }
    for limit in &found.at_limits {
        text += &entry("at a limit", limit);
    }
    text.push('\n');
    for (label, run) in [("best sizes", &found.best), ("scene", &found.before)] {
        text += &format!("{label}\n");
        text += &entry(
            "  net displacement",
            &with_uncertainty(run.displacement, run.displacement_error),
        );
        text += &entry(
            "  work on the fluid",
            &with_uncertainty(run.work, run.work_error),
        );
        text += &entry(
            "  Lighthill efficiency",
            &with_uncertainty(run.efficiency, run.efficiency_error),
        );
    }
    text.push('\n');
    let path = folder.path().join("optimum.toml");
    text += &entry("results", &path.display().to_string());
    Ok(text)
}

/// A slice as it is drawn.
fn curve<'a>(found: &'a BestSizes, slice: &'a SizeSlice) -> SliceCurve<'a> {
    SliceCurve {
        name: &found.parameters[slice.parameter].name,
        values: &slice.values,
        objectives: &slice.objectives,
        errors: &slice.errors,
        best: slice.best,
    }
}

/// The sums that are the same in the scene and at the optimum.
fn kept(found: &BestSizes) -> String {
    let mut sums = Vec::new();
    for (first, words) in [
        ("radius", "volumes of the spheres"),
        ("length", "lengths of the arms"),
    ] {
        if found.parameters.iter().any(|p| p.name.starts_with(first)) {
            sums.push(format!("sum of the {words}"));
        }
    }
    sums.join(", ")
}

fn csv(found: &BestSizes) -> String {
    let names = found.parameters.iter().map(|p| p.name.replace('"', ""));
    let mut text = names
        .chain(["objective".to_owned()])
        .collect::<Vec<_>>()
        .join(",");
    text.push('\n');
    for (values, objective) in &found.runs {
        let row = values.iter().chain([objective]).map(|x| format!("{x:?}"));
        text += &row.collect::<Vec<_>>().join(",");
        text.push('\n');
    }
    text
}

fn answer(found: &BestSizes, objective: &str) -> Value {
    let run = |run: &SizeRun| {
        json!({
            "displacement": run.displacement,
            "displacement_error": run.displacement_error,
            "work": run.work,
            "work_error": run.work_error,
            "efficiency": run.efficiency,
            "efficiency_error": run.efficiency_error,
        })
    };
    let sizes = found
        .parameters
        .iter()
        .zip(&found.values)
        .zip(&found.errors);
    let sizes: Map<String, Value> = sizes
        .map(|((parameter, value), error)| {
            let size = json!({"value": value, "error": error, "scene": parameter.value});
            (parameter.name.clone(), size)
        })
        .collect();
    json!({
        "objective": objective,
        "sizes": sizes,
        "at_limits": found.at_limits,
        "best": run(&found.best),
        "scene": run(&found.before),
        "runs": found.runs.len(),
    })
}
