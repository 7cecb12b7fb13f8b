//! The frequency at which a swimmer with a spring in one arm is fastest.

use design::best_frequency;
use swimmer::{Scene, TEMPLATES};

/// Simulates and prints what was found.
pub fn main() -> Result<(), design::DesignError> {
    let text = TEMPLATES.iter().find(|(name, _)| *name == "elastic-arm");
    let scene = Scene::parse(text.map_or("", |(_, text)| text))?;
    let found = best_frequency(&scene, &mut ())?;
    println!(
        "frequency {:.6} +- {:.1e}, net displacement {:.6}, {} runs",
        found.best.frequency,
        found.frequency_error,
        found.best.displacement,
        found.runs.len()
    );
    assert!(
        found
            .runs
            .iter()
            .all(|run| run.displacement <= found.best.displacement)
    );
    Ok(())
}
