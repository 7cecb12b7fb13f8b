//! `swim new`: a scene file to start from.

use std::fs::OpenOptions;
use std::io::Write;
use std::path::PathBuf;

use swimmer::SwimError;

/// Names and texts of the templates.
const TEMPLATES: [(&str, &str); 4] = [
    (
        "three-sphere",
        include_str!("../../templates/three-sphere.toml"),
    ),
    ("chain", include_str!("../../templates/chain.toml")),
    ("planar", include_str!("../../templates/planar.toml")),
    (
        "tetrahedral",
        include_str!("../../templates/tetrahedral.toml"),
    ),
];

/// Writes a template to a file that does not exist yet.
pub fn new(name: &str, out: Option<PathBuf>) -> Result<String, SwimError> {
    let Some((_, text)) = TEMPLATES.iter().find(|(known, _)| *known == name) else {
        let known: Vec<&str> = TEMPLATES.iter().map(|(known, _)| *known).collect();
        return Err(SwimError::NotApplicable {
            place: format!("swim new {name}"),
            problem: format!("there is no such template; there are {}", known.join(", ")),
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
    Ok(format!(
        "wrote {0}; run it with: swim run {0}\n",
        path.display()
    ))
}
