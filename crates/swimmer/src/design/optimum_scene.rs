//! The best stroke as a scene.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use scene::{ArmsKind, Document, Scene};

use super::limits::StrokeLimits;
use super::stroke_path::{Series, StrokeCurve};
use super::timing::Timing;
use crate::error::SwimError;
use crate::output::Folder;

/// Name of the scene file.
pub const SCENE_FILE: &str = "optimum.toml";

/// Name of the table of a stroke that is no Fourier series.
const TABLE_FILE: &str = "optimum.csv";

/// Writes the stroke as `optimum.toml` into a folder, and reads it back.
///
/// Fourier series at equal steps of time are written as harmonics. Strokes through a fixed start,
/// polygons and other timings are a table in `optimum.csv`.
///
/// # Errors
/// Files that cannot be written, or a scene in which bodies touch.
pub fn write(
    scene: &Scene,
    limits: &StrokeLimits,
    curve: &StrokeCurve,
    timing: &Timing,
    folder: &Folder,
) -> Result<Scene, SwimError> {
    let names: Vec<&str> = (limits.variables.iter())
        .map(|&k| &scene.articulation().links()[k].name[..])
        .collect();
    let gait = match curve {
        StrokeCurve::Series {
            series: Series::Closed { terms },
            coefficients,
        } if timing.is_uniform => harmonics(&names, coefficients, 2 * terms + 1, timing.period()),
        curve => {
            let interpolation = match curve {
                StrokeCurve::Polygon { .. } => "linear",
                StrokeCurve::Series { series, .. } => match series {
                    Series::Closed { .. } => "cubic",
                    Series::FromStart { .. } => "corner",
                },
            };
            let table = table(&names, curve, timing);
            folder.write(TABLE_FILE, |file| {
                std::io::Write::write_all(file, table.as_bytes())
            })?;
            format!(
                "{{ kind = \"table\", file = \"{TABLE_FILE}\", interpolation = \"{interpolation}\" }}"
            )
        }
    };
    let path = folder.path().join(SCENE_FILE);
    let mut document = Document::parse(&scene.to_toml()?, &path)?;
    let arms = ArmsKind::from(scene.articulation().arms()).word();
    document.set(&format!("gait={gait}"))?;
    document.set(&format!("gait.arms=\"{arms}\""))?;
    let found = Scene::from_document(document)?;
    // The table is named relative to the scene file.
    let text = found.to_toml()?.replace(
        &folder.path().join(TABLE_FILE).display().to_string(),
        TABLE_FILE,
    );
    folder.write(SCENE_FILE, |file| {
        std::io::Write::write_all(file, text.as_bytes())
    })?;
    Ok(Scene::read(&path, &[])?)
}

fn harmonics(names: &[&str], coefficients: &[f64], functions: usize, period: f64) -> String {
    let mut terms = Vec::new();
    for (name, c) in names.iter().zip(coefficients.chunks(functions)) {
        for (number, pair) in c[1..].chunks_exact(2).enumerate() {
            // a sin + b cos = r sin(. + φ), with r cos φ = a and r sin φ = b.
            let (amplitude, phase) = (pair[0].hypot(pair[1]), pair[1].atan2(pair[0]));
            if amplitude > f64::EPSILON * c[0].abs() {
                terms.push(format!(
                    "{{ link = {name:?}, mean = {:?}, amplitude = {amplitude:?}, phase = {:?}, \
                     order = {} }}",
                    c[0],
                    phase.rem_euclid(TAU),
                    number + 1
                ));
            }
        }
    }
    format!(
        "{{ period = {period:?}, harmonics = [{}] }}",
        terms.join(", ")
    )
}

fn table(names: &[&str], curve: &StrokeCurve, timing: &Timing) -> String {
    let mut text = format!("time,{}\n", names.join(","));
    for (&u, time) in timing.parameters.iter().zip(&timing.times) {
        // The last row is the first one to the last bit. Writing to a string cannot fail.
        let _ = write!(text, "{time:?}");
        for value in curve.shape(if u < 1.0 { u } else { 0.0 }) {
            let _ = write!(text, ",{value:?}");
        }
        text.push('\n');
    }
    text
}
