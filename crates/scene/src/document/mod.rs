//! A scene file as text: its keys, the line of each key, and the changes made by `--set`.

mod check;
mod places;

pub(crate) use check::is_in_range;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mesh::InputFile;
use serde::Serialize;
use toml::de::DeTable;
use toml::{Table, Value};

use crate::error::{SceneError, one_line};
use crate::keys::{self, join, without_indices};
use crate::material_motion::MaterialMotion;
use check::{check_table, check_value, is_link_value};
use places::{Places, place_in_file};

/// The keys and values of a scene, each with the place where it is written.
///
/// Paths look like `bodies[1].radius`. Every path is in the tables of [`keys`] and every value is
/// of the kind given there.
#[derive(Clone, Debug)]
pub struct Document {
    path: PathBuf,
    root: Value,
    places: Places,
    warnings: Vec<String>,
    /// Motions of a program, by the names of their bodies.
    motions: BTreeMap<String, Arc<dyn MaterialMotion>>,
}

/// Largest scene file or gait table in bytes; a hundred thousand phases or rows need a tenth of it.
pub(crate) const MAX_TEXT_FILE: u64 = 1 << 27;

/// One step from the root of a document to a value.
enum Step {
    Key(String),
    Entry(usize),
}

impl Document {
    /// Reads a file.
    ///
    /// # Errors
    /// A file that cannot be read, and as [`Document::parse`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let text = InputFile::read(path, MAX_TEXT_FILE).and_then(InputFile::into_text);
        let text = text.map_err(|source| SceneError::Read {
            path: path.to_owned(),
            source,
        })?;
        Self::parse(&text, path)
    }

    /// Parses the text of a file; `path` is used in messages and to find files named in it.
    ///
    /// # Errors
    /// Text that is not TOML, an unknown key, a value that is not of its key's kind.
    pub fn parse(text: &str, path: impl AsRef<Path>) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let name = path.display().to_string();
        let syntax = |error: toml::de::Error| SceneError::Syntax {
            place: place_in_file(&name, text, error.span().map_or(0, |span| span.start)),
            message: one_line(error.message()),
        };
        let spanned = DeTable::parse(text).map_err(syntax)?;
        let mut places = Places::from_table(name.clone(), text, spanned.get_ref());
        let mut table: Table = toml::from_str(text).map_err(syntax)?;
        let mut warnings = Vec::new();
        for (old, new) in keys::RENAMED {
            rename(&mut table, old, new, &mut places, &mut warnings)?;
        }
        check_table(&places, &table, "")?;
        Ok(Self {
            path: path.to_owned(),
            root: Value::Table(table),
            places,
            warnings,
            motions: BTreeMap::new(),
        })
    }

    /// Document of a scene made by a program; `origin` replaces the file name in messages.
    pub(crate) fn from_values(values: &impl Serialize, origin: &str) -> Result<Self, SceneError> {
        let places = Places::empty(origin.to_owned());
        let table = Table::try_from(values)?;
        check_table(&places, &table, "")?;
        Ok(Self {
            path: PathBuf::from(origin),
            root: Value::Table(table),
            places,
            warnings: Vec::new(),
            motions: BTreeMap::new(),
        })
    }

    /// The document with the motions of a program, by the names of their bodies.
    pub(crate) fn with_motions(self, motions: BTreeMap<String, Arc<dyn MaterialMotion>>) -> Self {
        Self { motions, ..self }
    }

    /// Motions of a program, by the names of their bodies.
    pub(crate) fn motions(&self) -> &BTreeMap<String, Arc<dyn MaterialMotion>> {
        &self.motions
    }

    /// Replaces those keys of a group whose values differ; `origin` becomes their place.
    ///
    /// `before` and `after` are the keys and values of the group, or a part of them.
    pub(crate) fn replace(
        &mut self,
        group: &str,
        before: &impl Serialize,
        after: &impl Serialize,
        origin: &str,
    ) -> Result<(), SceneError> {
        let (before, after) = (Table::try_from(before)?, Table::try_from(after)?);
        for (key, value) in &after {
            if before.get(key) != Some(value) {
                self.places.set(join(group, key), origin.to_owned());
            }
        }
        check_table(&self.places, &after, group)?;
        if let Value::Table(root) = &mut self.root {
            let values = root
                .entry(group)
                .or_insert_with(|| Value::Table(Table::new()));
            if let Value::Table(values) = values {
                values.retain(|key, _| !before.contains_key(key));
                values.extend(after);
            }
        }
        Ok(())
    }

    /// Overrides one key, such as `gait.cycles=3`, `bodies.left.radius=0.5`, `bodies.0.radius=0.5`.
    ///
    /// Entries of a list are chosen by name or by number from zero. A value that is not TOML is a
    /// text: `fem.solver=direct`.
    ///
    /// # Errors
    /// An assignment without `=`, an unknown key, an entry that does not exist, a value that is not
    /// of its key's kind.
    pub fn set(&mut self, assignment: &str) -> Result<(), SceneError> {
        self.set_at(assignment, &format!("--set {assignment}"))
    }

    /// Overrides one key as [`Document::set`]; `place` stands for file and line in messages.
    ///
    /// # Errors
    /// As [`Document::set`].
    pub fn set_at(&mut self, assignment: &str, place: &str) -> Result<(), SceneError> {
        let place = place.to_owned();
        let Some((key, value)) = assignment.split_once('=') else {
            return Err(SceneError::BadValue {
                place,
                key: assignment.to_owned(),
                problem: "has no value; write key=value".to_owned(),
            });
        };
        self.assign(key.trim(), parse_value(value.trim()), place, true)
    }

    /// The document with `place` instead of file and line in messages about any key, for the text
    /// of a program, whose lines no user can look at.
    #[must_use]
    pub fn located(mut self, place: &str) -> Self {
        self.places.set_all(place);
        self
    }

    /// Adds the value of a key that is written as for [`Document::set`], such as `fluid.viscosity`.
    ///
    /// # Errors
    /// As [`Document::set`]; a key that has a value already.
    pub fn add(&mut self, key: &str, value: Value) -> Result<(), SceneError> {
        self.assign(key, value, self.path.display().to_string(), false)
    }

    /// Sets a key to a value that is written at `place`.
    fn assign(
        &mut self,
        key: &str,
        value: Value,
        place: String,
        replaces: bool,
    ) -> Result<(), SceneError> {
        let mut key = key.to_owned();
        if let Some((old, new)) = keys::RENAMED.iter().find(|(old, _)| *old == key) {
            key = renamed(old, new);
            self.warnings.push(renaming(&place, old, &key));
        }
        let (path, steps) = match self.resolve(&key) {
            Ok((path, _)) if !replaces && self.has(&path) => {
                return Err(SceneError::BadValue {
                    place,
                    key: path,
                    problem: "is given twice; remove one of the two".to_owned(),
                });
            }
            Ok(found) => found,
            Err((key, problem)) => {
                return Err(SceneError::BadValue {
                    place,
                    key,
                    problem,
                });
            }
        };
        self.places.set(path.clone(), place);
        check_value(&self.places, &value, &path).map_err(|error| self.with_link_keys(error))?;
        let mut slot = &mut self.root;
        for step in steps {
            slot = match (slot, step) {
                (Value::Table(table), Step::Key(key)) => {
                    table.entry(key).or_insert(Value::Table(Table::new()))
                }
                (Value::Array(list), Step::Entry(index)) => &mut list[index],
                // The check against the table ensures that groups are tables and lists are lists.
                (slot, _) => slot,
            };
        }
        *slot = value;
        Ok(())
    }

    /// The full path of a key written as for [`Document::set`], such as `bodies[1].radius` of
    /// `bodies.centre.radius`; none for an entry that does not exist.
    pub fn full_path(&self, key: &str) -> Option<String> {
        Some(self.resolve(key).ok()?.0)
    }

    /// The full path of a key written as for `--set`, and the steps that lead to its value.
    ///
    /// On failure: the path as far as it exists, and the problem.
    fn resolve(&self, key: &str) -> Result<(String, Vec<Step>), (String, String)> {
        let mut segments = key
            .split(['.', '[', ']'])
            .filter(|segment| !segment.is_empty());
        let mut path = String::new();
        let mut steps = Vec::new();
        let mut value = Some(&self.root);
        while let Some(segment) = segments.next() {
            path = join(&path, segment);
            steps.push(Step::Key(segment.to_owned()));
            value = value.and_then(|value| value.get(segment));
            if !keys::is_group(&format!("{}[]", without_indices(&path))) {
                continue;
            }
            let list = value
                .and_then(Value::as_array)
                .map_or(&[][..], Vec::as_slice);
            let Some(entry) = segments.next() else { break };
            let Some(index) = find_entry(list, entry) else {
                return Err((path, no_such_entry(list, entry)));
            };
            path = format!("{path}[{index}]");
            steps.push(Step::Entry(index));
            value = list.get(index);
        }
        Ok((path, steps))
    }

    /// The error about an unknown key of a link, with the keys that give the values of this link.
    fn with_link_keys(&self, error: SceneError) -> SceneError {
        let SceneError::UnknownKey { place, key, remedy } = error else {
            return error;
        };
        let number = (key.strip_prefix("links["))
            .and_then(|rest| rest.split_once("]."))
            .and_then(|(number, name)| Some((number.parse().ok()?, name)));
        let keys = match number {
            Some((number, name)) if is_link_value(name) => self.keys_of_link(number),
            _ => Vec::new(),
        };
        let remedy = match keys.is_empty() {
            true => remedy,
            false => format!("{remedy}; here they are {}", keys.join(", ")),
        };
        SceneError::UnknownKey { place, key, remedy }
    }

    /// The keys that are written and give the values of a link: positions of its bodies, phases
    /// and harmonics.
    fn keys_of_link(&self, number: usize) -> Vec<String> {
        let list = |value: Option<&Value>| -> Vec<Value> {
            value.and_then(Value::as_array).cloned().unwrap_or_default()
        };
        let links = list(self.root.get("links"));
        let Some(link) = links.get(number) else {
            return Vec::new();
        };
        let text = |key: &str| link.get(key).and_then(Value::as_str);
        let mut keys: Vec<String> = ([text("body"), text("to")].into_iter().flatten())
            .map(|body| format!("bodies.{body}.position"))
            .collect();
        let gait = self.root.get("gait");
        let name = text("name");
        for (group, value_key) in [("phases", "length"), ("harmonics", "mean")] {
            let entries = list(gait.and_then(|gait| gait.get(group)));
            for (entry, values) in entries.iter().enumerate() {
                let is_own = name.is_some() && values.get("link").and_then(Value::as_str) == name;
                let targets = values.get("targets").zip(name);
                if is_own {
                    keys.push(format!("gait.{group}.{entry}.{value_key}"));
                } else if targets.is_some_and(|(targets, name)| targets.get(name).is_some()) {
                    keys.push(format!("gait.{group}.{entry}.targets"));
                }
            }
        }
        keys
    }

    /// Whether a key is written in the text or was set by an override.
    pub(crate) fn is_written(&self, path: &str) -> bool {
        self.places.has(path)
    }

    /// File and line of a key, or else of the nearest group around it.
    pub fn place(&self, path: &str) -> String {
        self.places.find(path)
    }

    /// Warnings to be shown to the user: about keys that have another name now, and, once a scene
    /// was read from the document, about its files and keys without effect.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Adds warnings about what the document names.
    pub(crate) fn warn(&mut self, warnings: Vec<String>) {
        // A document that is read again, with another value, keeps those it has.
        let new = |warning: &String| !self.warnings.contains(warning);
        let new: Vec<String> = warnings.into_iter().filter(new).collect();
        self.warnings.extend(new);
    }

    /// Whether a key such as `bodies[1].radius` has a value.
    pub(crate) fn has(&self, path: &str) -> bool {
        let mut segments = path.split(['.', '[', ']']).filter(|part| !part.is_empty());
        let value = segments.try_fold(&self.root, |value, segment| match value {
            Value::Array(list) => list.get(segment.parse::<usize>().ok()?),
            value => value.get(segment),
        });
        value.is_some()
    }

    /// Replaces all values, for keys that stand for others.
    pub(crate) fn replace_values(&mut self, values: Value) {
        self.root = values;
    }

    /// Removes a key of the first table, if it is there.
    pub(crate) fn remove(&mut self, key: &str) {
        if let Value::Table(root) = &mut self.root {
            root.remove(key);
        }
    }

    /// Sets the place of a key or a group.
    pub(crate) fn set_place(&mut self, path: String, place: String) {
        self.places.set(path, place);
    }

    /// The scene file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// All values in one table.
    pub fn values(&self) -> &Value {
        &self.root
    }
}

