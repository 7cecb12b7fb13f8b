//! `swim frequency`: the frequency at which a gait moves farthest per cycle.

use design::{BestFrequency, best_frequency};

use super::arguments::DesignArguments;
use super::design_files::{csv, folder_of, write};
use super::error::CliError;
use super::progress::DesignSpinner;
use super::text::{entry, measured, warn};

pub fn frequency(arguments: DesignArguments, quiet: bool) -> Result<String, CliError> {
    let DesignArguments { scene, out, json } = arguments;
    let scene = scene.read(quiet)?;
    let (folder, _lock) = folder_of(&scene, out)?;
    if !scene.starts_periodic() {
        warn(
            "gait.periodic is false: every run starts from the pose of the file, and the frequency \
             found is that of the first cycles; set gait.periodic = true for the periodic state",
        );
    }
    let found = best_frequency(&scene, &mut DesignSpinner::new(quiet))?;
    let rows = found.runs.iter();
    let rows = rows.map(|run| vec![run.frequency, run.displacement, run.error]);
    let table = csv("frequency,displacement,error", rows);
    write(&folder, "frequency.csv", &table)?;
    if json {
        return Ok(format!("{}\n", found.json()));
    }
    let BestFrequency {
        best,
        frequency_error,
        runs,
        ..
    } = found;
    let period = 1.0 / best.frequency;
    let relative = frequency_error / best.frequency;
    Ok(entry("scene", scene.name())
        + &measured("best frequency", best.frequency, frequency_error)
        + &measured("period", period, relative * period)
        + &measured("net displacement", best.displacement, best.error)
        + &entry("runs", runs.len())
        + &entry("results", folder.path().display()))
}
