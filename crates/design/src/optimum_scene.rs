//! The best stroke as a scene.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use scene::{ArmsKind, Document, Scene};

use super::limits::StrokeLimits;
use super::stroke_path::{Series, StrokeCurve};
use super::timing::Timing;
use crate::error::DesignError;
use swimmer::Folder;

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
) -> Result<Scene, DesignError> {
    let names: Vec<&str> = (limits.variables.iter())
        .map(|&k| &scene.articulation().joints()[k].name[..])
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
            folder.write(TABLE_FILE, |file| file.write_all(table.as_bytes()))?;
            format!(
                "{{ kind = \"table\", file = \"{TABLE_FILE}\", interpolation = \"{interpolation}\" }}"
            )
        }
    };
    let path = folder.path().join(SCENE_FILE);
    let mut document = Document::parse(&scene.to_toml_in(folder.path())?, &path)?;
    let arms = ArmsKind::from(scene.articulation().arms()).word();
    document.set(&format!("gait={gait}"))?;
    document.set(&format!("gait.arms=\"{arms}\""))?;
    let found = Scene::from_document(document)?;
    let text = found.to_toml_in(folder.path())?;
    folder.write(SCENE_FILE, |file| file.write_all(text.as_bytes()))?;
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

#[cfg(test)]
mod tests {
    use super::*;

    const CUBE: &str = "v -9 -9 -9\nv 9 -9 -9\nv 9 9 -9\nv -9 9 -9\nv -9 -9 9\nv 9 -9 9\n\
                        v 9 9 9\nv -9 9 9\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\n\
                        f 3 4 8 7\nf 1 5 8 4\n";

    /// Files of the scene are named relative to the folder of the optimum, and so is its table.
    #[test]
    fn the_scene_of_the_stroke_finds_its_files() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("cube.obj"), CUBE).unwrap();
        std::fs::write(at("gait.csv"), "time,arm\n0,4\n1,3\n2,4\n").unwrap();
        let text = "domain = { kind = \"surface\", file = \"cube.obj\", surface_kind = \"faceted\" }\n\
                    bodies = [{ name = \"a\", radius = 1, position = [-2, 0, 0] }, \
                    { name = \"b\", radius = 1, position = [2, 0, 0] }]\n\
                    links = [{ name = \"arm\", body = \"a\", to = \"b\" }]\n\
                    gait = { kind = \"table\", file = \"gait.csv\" }\n";
        std::fs::write(at("scene.toml"), text).unwrap();
        let scene = Scene::read(at("scene.toml"), &[]).unwrap();
        let limits = StrokeLimits::new(vec![(3.0, 4.0)]);
        let curve = StrokeCurve::Polygon {
            corners: vec![vec![3.0], vec![4.0]],
            times: vec![0.0, 0.5, 1.0],
        };
        let out = Folder::create(at("out/best")).unwrap();
        let timing = Timing::uniform(&curve, 2.0);
        let found = write(&scene, &limits, &curve, &timing, &out).unwrap();
        assert_eq!(found.articulation().initial_shape(), [3.0]);
        let text = std::fs::read_to_string(at("out/best/optimum.toml")).unwrap();
        assert!(
            text.contains("\"../../cube.obj\"") && text.contains("\"optimum.csv\""),
            "{text}"
        );
        let again = Scene::read(at("out/best/optimum.toml"), &[]).unwrap();
        assert!(again.differing_key(&found).is_none());
    }
}
