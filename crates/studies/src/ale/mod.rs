//! Comparison of mesh motions: largest moves, smallest gaps, closed cycles, time.

mod cases;
mod incremental_map;
mod methods;
mod tables;

use std::path::Path;

use anyhow::Result;
use methods::runs;

/// Element size on the spheres, in their radii.
const SIZE: f64 = 0.6;

/// Element size of the quick part.
const COARSE_SIZE: f64 = 0.8;

/// Runs the study and writes `ale.md`, `ale.csv`, charts and pictures of meshes.
pub fn run(quick: bool, out: &Path) -> Result<()> {
    let size = if quick { COARSE_SIZE } else { SIZE };
    let cases = cases::all(quick);
    let mut all = Vec::new();
    for case in &cases {
        all.extend(runs(case, size)?);
    }
    tables::write(&cases, &all, size, out)
}

#[cfg(test)]
mod tests {
    use super::methods::Way;
    use super::*;

    #[test]
    fn only_the_plain_laplace_motion_inverts_cells_in_a_large_step() {
        let cases = cases::all(true);
        let case = cases.iter().find(|case| case.key == "move-1").unwrap();
        for run in runs(case, COARSE_SIZE).unwrap() {
            let is_complete = run.failed_at.is_none();
            let (method, way) = (run.method, run.way);
            assert_eq!(is_complete, method != "Laplace", "{method} {way:?}");
            assert!(way != Way::Reference || run.samples.len() <= 1);
        }
    }
}
