//! `swim map`: the table over shapes, and what small strokes yield.

use design::{DesignError, StrokeLimits, gait_shapes, gait_totals, tabulate};
use serde_json::{Value, json};
use swimmer::SwimError;
use swimmer::models::{ModelError, TablePart};
use swimmer::output::Folder;

use super::arguments::{DesignArguments, MapArguments};
use super::design_files::{gait_entries, names, path_of, table_entries, table_warning, write_map};
use super::error::CliError;
use super::progress::DesignSpinner;
use super::text::{NO_ESTIMATE, entry, product, vector, warn};

/// Relative error of the table.
const MAP_TOLERANCE: f64 = 1e-6;

pub fn map(arguments: MapArguments, quiet: bool) -> Result<String, CliError> {
    let part = arguments.part();
    let DesignArguments { scene, out, json } = arguments.design;
    let scene = scene.read()?;
    let limits = StrokeLimits::from_scene(&scene)?;
    let folder = Folder::create(path_of(&scene, out))?;
    // Shares of one table are written into one folder at the same time, each into its own files.
    let _lock = match part {
        TablePart::Share { .. } => None,
        _ => Some(folder.lock()?),
    };
    let mut progress = DesignSpinner::new(quiet);
    let place = (Some(&folder), part);
    let table = match tabulate(&scene, &limits, MAP_TOLERANCE, place, &mut progress) {
        // The share is done, others are not.
        Err(DesignError::Swim(SwimError::Model(ModelError::MissingShapes { missing, points })))
            if part != TablePart::Known =>
        {
            return Ok(share_text(missing, &points, json));
        }
        table => table?,
    };
    if let Some(warning) = table_warning(&table) {
        warn(&warning);
    }
    let geometry = &table.geometry;
    let names = names(&scene, &limits);
    let stroke = gait_shapes(&scene, &limits)?;
    write_map(&folder, "map.svg", geometry, &names, &stroke)?;
    let middle = geometry.ranges().iter().map(|r| 0.5 * (r.0 + r.1));
    let middle: Vec<f64> = middle.collect();
    let local = geometry.at(&middle)?;
    let mut squares = Vec::new();
    for first in 0..names.len() {
        for second in first + 1..names.len() {
            squares.push((first, second, local.curvature(first, second)));
        }
    }
    let gait = gait_totals(&scene, &limits, geometry)?;
    if json {
        let squares: Vec<Value> = (squares.iter())
            .map(|(a, b, c)| json!({ "links": [names[*a], names[*b]], "curvature": c.as_slice() }))
            .collect();
        let (interpolation, model) = geometry.errors();
        let answer = json!({
            "model": table.model,
            "links": names,
            "ranges": geometry.ranges(),
            "degrees": geometry.degrees(),
            "points": geometry.points(),
            "error_estimate": {
                "interpolation": interpolation,
                "model": model,
                "position": geometry.position_error(),
            },
            "middle": middle,
            "curvature": squares,
            "gait": gait.map(|(totals, product)| json!({
                "displacement": totals.displacement.as_slice(),
                "rotation": totals.rotation.as_slice(),
                "period_energy_product": product,
            })),
        });
        return Ok(format!("{answer}\n"));
    }
    let mut text = entry("scene", scene.name()) + &entry("model", &table.model);
    text += &table_entries(&table);
    for (a, b, c) in &squares {
        let (a, b, size) = (&names[*a], &names[*b], c.amax());
        text += &format!(
            "\ncurvature over {a} and {b} at the middle of the limits: displacement per area \
             {NO_ESTIMATE}\n"
        );
        let [moved, turned] = [0, 3].map(|k| vector([c[k], c[k + 1], c[k + 2]], size));
        text += &entry("  displacement", moved);
        text += &entry("  rotation vector", format!("{turned} rad"));
    }
    if let Some(gait) = &gait {
        text += &gait_entries(&table, gait, &stroke);
    }
    Ok(text + "\n" + &entry("results", folder.path().display()))
}

/// What remains after a share of the table.
fn share_text(missing: usize, points: &[usize], json: bool) -> String {
    if json {
        return format!("{}\n", json!({ "points": points, "missing": missing }));
    }
    let missing = format!(
        "{missing} shapes of other shares in the grid {}; when they are solved, run --merge",
        product(points)
    );
    entry("share", "solved") + &entry("missing", missing)
}
