//! A run with its plots and its page, in a temporary folder.

use pictures::{REPORT_PAGE, RunPictures};
use swimmer::{Scene, run};

/// Simulates and prints what was found.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::builder()
        .sphere("left", 1.0, [0.0, 0.0, 0.0])
        .sphere("right", 1.0, [10.0, 0.0, 0.0])
        .slide("arm", "right", "left")
        .phase("arm", 6.0, 1.0)
        .build()?;
    let folder = tempfile::tempdir()?;
    let report = run(
        scene,
        folder.path(),
        false,
        &mut RunPictures::new(),
        &mut (),
    )?;
    let report = report.completed()?;
    report.check_tolerance()?;
    let page = std::fs::read_to_string(folder.path().join(REPORT_PAGE))?;
    println!("{REPORT_PAGE} has {} characters", page.len());
    assert!(folder.path().join("trajectory.svg").exists());
    Ok(())
}
