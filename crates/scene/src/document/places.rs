//! Places (file and line) at which the keys of a scene file are written.

use std::collections::BTreeMap;

use toml::de::{DeTable, DeValue};

use crate::keys::join;

/// File and line of each key of a document, for messages.
#[derive(Clone, Debug)]
pub(super) struct Places {
    file: String,
    of_keys: BTreeMap<String, String>,
}

impl Places {
    /// Places of a document without lines: every key is at the name of the file.
    pub fn empty(file: String) -> Self {
        Self {
            file,
            of_keys: BTreeMap::new(),
        }
    }

    /// The places of all keys of a parsed text.
    pub fn from_table(file: String, text: &str, table: &DeTable) -> Self {
        let mut of_keys = BTreeMap::new();
        // Counting the lines again for each key of a long file takes longer than all else.
        let ends: Vec<usize> = (text.bytes().enumerate())
            .filter_map(|(at, byte)| (byte == b'\n').then_some(at))
            .collect();
        let line = |offset: usize| 1 + ends.partition_point(|&end| end < offset);
        let at = |offset: usize| format!("{file}:{}", line(offset));
        note_table(table, "", &at, &mut of_keys);
        Self { file, of_keys }
    }

    /// Whether a key is written.
    pub fn has(&self, path: &str) -> bool {
        self.of_keys.contains_key(path)
    }

    /// Place of a key, or else of the nearest group around it, or else the file.
    pub fn find(&self, path: &str) -> String {
        let mut path = path;
        loop {
            if let Some(place) = self.of_keys.get(path) {
                return place.clone();
            }
            match path.rfind(['.', '[']) {
                Some(end) => path = &path[..end],
                None => return self.file.clone(),
            }
        }
    }

    /// Gives all keys one place.
    pub fn set_all(&mut self, place: &str) {
        place.clone_into(&mut self.file);
        for of_key in self.of_keys.values_mut() {
            place.clone_into(of_key);
        }
    }

    /// Sets the place of a key.
    pub fn set(&mut self, path: String, place: String) {
        self.of_keys.insert(path, place);
    }
}

/// File and line of a byte of the text.
pub(super) fn place_in_file(file: &str, text: &str, offset: usize) -> String {
    let before = &text.as_bytes()[..offset.min(text.len())];
    let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count();
    format!("{file}:{line}")
}

fn note_table(
    table: &DeTable,
    group: &str,
    at: &impl Fn(usize) -> String,
    places: &mut BTreeMap<String, String>,
) {
    for (key, value) in table {
        let path = join(group, key.get_ref());
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
        DeValue::Table(table) => note_table(table, path, at, places),
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
