//! A scene file as text: which keys it has, on which lines, and what `--set` changed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};
use toml::{Table, Value};

use crate::error::SceneError;
use crate::keys::{self, Kind};

/// The keys and values of a scene, each with the place it was written at.
///
/// Paths look like `bodies[1].radius`. Every path is a key of [`keys::KEYS`] and every value of its kind.
#[derive(Clone, Debug)]
pub struct Document {
    path: PathBuf,
    root: Value,
    places: BTreeMap<String, String>,
}

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
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let text = std::fs::read_to_string(path).map_err(|source| SceneError::Read {
            path: path.to_owned(),
            source,
        })?;
        Self::parse(&text, path)
    }

    /// Takes the text of a file; `path` is used in messages and to find files named in it.
    ///
    /// # Errors
    /// Text that is not TOML, an unknown key, a value that is not of its key's kind.
    pub fn parse(text: &str, path: &Path) -> Result<Self, SceneError> {
        let at = |offset: usize| format!("{}:{}", path.display(), line_of(text, offset));
        let spanned = DeTable::parse(text).map_err(|error| SceneError::Syntax {
            place: at(error.span().map_or(0, |span| span.start)),
            message: one_line(error.message()),
        })?;
        let mut places = BTreeMap::new();
        note_places(spanned.get_ref(), "", &at, &mut places);
        let table: Table = toml::from_str(text).map_err(|error| SceneError::Syntax {
            place: at(error.span().map_or(0, |span| span.start)),
            message: one_line(error.message()),
        })?;
        let document = Self {
            path: path.to_owned(),
            root: Value::Table(table),
            places,
        };
        document
            .root
            .as_table()
            .into_iter()
            .try_for_each(|table| document.check_table(table, ""))?;
        Ok(document)
    }

    /// Overrides one key: `gait.cycles=3`, `bodies.left.radius=0.5`, `bodies.0.radius=0.5`, `fem.solver=direct`.
    ///
    /// Entries of a list are chosen by name or by number from zero; a value that is not TOML is a text.
    ///
    /// # Errors
    /// An assignment without `=`, an unknown key, an entry that does not exist, a value not of its key's kind.
    pub fn set(&mut self, assignment: &str) -> Result<(), SceneError> {
        let place = format!("--set {assignment}");
        let Some((key, value)) = assignment.split_once('=') else {
            return Err(SceneError::BadValue {
                place,
                key: assignment.to_owned(),
                problem: "has no value; write key=value".to_owned(),
            });
        };
        let value = parse_value(value.trim());
        let (path, steps) = match self.resolve(key.trim()) {
            Ok(found) => found,
            Err((key, problem)) => {
                return Err(SceneError::BadValue {
                    place,
                    key,
                    problem,
                });
            }
        };
        self.places.insert(path.clone(), place);
        self.check_value(&value, &path)?;
        let mut slot = &mut self.root;
        for step in steps {
            slot = match (slot, step) {
                (Value::Table(table), Step::Key(key)) => {
                    table.entry(key).or_insert(Value::Table(Table::new()))
                }
                (Value::Array(list), Step::Entry(index)) => &mut list[index],
                // The values were checked against the keys, so groups are tables and lists are lists.
                (slot, _) => slot,
            };
        }
        *slot = value;
        Ok(())
    }

    /// The full path of a key as `--set` writes it, and the steps that lead to its value.
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

    /// The file and line at which a key, or else the nearest group around it, is written.
    pub fn place(&self, path: &str) -> String {
        let mut path = path;
        loop {
            if let Some(place) = self.places.get(path) {
                return place.clone();
            }
            match path.rfind(['.', '[']) {
                Some(end) => path = &path[..end],
                None => return self.path.display().to_string(),
            }
        }
    }

    /// The scene file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// All values as they stand, in one table.
    pub fn values(&self) -> &Value {
        &self.root
    }

    fn check_table(&self, table: &Table, prefix: &str) -> Result<(), SceneError> {
        table
            .iter()
            .try_for_each(|(key, value)| self.check_value(value, &join(prefix, key)))
    }

    fn check_value(&self, value: &Value, path: &str) -> Result<(), SceneError> {
        let schema = without_indices(path);
        let bad = |problem: String| SceneError::BadValue {
            place: self.place(path),
            key: path.to_owned(),
            problem,
        };
        if let Some(key) = keys::find(&schema) {
            return check_kind(value, key.kind).map_err(bad);
        }
        if !keys::is_group(&schema) {
            return Err(self.unknown_key(path));
        }
        match value {
            Value::Table(table) if !keys::is_group(&format!("{schema}[]")) => {
                self.check_table(table, path)
            }
            Value::Array(list) if keys::is_group(&format!("{schema}[]")) => list
                .iter()
                .enumerate()
                .try_for_each(|(index, entry)| match entry {
                    Value::Table(table) => self.check_table(table, &format!("{path}[{index}]")),
                    _ => Err(bad(format!(
                        "must be a list of tables, written as [[{schema}]]"
                    ))),
                }),
            _ if keys::is_group(&format!("{schema}[]")) => Err(bad(format!(
                "must be a list of tables, written as [[{schema}]]"
            ))),
            _ => {
                let header = schema
                    .strip_suffix("[]")
                    .map_or(format!("[{schema}]"), |list| format!("[[{list}]]"));
                Err(bad(format!("must be a table, written as {header}")))
            }
        }
    }

    fn unknown_key(&self, path: &str) -> SceneError {
        let schema = without_indices(path);
        let (group, last) = schema.rsplit_once('.').unwrap_or(("", &schema));
        let here = keys::KEYS.iter().filter_map(|key| {
            let below = if group.is_empty() {
                key.path
            } else {
                key.path.strip_prefix(group)?.strip_prefix('.')?
            };
            below.split(['.', '[']).next()
        });
        let same_name = |key: &&keys::Key| key.path.rsplit('.').next() == Some(last);
        let remedy = if let Some(near) = keys::nearest(last, here.clone()) {
            format!("did you mean '{}'?", join(group, near))
        } else if let Some(elsewhere) = keys::KEYS.iter().find(same_name) {
            format!("did you mean '{}'?", elsewhere.path)
        } else {
            let mut known: Vec<&str> = here.collect();
            known.dedup();
            let place = if group.is_empty() { "a scene" } else { group };
            format!("{place} has {}", known.join(", "))
        };
        SceneError::UnknownKey {
            place: self.place(path),
            key: path.to_owned(),
            remedy,
        }
    }
}

