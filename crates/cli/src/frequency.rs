//! `swim frequency`: the frequency at which a gait moves farthest per cycle.

use design::{BestFrequency, best_frequency};
use serde_json::{Value, json};

use super::arguments::DesignArguments;
use super::design_files::{folder_of, write};
use super::design_progress::Progress;
use super::error::CliError;
use super::text::{entry, warn, with_uncertainty};

pub fn frequency(arguments: DesignArguments, quiet: bool) -> Result<String, CliError> {
    let DesignArguments { scene, out, json } = arguments;
    let scene = scene.read()?;
    let folder = folder_of(&scene, out)?;
    if !scene.starts_periodic() {
        warn(
            "gait.periodic is false: every run starts from the pose of the file, and the frequency \
             found is that of the first cycles; set gait.periodic = true for the periodic state",
        );
    }
    let BestFrequency {
        best,
        frequency_error,
        runs,
    } = best_frequency(&scene, &mut Progress::new(quiet))?;
    let mut csv = "frequency,displacement,error\n".to_owned();
    for run in &runs {
        csv += &format!(
            "{:?},{:?},{:?}\n",
            run.frequency, run.displacement, run.error
        );
    }
    write(&folder, "frequency.csv", &csv)?;
    let relative = frequency_error / best.frequency;
    if json {
        let run = |run: &design::FrequencyRun| json!([run.frequency, run.displacement, run.error]);
        let runs: Vec<Value> = runs.iter().map(run).collect();
        let answer = json!({
            "frequency": best.frequency,
            "frequency_error": frequency_error,
            "period": 1.0 / best.frequency,
            "displacement": best.displacement,
            "displacement_error": best.error,
            "runs": runs,
        });
        return Ok(format!("{answer}\n"));
    }
    let period = 1.0 / best.frequency;
    let mut text = entry("scene", scene.name());
    text += &entry(
        "best frequency",
        &with_uncertainty(best.frequency, frequency_error),
    );
    text += &entry("period", &with_uncertainty(period, relative * period));
    text += &entry(
        "net displacement",
        &with_uncertainty(best.displacement, best.error),
    );
    text += &entry("runs", &runs.len().to_string());
    text += &entry("results", &folder.path().display().to_string());
    Ok(text)
}
