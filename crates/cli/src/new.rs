//! `swim new`: an example scene file.

use std::fs::OpenOptions;
use std::io::Write;
use std::path::PathBuf;

use swimmer::{SwimError, TEMPLATES};

use super::error::CliError;
use super::text::entry;

/// Writes an example scene to a file that must not exist yet.
pub fn new(name: &str, out: Option<PathBuf>) -> Result<String, CliError> {
    let Some((_, text)) = TEMPLATES.iter().find(|(known, _)| *known == name) else {
        let known: Vec<&str> = TEMPLATES.iter().map(|(known, _)| *known).collect();
        return Err(CliError::NotApplicable {
            place: format!("swim new {name}"),
            problem: format!("unknown example; choose one of {}", known.join(", ")),
        });
    };
    let path = out.unwrap_or_else(|| PathBuf::from(format!("{name}.toml")));
    OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(&path)
        .and_then(|mut file| file.write_all(text.as_bytes()))
        .map_err(|source| SwimError::Write {
            path: path.clone(),
            source,
        })?;
    let path = path.display();
    let command = match name {
        "optimal-stroke" => "optimise",
        "learning" => "learn",
        _ => "run",
    };
    Ok(entry("scene file", &path) + &entry("next", format!("swim {command} {path}")))
}
