//! Comparison of mesh motions: largest moves, smallest gaps, closed cycles, time.

mod cases;
mod cut;
mod file_cases;
mod file_report;
mod file_study;
mod incremental_map;
mod methods;
mod report;
mod stroke;
mod study;

use std::path::Path;

use anyhow::Result;

/// Element size on the spheres, in their radii.
const SIZE: f64 = 0.6;

/// Element size of the quick part.
const COARSE: f64 = 0.8;

/// Element size of the default stroke.
const STROKE_SIZE: f64 = 0.7;

/// Runs the study on the Gmsh files of a folder and writes `ale-files.md`.
pub fn run_files(folder: &Path, out: &Path) -> Result<()> {
    let mut meshes = Vec::new();
    for path in file_cases::files(folder)? {
        let file = match file_cases::FileMesh::read(&path) {
            Ok(file) => file,
            Err(error) => {
                eprintln!("{}: skipped, {error:#}", path.display());
                continue;
            }
        };
        let mut rows = Vec::new();
        for method in &methods::METHODS {
            eprintln!("{}: {}", file.name, method.name);
            rows.extend(file_study::reach(&file, method)?);
        }
        meshes.push((file, rows));
    }
    let text = file_report::markdown(&meshes)?;
    println!("{text}");
    crate::folder::write(out, [("ale-files.md", text)])
}

/// Runs the study and writes `ale.md`, `ale.csv`, charts and pictures of meshes.
pub fn run(quick: bool, out: &Path) -> Result<()> {
    let size = if quick { COARSE } else { SIZE };
    let cases = cases::all(quick);
    let mut runs = Vec::new();
    for case in &cases {
        runs.extend(study::runs(case, size)?);
    }
    let strokes = if quick {
        Vec::new()
    } else {
        stroke::strokes(STROKE_SIZE)?
    };
    report::write(&cases, &runs, &strokes, size, out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ale::methods::Way;

    #[test]
    fn only_the_plain_laplace_motion_inverts_cells_in_a_large_step() {
        let cases = cases::all(true);
        let case = cases.iter().find(|case| case.key == "move-1").unwrap();
        for run in study::runs(case, COARSE).unwrap() {
            assert_eq!(
                run.complete,
                run.method != "Laplace",
                "{} {:?}",
                run.method,
                run.way
            );
            assert!(run.way != Way::Reference || run.samples.len() <= 1);
        }
    }
}
