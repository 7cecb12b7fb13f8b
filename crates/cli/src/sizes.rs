//! `swim sizes`: the best radii and arm lengths for a gait.

use design::{BestSizes, DesignError, SizeSlice, best_sizes, size_slices};
use pictures::{SliceCurve, size_slices_svg};

use super::arguments::DesignArguments;
use super::design_files::{csv, folder_of, write};
use super::error::CliError;
use super::progress::DesignSpinner;
use super::text::{entry, measured, warn, with_uncertainty};

pub fn sizes(arguments: DesignArguments, quiet: bool) -> Result<String, CliError> {
    let DesignArguments { scene, out, json } = arguments;
    let scene = scene.read(quiet)?;
    let (folder, _lock) = folder_of(&scene, out)?;
    let mut progress = DesignSpinner::new(quiet);
    let found = best_sizes(&scene, &mut progress)?;
    let toml = found.scene.to_toml_in(folder.path())?;
    write(&folder, "optimum.toml", &toml)?;
    write(&folder, "sizes.csv", &table(&found))?;
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
        return Ok(format!("{}\n", found.json()));
    }
    let mut text = entry("scene", scene.name());
    text += &entry("objective", objective);
    text += &entry("kept", kept(&found));
    text += &entry("runs", found.runs.len());
    text.push('\n');
    let sizes = found.parameters.iter().zip(&found.values);
    for ((parameter, value), error) in sizes.zip(&found.errors) {
        // At a limit the value is as exact as the limit.
        let value = match *error > 0.0 {
            true => with_uncertainty(*value, *error),
            false => format!("{value:.6}, the limit"),
        };
        let value = format!("{value}; in the scene {}", parameter.value);
        text += &entry(&parameter.name, value);
    }
    for limit in &found.at_limits {
        text += &entry("at a limit", limit);
    }
    text.push('\n');
    for (label, run) in [("best sizes", &found.best), ("scene", &found.before)] {
        text += &format!("{label}\n");
        text += &measured(
            "  net displacement",
            run.displacement,
            run.displacement_error,
        );
        text += &measured("  work on the fluid", run.work, run.work_error);
        text += &measured(
            "  Lighthill efficiency",
            run.efficiency,
            run.efficiency_error,
        );
    }
    text.push('\n');
    let path = folder.path().join("optimum.toml");
    Ok(text + &entry("results", path.display()))
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

fn table(found: &BestSizes) -> String {
    let names = found.parameters.iter().map(|p| p.name.replace('"', ""));
    let header: Vec<String> = names.chain(["objective".to_owned()]).collect();
    let rows = found.runs.iter();
    let rows = rows.map(|(values, objective)| [&values[..], &[*objective]].concat());
    csv(&header.join(","), rows)
}
