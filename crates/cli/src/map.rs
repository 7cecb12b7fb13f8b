//! `swim map`: the table over shapes, and what small strokes yield.

use design::{DesignError, StrokeLimits, stroke_map};
use serde_json::json;
use swimmer::SwimError;
use swimmer::models::{ModelError, TablePart};
use swimmer::output::Folder;

use super::arguments::{DesignArguments, MapArguments};
use super::design_files::{gait_entries, path_of, table_entries, table_warning, write_map};
use super::error::CliError;
use super::progress::DesignSpinner;
use super::text::{NO_ESTIMATE, entry, product, vector, warn};

pub fn map(arguments: MapArguments, quiet: bool) -> Result<String, CliError> {
    let part = arguments.part();
    let DesignArguments { scene, out, json } = arguments.design;
    let scene = scene.read(quiet)?;
    // Before a folder is made.
    StrokeLimits::from_scene(&scene)?;
    let folder = Folder::create(path_of(&scene, out))?;
    // Shares of one table are written into one folder at the same time, each into its own files.
    let _lock = match part {
        TablePart::Share { .. } => None,
        _ => Some(folder.lock()?),
    };
    let mut progress = DesignSpinner::new(quiet);
    let found = match stroke_map(&scene, (Some(&folder), part), &mut progress) {
        // The share is done, others are not.
        Err(DesignError::Swim(SwimError::Model(ModelError::MissingShapes { missing, points })))
            if part != TablePart::Known =>
        {
            return Ok(share_text(missing, &points, json));
        }
        found => found?,
    };
    if let Some(warning) = table_warning(&found.table) {
        warn(&warning);
    }
    let names = &found.names;
    write_map(
        &folder,
        "map.svg",
        &found.table.geometry,
        names,
        &found.stroke,
    )?;
    if json {
        return Ok(format!("{}\n", found.json()));
    }
    let mut text = entry("scene", scene.name()) + &entry("model", &found.table.model);
    text += &table_entries(&found.table);
    for (a, b, c) in &found.curvature {
        let (a, b, size) = (&names[*a], &names[*b], c.amax());
        text += &format!(
            "\ncurvature over {a} and {b} at the middle of the limits: displacement per area \
             {NO_ESTIMATE}\n"
        );
        let [moved, turned] = [0, 3].map(|k| vector([c[k], c[k + 1], c[k + 2]], size));
        text += &entry("  displacement", moved);
        text += &entry("  rotation vector", format!("{turned} rad"));
    }
    if let Some(gait) = &found.gait {
        text += &gait_entries(&found.table, gait, &found.stroke);
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
