//! Files and lines that `swim map`, `swim optimise` and `swim learn` share.

use std::path::PathBuf;

use design::{StrokeTable, StrokeTotals};
use swimmer::Scene;
use swimmer::models::ShapeGeometry;
use swimmer::output::{Folder, FolderLock};

use super::error::CliError;
use super::text::{NO_ESTIMATE, entry, measured, product, two_digits};

/// The folder of the results, by default that with the name of the scene.
pub fn path_of(scene: &Scene, out: Option<PathBuf>) -> PathBuf {
    out.unwrap_or_else(|| PathBuf::from("out").join(scene.name()))
}

/// The folder of the results of a design, reserved for this process until the lock is dropped.
pub fn folder_of(scene: &Scene, out: Option<PathBuf>) -> Result<(Folder, FolderLock), CliError> {
    let folder = Folder::create(path_of(scene, out))?;
    let lock = folder.lock()?;
    Ok((folder, lock))
}

/// Rows of numbers with all digits as comma-separated values below their header.
pub fn csv(header: &str, rows: impl Iterator<Item = Vec<f64>>) -> String {
    let row = |row: Vec<f64>| {
        let fields: Vec<String> = row.iter().map(|x| format!("{x:?}")).collect();
        fields.join(",") + "\n"
    };
    format!("{header}\n{}", rows.map(row).collect::<String>())
}

/// Writes a file of text.
pub fn write(folder: &Folder, name: &str, text: &str) -> Result<(), CliError> {
    folder.write(name, |file| file.write_all(text.as_bytes()))?;
    Ok(())
}

/// Writes the height functions with a stroke, if two joints move and plots are built in.
pub fn write_map(
    folder: &Folder,
    name: &str,
    geometry: &ShapeGeometry,
    names: &[String],
    stroke: &[Vec<f64>],
) -> Result<(), CliError> {
    if names.len() > 1 {
        let svg = pictures::height_map_svg(geometry, names, stroke)?;
        write(folder, name, &svg)?;
    }
    Ok(())
}

/// The warning about a table that ended before its tolerance.
pub fn table_warning(table: &StrokeTable) -> Option<String> {
    let geometry = &table.geometry;
    geometry.is_coarse().then(|| {
        format!(
            "the interpolation error of the table, {} per unit rate, is above its tolerance: the \
             next grid would be larger than tables may be; the table has {} shapes; take narrower \
             limits, or let fewer joints move",
            two_digits(geometry.errors().0),
            geometry.points(),
        )
    })
}

/// The lines about a table: its size, and its errors per unit rate.
pub fn table_entries(table: &StrokeTable) -> String {
    let geometry = &table.geometry;
    let source = match table.stored {
        0 => String::new(),
        stored => format!(", {stored} of them read from the folder"),
    };
    let (interpolation, model) = geometry.errors();
    let [interpolation, model] = [interpolation, model].map(two_digits);
    let mut errors = format!("interpolation {interpolation}, model {model}");
    if geometry.position_error() > 0.0 {
        let position = two_digits(geometry.position_error());
        errors += &format!(", place in the container {position}");
    }
    let (points, degrees) = (geometry.points(), product(geometry.degrees()));
    entry(
        "table",
        format!("{points} shapes, degrees {degrees}{source}"),
    ) + &entry("errors per unit rate", errors)
}

/// The lines about the gait of a scene: totals and energy times period by the table.
///
/// `shapes` are those along the gait.
pub fn gait_entries(
    table: &StrokeTable,
    (totals, product): &(StrokeTotals, f64),
    shapes: &[Vec<f64>],
) -> String {
    let error = table.displacement_error(shapes);
    let product = format!("{product:.6} at constant power {NO_ESTIMATE}");
    "\ngait of the scene, by the table\n".to_owned()
        + &measured("  displacement", totals.displacement.norm(), error)
        + &entry("  energy times period", product)
}