/// The new name of a key, whose last part alone has changed.
fn renamed(old: &str, new: &str) -> String {
    join(old.rsplit_once('.').map_or("", |(group, _)| group), new)
}

fn renaming(place: &str, old: &str, new: &str) -> String {
    format!("{place}: the key '{old}' is now '{new}'; rename it")
}

/// Moves the value of a key with an old name, whose groups are no lists, to its new name.
fn rename(
    table: &mut Table,
    old: &str,
    new: &str,
    places: &mut Places,
    warnings: &mut Vec<String>,
) -> Result<(), SceneError> {
    let (groups, last) = old.rsplit_once('.').unwrap_or(("", old));
    let mut group = Some(table);
    for name in groups.split('.').filter(|name| !name.is_empty()) {
        group = group.and_then(|table| table.get_mut(name)?.as_table_mut());
    }
    let Some((group, value)) = group.and_then(|g| g.remove(last).map(|value| (g, value))) else {
        return Ok(());
    };
    let (place, path) = (places.find(old), renamed(old, new));
    if group.insert(new.to_owned(), value).is_some() {
        return Err(SceneError::BadValue {
            place,
            key: old.to_owned(),
            problem: format!("is the old name of {path}, which is given too; remove one of them"),
        });
    }
    warnings.push(renaming(&place, old, &path));
    places.set(path, place);
    Ok(())
}

/// A TOML value, or the text itself if it is not TOML.
fn parse_value(text: &str) -> Value {
    let parsed: Option<Table> = toml::from_str(&format!("value = {text}")).ok();
    match parsed {
        Some(mut table) if table.len() == 1 => table
            .remove("value")
            .unwrap_or(Value::String(text.to_owned())),
        _ => Value::String(text.to_owned()),
    }
}

/// Position of the entry with this name, or else of this number.
fn find_entry(list: &[Value], entry: &str) -> Option<usize> {
    list.iter()
        .position(|value| value.get("name").and_then(Value::as_str) == Some(entry))
        .or_else(|| {
            entry
                .parse()
                .ok()
                .filter(|&index: &usize| index < list.len())
        })
}

fn no_such_entry(list: &[Value], entry: &str) -> String {
    let names: Vec<String> = list
        .iter()
        .enumerate()
        .map(|(index, value)| {
            value
                .get("name")
                .and_then(Value::as_str)
                .map_or(index.to_string(), str::to_owned)
        })
        .collect();
    match names.is_empty() {
        true => format!("has no entry '{entry}': the scene has none at all"),
        false => format!("has no entry '{entry}'; there are {}", names.join(", ")),
    }
}