fn check_kind(value: &Value, kind: Kind) -> Result<(), String> {
    let must = |what: &str| Err(format!("must be {what}, not {}", describe(value)));
    let number = |value: &Value| match value {
        Value::Float(x) => Some(*x).filter(|x| x.is_finite()),
        Value::Integer(i) => Some(*i as f64),
        _ => None,
    };
    let numbers = |accept: fn(f64) -> bool| match value {
        Value::Array(list) => list.len() == 3 && list.iter().all(|x| number(x).is_some_and(accept)),
        _ => false,
    };
    let full_text = |value: &Value| value.as_str().is_some_and(|text| !text.trim().is_empty());
    match kind {
        Kind::Positive if !number(value).is_some_and(|x| x > 0.0) => {
            must("a number greater than zero")
        }
        Kind::NonNegative if !number(value).is_some_and(|x| x >= 0.0) => {
            must("a number that is not negative")
        }
        Kind::Vector if !numbers(|_| true) => must("three numbers, such as [0, 0, 1]"),
        Kind::PositiveVector if !numbers(|x| x > 0.0) => must("three numbers greater than zero"),
        Kind::Count
            if !value
                .as_integer()
                .is_some_and(|n| n > 0 && u32::try_from(n).is_ok()) =>
        {
            must("a whole number of at least 1")
        }
        Kind::Flag if !value.is_bool() => must("true or false"),
        Kind::Text if !full_text(value) => must("a text that is not empty"),
        Kind::Texts
            if !value
                .as_array()
                .is_some_and(|list| list.iter().all(full_text)) =>
        {
            must("a list of texts that are not empty")
        }
        Kind::Word(words) => match value.as_str() {
            Some(word) if words.contains(&word) => Ok(()),
            Some(word) => Err(match keys::nearest(word, words.iter().copied()) {
                Some(near) => format!("cannot be \"{word}\"; did you mean \"{near}\"?"),
                None => format!("cannot be \"{word}\"; it is one of {}", words.join(", ")),
            }),
            None => must(&format!("one of {}", words.join(", "))),
        },
        _ => Ok(()),
    }
}

fn describe(value: &Value) -> String {
    match value {
        Value::String(text) if text.trim().is_empty() => "an empty text".to_owned(),
        Value::String(text) => format!("the text \"{}\"", one_line(text)),
        Value::Table(_) => "a table".to_owned(),
        Value::Array(list) if list.len() > 6 => format!("a list of {}", list.len()),
        value => one_line(&value.to_string()),
    }
}

fn parse_value(text: &str) -> Value {
    let parsed: Option<Table> = toml::from_str(&format!("value = {text}")).ok();
    match parsed {
        Some(mut table) if table.len() == 1 => table
            .remove("value")
            .unwrap_or(Value::String(text.to_owned())),
        _ => Value::String(text.to_owned()),
    }
}

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

fn note_places(
    table: &DeTable,
    prefix: &str,
    at: &impl Fn(usize) -> String,
    places: &mut BTreeMap<String, String>,
) {
    for (key, value) in table {
        let path = join(prefix, key.get_ref());
        places.insert(path.clone(), at(key.span().start));
        note_below(value.get_ref(), &path, at, places);
    }
}

fn note_below(
    value: &DeValue,
    path: &str,
    at: &impl Fn(usize) -> String,
    places: &mut BTreeMap<String, String>,
) {
    match value {
        DeValue::Table(table) => note_places(table, path, at, places),
        DeValue::Array(list) => {
            for (index, entry) in list.iter().enumerate() {
                let path = format!("{path}[{index}]");
                places.insert(path.clone(), at(entry.span().start));
                note_below(entry.get_ref(), &path, at, places);
            }
        }
        _ => {}
    }
}

fn join(prefix: &str, key: &str) -> String {
    if prefix.is_empty() {
        key.to_owned()
    } else {
        format!("{prefix}.{key}")
    }
}

/// `bodies[1].radius` becomes `bodies[].radius`, the form of [`keys::KEYS`].
fn without_indices(path: &str) -> String {
    let mut inside = false;
    path.chars()
        .filter(|&c| {
            inside = (inside || c == '[') && c != ']';
            !inside || c == '['
        })
        .collect()
}

fn line_of(text: &str, offset: usize) -> usize {
    1 + text.as_bytes()[..offset.min(text.len())]
        .iter()
        .filter(|&&byte| byte == b'\n')
        .count()
}

/// Messages are one line, whatever they quote, and of a readable length.
fn one_line(text: &str) -> String {
    const LONGEST: usize = 120;
    let flat: String = text
        .chars()
        .take(LONGEST)
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect();
    if text.chars().count() > LONGEST {
        flat + "…"
    } else {
        flat
    }
}
