//! Files and lines that `swim map`, `swim optimise` and `swim learn` share.

use std::io::Write as _;
use std::path::PathBuf;

use swimmer::design::StrokeLimits;
use swimmer::models::ShapeGeometry;
use swimmer::output::Folder;
use swimmer::{Scene, SwimError};

use super::text::entry;

/// The folder of the results.
pub fn folder_of(scene: &Scene, out: Option<PathBuf>) -> Result<Folder, SwimError> {
    Folder::create(&out.unwrap_or_else(|| PathBuf::from("out").join(scene.name())))
}

/// Writes a file of text.
pub fn write(folder: &Folder, name: &str, text: &str) -> Result<(), SwimError> {
    folder.write(name, |file| file.write_all(text.as_bytes()))?;
    Ok(())
}

/// Names of the links that move.
pub fn names(scene: &Scene, limits: &StrokeLimits) -> Vec<String> {
    let links = scene.articulation().links();
    (limits.variables.iter())
        .map(|&k| links[k].name.clone())
        .collect()
}

/// Writes the height functions with a stroke, if two joints move and plots are built in.
pub fn write_map(
    folder: &Folder,
    name: &str,
    geometry: &ShapeGeometry,
    names: &[String],
    stroke: &[Vec<f64>],
) -> Result<(), SwimError> {
    #[cfg(feature = "plots")]
    if names.len() > 1 {
        let svg = swimmer::output::height_map_svg(geometry, names, stroke)?;
        write(folder, name, &svg)?;
    }
    #[cfg(not(feature = "plots"))]
    let _ = (folder, name, geometry, names, stroke);
    Ok(())
}

/// The line about a table.
pub fn table_entry(points: usize, degrees: &[usize], is_stored: bool) -> String {
    let degrees: Vec<String> = degrees.iter().map(ToString::to_string).collect();
    let source = if is_stored {
        ", read from the folder"
    } else {
        ""
    };
    entry(
        "table",
        &format!("{points} shapes, degrees {}{source}", degrees.join(" x ")),
    )
}
