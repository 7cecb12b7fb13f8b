//! Errors of a scene file with file, line and key.

use crate::document::Document;
use crate::error::SceneError;
use crate::nearest::find_name;

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

    /// Position of `name` in a list of names; `kind` names the items of the list, such as "body".
    pub fn find<'n>(
        &self,
        key: &str,
        name: &str,
        kind: &str,
        names: impl Iterator<Item = &'n str> + Clone,
    ) -> Result<usize, SceneError> {
        find_name(name, kind, names).map_err(|problem| self.bad_value(key, problem))
    }
}
