//! `swim optimise`: the best stroke.

use std::path::Path;

use design::{DesignedStroke, StrokeCurve, StrokeTotals, design_stroke, gait_shapes};
use serde_json::{Value, json};
use swimmer::Scene;
use swimmer::scene::ObjectiveKind;

use super::arguments::DesignArguments;
use super::design_files::{
    folder_of, gait_entries, names, table_entries, table_warning, write, write_map,
};
use super::design_progress::Progress;
use super::error::CliError;
use super::text::{
    NO_ESTIMATE, count, duration, entry, percent, two_digits, warn, with_uncertainty,
};

pub fn optimise(arguments: DesignArguments, quiet: bool) -> Result<String, CliError> {
    let DesignArguments { scene, out, json } = arguments;
    let scene = scene.read()?;
    let clock = std::time::Instant::now();
    let folder = folder_of(&scene, out)?;
    let found = design_stroke(&scene, folder.path(), &mut Progress::new(quiet))?;
    let names = names(&scene, &found.limits);
    let curve: Vec<Vec<f64>> = (found.shapes.iter())
        .map(|shape| found.limits.moving(shape))
        .collect();
    write_map(
        &folder,
        "optimum.svg",
        &found.table.geometry,
        &names,
        &curve,
    )?;
    for warning in warnings(&scene, &found) {
        warn(&warning);
    }
    let answer = optimum_json(&found);
    write(&folder, "optimum.json", &format!("{answer:#}\n"))?;
    if json {
        return Ok(format!("{answer}\n"));
    }
    Ok(describe(
        &scene,
        &found,
        &gait_shapes(&scene, &found.limits)?,
        folder.path(),
        clock.elapsed().as_secs_f64(),
    ))
}

fn warnings(scene: &Scene, found: &DesignedStroke) -> Vec<String> {
    let (options, optimum) = (scene.optimise(), &found.optimum);
    let mut warnings: Vec<String> = table_warning(&found.table).into_iter().collect();
    if optimum.refinement_error > options.tolerance {
        warnings.push(format!(
            "optimise.tolerance = {:e} was requested, and the last increase of the number of terms \
             or corners to {} changed the objective by {}; increase optimise.terms",
            options.tolerance,
            optimum.curve.terms(),
            two_digits(optimum.refinement_error),
        ));
    }
    if optimum.at_limits && options.objective != ObjectiveKind::Displacement {
        warnings.push(
            "the optimum touches the limits of the joints: wider limits, or a smaller gap, give a \
             better stroke"
                .to_owned(),
        );
    }
    warnings
}

fn optimum_json(found: &DesignedStroke) -> Value {
    let optimum = &found.optimum;
    json!({
        "displacement": optimum.totals.displacement.norm(),
        "displacement_vector": optimum.totals.displacement.as_slice(),
        "rotation": optimum.totals.rotation.as_slice(),
        "energy": found.energy,
        "period": found.period,
        "displacement_per_time": optimum.totals.displacement.norm() / found.period,
        "max_rate": found.peaks.rates,
        "max_power": found.peaks.power,
        "period_energy_product": optimum.period_energy_product,
        "efficiency": found.efficiency,
        "terms": optimum.curve.terms(),
        "refinement_error": optimum.refinement_error,
        "at_limits": optimum.at_limits,
        "lengths": found.shapes,
        "table": {
            "model": found.table.model,
            "points": found.table.geometry.points(),
            "displacement_error": found.table_error,
            "errors": found.table.geometry.errors(),
            "position_error": found.table.geometry.position_error(),
        },
        "run": {
            "model": found.model,
            "displacement": found.run_displacement,
            "displacement_error": found.outcome.error_estimate.total(),
            "rotation": found.outcome.rotation.as_slice(),
            "energy": found.outcome.work,
            "energy_error": found.outcome.work_error.total(),
            "solves": found.outcome.solves,
        },
        "gait": found.gait.map(|(totals, product)| json!({
            "displacement": totals.displacement.norm(),
            "period_energy_product": product,
        })),
    })
}

/// Radius of the circle (of the helix, in space) through the positions after successive cycles: the
/// displacement is its chord for the angle of the rotation.
fn circle(totals: &StrokeTotals) -> f64 {
    let axis = totals.rotation.normalize();
    let across = totals.displacement - axis * axis.dot(&totals.displacement);
    across.norm() / (2.0 * (0.5 * totals.rotation.norm()).sin())
}

fn describe(
    scene: &Scene,
    found: &DesignedStroke,
    gait_shapes: &[Vec<f64>],
    out: &Path,
    seconds: f64,
) -> String {
    let (optimum, outcome) = (&found.optimum, &found.outcome);
    let mut text = entry("scene", scene.name());
    text += &entry("objective", scene.optimise().objective.word());
    text += &entry("model", found.model);
    text += &table_entries(&found.table);
    text += &entry(
        "search",
        &format!(
            "{}, {}, {}",
            count(optimum.starts, "start"),
            count(optimum.iterations, "iteration"),
            match optimum.curve {
                StrokeCurve::Polygon { .. } => count(optimum.curve.terms(), "corner"),
                StrokeCurve::Series { .. } =>
                    format!("{} per joint", count(optimum.curve.terms(), "term")),
            }
        ),
    );
    text += "\n";
    text += &entry(
        "displacement by table",
        &with_uncertainty(optimum.totals.displacement.norm(), found.table_error),
    );
    text += &entry(
        "  by the model",
        &with_uncertainty(found.run_displacement, outcome.error_estimate.total()),
    );
    let rotation = optimum.totals.rotation;
    if rotation.norm() > 1e-9 {
        text += &entry(
            "rotation vector",
            &format!(
                "({:.6}, {:.6}, {:.6}) rad",
                rotation.x, rotation.y, rotation.z
            ),
        );
        text += &entry(
            "heading",
            &format!(
                "turns by {:.4} degrees per cycle, on a circle of radius {:.4}",
                rotation.norm().to_degrees(),
                circle(&optimum.totals)
            ),
        );
    }
    text += &entry(
        "energy by table",
        &format!(
            "{:.6} in a period of {} {NO_ESTIMATE}",
            found.energy, found.period
        ),
    );
    text += &entry(
        "  by the model",
        &with_uncertainty(outcome.work, outcome.work_error.total()),
    );
    text += &entry(
        "displacement per time",
        &with_uncertainty(
            optimum.totals.displacement.norm() / found.period,
            found.table_error / found.period,
        ),
    );
    let rates = (found.peaks.rates.iter()).fold(0.0_f64, |largest, rate| largest.max(*rate));
    text += &entry(
        "largest rate, power",
        &format!("{rates:.6}, {:.6} {NO_ESTIMATE}", found.peaks.power),
    );
    text += &entry(
        "energy times period",
        &format!(
            "{:.6} at constant power {NO_ESTIMATE}",
            optimum.period_energy_product
        ),
    );
    text += &entry(
        "Lighthill efficiency",
        &format!("{:.4e} {NO_ESTIMATE}", found.efficiency),
    );
    text += &entry(
        "last refinement",
        &format!(
            "changed the objective by {}",
            percent(optimum.refinement_error)
        ),
    );
    if let Some(gait) = &found.gait {
        text += &gait_entries(&found.table, gait, gait_shapes);
    }
    text += "\n";
    text += &entry("time", &duration(seconds));
    text += &entry("results", &out.join("optimum.toml").display().to_string());
    text
}
