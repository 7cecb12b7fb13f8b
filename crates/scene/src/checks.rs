//! Errors of a scene file with file, line and key.

use rigid::Joint;

use crate::document::Document;
use crate::error::SceneError;
use crate::nearest::Names;

/// Builder of errors about the keys of a document, each with the place of its key.
pub(crate) struct Checks<'a>(pub &'a Document);

impl Checks<'_> {
    /// An error about the value of a key.
    pub fn bad_value(&self, key: &str, problem: impl Into<String>) -> SceneError {
        SceneError::BadValue {
            place: self.0.place(key),
            key: key.to_owned(),
            problem: problem.into(),
        }
    }

    /// The value of a key that must be present; `why` completes the sentence "... is missing".
    pub fn required<T>(&self, key: &str, value: Option<T>, why: &str) -> Result<T, SceneError> {
        value.ok_or_else(|| self.bad_value(key, format!("is missing{why}")))
    }

    /// Refuses keys of a group that are given and do not belong.
    ///
    /// `keys` are names, whether they are given, and whether they belong.
    pub fn refuse_strangers<const N: usize>(
        &self,
        group: &str,
        keys: [(&str, bool, bool); N],
        problem: &str,
    ) -> Result<(), SceneError> {
        match (keys.iter()).find(|(_, is_given, belongs)| *is_given && !belongs) {
            Some((name, ..)) => Err(self.bad_value(&format!("{group}.{name}"), problem)),
            None => Ok(()),
        }
    }

    /// Position of `name` in a list of names.
    pub fn find(&self, key: &str, name: &str, names: &Names) -> Result<usize, SceneError> {
        names
            .find(name)
            .map_err(|problem| self.bad_value(key, problem))
    }
}

/// Refuses a joint without a value, or with one that a drive determines.
pub(crate) fn check_prescribed(joint: &Joint) -> Result<(), String> {
    let problem = match (joint.kind.has_value(), joint.is_passive()) {
        (true, false) => return Ok(()),
        (true, true) => "is not prescribed: its drive determines the value",
        (false, _) => "has no value that a gait can change",
    };
    Err(format!(
        "names the link \"{}\", which {problem}",
        joint.name
    ))
}

/// Largest angle in radians: rounding errors of the rotation stay below 1e-10.
const LARGEST_ANGLE: f64 = 1e6;

/// Refuses an angle whose sine rounding errors determine.
pub(crate) fn check_angle(checks: &Checks, key: &str, angle: f64) -> Result<(), SceneError> {
    check_size(checks, key, "an angle", angle)
}

fn check_size(checks: &Checks, key: &str, what: &str, value: f64) -> Result<(), SceneError> {
    match value.abs() <= LARGEST_ANGLE {
        true => Ok(()),
        false => Err(checks.bad_value(
            key,
            format!("must be {what} of at most {LARGEST_ANGLE:e} in size, not {value:e}"),
        )),
    }
}

/// Refuses a length or a volume that is not positive; angles and amplitudes may have any sign.
pub(crate) fn check_value(
    checks: &Checks,
    key: &str,
    joint: &Joint,
    value: f64,
) -> Result<(), SceneError> {
    match joint.kind.is_signed() {
        true if joint.kind.is_angle() => check_angle(checks, key, value),
        // Amplitudes of modes, phases of waves and frames.
        true => check_size(checks, key, "a number", value),
        false if value > 0.0 => Ok(()),
        false => {
            let what = match joint.kind.length_power() {
                3 => "volume",
                _ => "length",
            };
            let problem = format!("must be a {what} greater than zero, not {value}");
            Err(checks.bad_value(key, problem))
        }
    }
}
