//! Comparison of mesh motions: largest moves, smallest gaps, closed cycles, time.

mod cases;
mod cut;
mod files;
mod incremental_map;
mod methods;
mod tables;

use std::path::Path;

use anyhow::Result;
pub use files::run as run_files;
use methods::runs;
use swimmer::scene::MeshMotionKind;
use swimmer::{Method, choose, simulate};

use crate::reference::STROKES;
use crate::scenes;
use crate::table::{Table, count, exp, fixed};

/// Element size on the spheres, in their radii.
const SIZE: f64 = 0.6;

/// Element size of the quick part.
const COARSE: f64 = 0.8;

/// Element size of the default stroke.
const STROKE_SIZE: f64 = 0.7;

/// Runs the study and writes `ale.md`, `ale.csv`, charts and pictures of meshes.
pub fn run(quick: bool, out: &Path) -> Result<()> {
    let size = if quick { COARSE } else { SIZE };
    let cases = cases::all(quick);
    let mut all = Vec::new();
    for case in &cases {
        all.extend(runs(case, size)?);
    }
    let strokes = if quick { None } else { Some(strokes()?) };
    tables::write(&cases, &all, strokes, size, out)
}

/// The default stroke with each mesh motion of the program.
fn strokes() -> Result<Table> {
    let mut table = Table::new([
        "fem.mesh_motion",
        "meshes",
        "solves",
        "net displacement",
        "error",
        "bar",
        "seconds for meshes",
        "seconds in total",
    ]);
    // Generated meshes are moved by one method: `auto` is the biharmonic one.
    let words = MeshMotionKind::WORDS.iter();
    for &motion in words.filter(|&&word| word != "auto") {
        eprintln!("default stroke, {motion}");
        let overrides = [
            format!("fem.mesh_motion={motion}"),
            format!("fem.surface_size={STROKE_SIZE}"),
            // Not every motion preserves symmetry planes; here all move the same mesh.
            "fem.symmetry=off".to_owned(),
        ];
        let scene = scenes::read("three-sphere.toml", &overrides)?;
        let mut model = choose(&scene)?.model;
        let outcome = simulate(&scene, model.as_mut(), Method::Collocation, &mut ())?;
        let net = outcome.displacement[1].x;
        table.push([
            motion.into(),
            count(outcome.meshes.len()),
            count(outcome.solves),
            fixed(net, 6),
            exp((net - STROKES[0].net).abs(), 1),
            exp(outcome.error_estimate.total(), 1),
            fixed(outcome.seconds.mesh, 1),
            fixed(outcome.seconds.total, 1),
        ]);
    }
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::methods::Way;
    use super::*;

    #[test]
    fn only_the_plain_laplace_motion_inverts_cells_in_a_large_step() {
        let cases = cases::all(true);
        let case = cases.iter().find(|case| case.key == "move-1").unwrap();
        for run in runs(case, COARSE).unwrap() {
            let is_complete = run.failed_at.is_none();
            let (method, way) = (run.method, run.way);
            assert_eq!(is_complete, method != "Laplace", "{method} {way:?}");
            assert!(way != Way::Reference || run.samples.len() <= 1);
        }
    }
}
