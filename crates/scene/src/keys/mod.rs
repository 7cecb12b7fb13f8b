//! The keys of a scene file: their names, kinds of values, defaults and meanings.

mod key;
mod tables;

use std::fmt::Write as _;

pub(crate) use key::KeyType;
pub use key::{Key, KeyDefault, KeyTable, Kind, Words};
pub use tables::*;

/// Keys that have another name now, with the new last part of the name.
///
/// The old names are read as the new ones, with a warning ([`crate::Document::warnings`]).
pub(crate) const RENAMED: &[(&str, &str)] = &[("fem.mirror", "symmetry")];

/// All keys, in the order in which scenes are written.
pub fn all() -> impl Iterator<Item = &'static Key> + Clone {
    let keys = TABLES.iter().flat_map(|table| table.keys);
    keys.filter(|key| key.kind != Kind::Group)
}

/// The key with this path, written without indices.
pub fn find(path: &str) -> Option<&'static Key> {
    all().find(|key| key.path == path)
}

/// Whether the path is a group of keys.
pub fn is_group(path: &str) -> bool {
    all().any(|key| {
        key.path.starts_with(path)
            && matches!(key.path.as_bytes().get(path.len()), Some(b'.' | b'['))
    })
}

/// The path of a key below a group; the path of the root is empty.
pub(crate) fn join(group: &str, key: &str) -> String {
    match group {
        "" => key.to_owned(),
        _ => format!("{group}.{key}"),
    }
}

/// Removes the indices of a path: `bodies[1].radius` becomes `bodies[].radius`, as in the tables.
pub(crate) fn without_indices(path: &str) -> String {
    let mut inside = false;
    path.chars()
        .filter(|&c| {
            inside = (inside || c == '[') && c != ']';
            !inside || c == '['
        })
        .collect()
}

/// All keys in Markdown, with a heading per table, as in `docs/scene.md`.
pub fn markdown() -> String {
    TABLES
        .iter()
        .map(table_in_markdown)
        .collect::<Vec<_>>()
        .join("\n")
}

fn table_in_markdown(table: &KeyTable) -> String {
    let heading = match table.prefix.strip_suffix("[].") {
        Some(list) => format!("`[[{list}]]`"),
        None => match table.prefix.strip_suffix('.') {
            Some(group) => format!("`[{}]`", group.replace("[]", "")),
            None => "Top level".to_owned(),
        },
    };
    let mut text = format!("## {heading}\n\n{}\n\n", table.meaning);
    text += "| key | value | default | meaning |\n|---|---|---|---|\n";
    let mut words_of_keys = String::new();
    for key in table.keys.iter().filter(|key| key.kind != Kind::Group) {
        let name = &key.path[table.prefix.len()..];
        let value = match key.kind {
            Kind::Word(words) => {
                let _ = writeln!(words_of_keys, "\nThe words of `{name}`:\n");
                for (word, meaning) in words.words.iter().zip(words.meanings) {
                    // Writing to a string cannot fail.
                    let _ = writeln!(words_of_keys, "- `{word}`: {meaning}");
                }
                format!("`{}`", words.words.join("`, `"))
            }
            kind => kind.describe(),
        };
        let default = match key.default {
            KeyDefault::Value(value) => format!("`{value}`"),
            KeyDefault::Described(text) => text.to_owned(),
        };
        let _ = writeln!(text, "| `{name}` | {value} | {default} | {} |", key.meaning);
    }
    text + &words_of_keys
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_group_is_not_a_key() {
        assert!(is_group("fem") && is_group("gait.phases"));
        assert!(!is_group("fem.rtol") && !is_group("f"));
        assert!(find("bodies[].radius").is_some() && find("bodies").is_none());
    }

    #[test]
    fn serde_and_the_lists_of_words_agree() {
        check_words();
    }

    #[test]
    fn names_are_unique_and_complete() {
        for (number, key) in all().enumerate() {
            assert!(
                all().take(number).all(|other| other.path != key.path),
                "{}",
                key.path
            );
            assert!(!key.meaning.is_empty() && key.default != KeyDefault::Value(""));
        }
        // A table that no other one contains would not be read.
        for table in TABLES.iter().filter(|table| !table.prefix.is_empty()) {
            let path = table.prefix.trim_end_matches('.').trim_end_matches("[]");
            let mut groups = TABLES.iter().flat_map(|table| table.keys);
            assert!(
                groups.any(|key| key.kind == Kind::Group && key.path == path),
                "{path}"
            );
        }
        for (old, new) in RENAMED {
            let group = old.rsplit_once('.').map_or("", |(group, _)| group);
            assert!(
                find(old).is_none() && find(&join(group, new)).is_some(),
                "{old}"
            );
        }
    }
}
