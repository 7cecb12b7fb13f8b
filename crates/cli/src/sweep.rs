//! `swim sweep`: runs of a scene with other values of some keys.

use design::{RandomPoints, SweepOptions, SweepResult, SweepRow, VariedKey, require_sweep, sweep};
use pictures::{SweptPoints, direction_name, sweep_svg};
use swimmer::models::nalgebra::Vector3;

use super::arguments::SweepArguments;
use super::design_files::{folder_of, path_of, write};
use super::error::CliError;
use super::progress::DesignSpinner;
use super::text::{count, entry, printable, warn, with_bar};

/// Number of rows that are printed.
const PRINTED: usize = 20;

pub fn sweep_scene(arguments: SweepArguments, quiet: bool) -> Result<String, CliError> {
    let scene = arguments.scene.read(quiet)?;
    let keys: Vec<VariedKey> = (arguments.vary.iter())
        .map(|text| text.parse())
        .collect::<Result<_, _>>()?;
    if arguments.resume {
        require_sweep(&path_of(&scene, arguments.out.clone()))?;
    }
    let (folder, _lock) = folder_of(&scene, arguments.out)?;
    let random = arguments.random.map(|count| RandomPoints {
        count,
        seed: arguments.seed,
    });
    let options = SweepOptions {
        jobs: arguments.jobs,
        folder: Some(&folder),
        resume: arguments.resume,
    };
    let found = sweep(
        &scene,
        &keys,
        random,
        options,
        &mut DesignSpinner::new(quiet),
    )?;
    let results: Vec<(&[String], &SweepResult)> = (found.rows.iter())
        .filter_map(|row| Some((&row.values[..], row.result.as_ref().ok()?)))
        .collect();
    let failed = found.failed().count();
    if let (Some(row), true) = (found.failed().next(), results.is_empty()) {
        let problem = format!("no run has a result; the first one: {}", row.status());
        return Err(CliError::NotApplicable {
            place: folder.path().join("sweep.csv").display().to_string(),
            problem,
        });
    }
    // The plot has the component along the largest displacement.
    let displacements = results.iter().map(|(_, result)| result.displacement);
    let largest = displacements.max_by(|a, b| a.norm().total_cmp(&b.norm()));
    let direction = largest.and_then(|d| d.try_normalize(0.0));
    let direction = direction.unwrap_or_else(Vector3::x);
    // Along a coordinate, with negative displacements, rather than against it.
    let direction = direction * direction[direction.iamax()].signum();
    let along = |result: &SweepResult| result.displacement.dot(&direction);
    let points = SweptPoints {
        keys: &found.keys,
        points: results.iter().map(|(values, _)| *values).collect(),
        results: results.iter().map(|(_, result)| along(result)).collect(),
        bars: (results.iter())
            .map(|(_, result)| result.displacement_error.unwrap_or(0.0))
            .collect(),
        label: format!("net displacement along {}", direction_name(&direction)),
    };
    match sweep_svg(&points) {
        Ok(picture) => write(&folder, "sweep.svg", &picture)?,
        // Keys without numbers have no axis.
        Err(reason) => warn(&format!("no picture: {reason}")),
    }
    if failed > 0 {
        warn(&format!(
            "{failed} of {} runs failed; their reasons are in the column status of sweep.csv",
            found.rows.len()
        ));
    }
    if arguments.json {
        return Ok(format!("{}\n", found.json()));
    }
    let mut text = entry("scene", scene.name())
        + &entry("points", found.rows.len())
        + &entry("results", folder.path().display())
        + "\n";
    let head = printable(&found.keys.join(", "));
    let values = |row: &SweepRow| printable(&row.values.join(", "));
    let printed = || found.rows.iter().take(PRINTED);
    let width = printed().map(|row| values(row).chars().count());
    let width = 2 + width.fold(head.chars().count(), usize::max);
    text += &format!("{head:<width$}net displacement\n");
    for row in printed() {
        let values = format!("{:<width$}", values(row));
        let status = row.status();
        text += &match &row.result {
            Err(_) => format!("{values}{}\n", printable(&status)),
            Ok(result) => {
                let net = with_bar(along(result), result.displacement_error);
                match status == "met" {
                    true => format!("{values}{net}\n"),
                    false => format!("{values}{net}, {}\n", printable(&status)),
                }
            }
        };
    }
    if found.rows.len() > PRINTED {
        let more = count(found.rows.len() - PRINTED, "more row");
        text += &format!("{more} in sweep.csv\n");
    }
    Ok(text)
}
