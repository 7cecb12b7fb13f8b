//! Errors of scene files.

use std::path::PathBuf;

/// Defect of a scene, with its place and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A file that cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Text that is not TOML.
    #[error("{place}: not valid TOML: {message}")]
    Syntax {
        /// File and line.
        place: String,
        /// The parser's reason.
        message: String,
    },
    /// A key that scenes do not have.
    #[error("{place}: unknown key '{key}'; {remedy}")]
    UnknownKey {
        /// File and line, or the `--set` option that contains the key.
        place: String,
        /// The key.
        key: String,
        /// The nearest key, or the list of keys.
        remedy: String,
    },
    /// A value that is not valid for its key.
    #[error("{place}: {key} {problem}")]
    BadValue {
        /// File and line, or the `--set` option that contains the key.
        place: String,
        /// The key.
        key: String,
        /// The problem and its remedy.
        problem: String,
    },
    /// A body that touches its own image in a periodic box.
    #[error(
        "{place}: body '{body}' touches its own image in the periodic box: gap {gap:.6}; enlarge \
         domain.size or make it smaller"
    )]
    TouchingImage {
        /// Place in the scene file.
        place: String,
        /// Name of the body.
        body: String,
        /// Distance between the surfaces; negative where they overlap.
        gap: f64,
    },
    /// Bodies that touch or overlap.
    #[error(
        "{place}: bodies '{first}' and '{second}' touch or overlap {when}: gap {gap:.6}; {remedy}"
    )]
    Touching {
        /// File and line of the key to change.
        place: String,
        /// Name of one body.
        first: String,
        /// Name of the other body.
        second: String,
        /// Time of the contact in words: the initial configuration or a phase.
        when: String,
        /// Distance between the surfaces, not positive.
        gap: f64,
        /// The remedy.
        remedy: &'static str,
    },
    /// A body that is outside the domain or touches its wall.
    #[error(
        "{place}: body '{body}' is outside the domain or touches its wall: clearance {clearance:.6}; \
         move it inside, make it smaller or the domain larger"
    )]
    OutsideDomain {
        /// File and line of the body.
        place: String,
        /// The body.
        body: String,
        /// Distance from its surface to the wall, not positive.
        clearance: f64,
    },
    /// A command that does not fit the scene.
    #[error("{place}: {problem}")]
    NotApplicable {
        /// File and line.
        place: String,
        /// The missing or unsupported feature, and the remedy.
        problem: String,
    },
    /// A scene that cannot be written as TOML.
    #[error("the scene cannot be written as TOML: {0}")]
    Unwritable(#[from] toml::ser::Error),
    /// Bodies and joints that cannot be placed.
    #[error(transparent)]
    Rigid(#[from] rigid::RigidError),
}

/// One line of a readable length, for texts that messages quote.
pub(crate) fn one_line(text: &str) -> String {
    const MAX_CHARACTERS: usize = 120;
    let flat: String = text
        .chars()
        .take(MAX_CHARACTERS)
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect();
    if text.chars().count() > MAX_CHARACTERS {
        flat + "…"
    } else {
        flat
    }
}
