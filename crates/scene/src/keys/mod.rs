//! The keys of a scene file: their names, kinds of values, defaults and meanings.

mod key;
mod of_bodies;
mod of_design;
mod of_gait;
mod path;
mod table;

use std::fmt::Write as _;

pub use key::{Key, KeyDefault, Kind};
pub(crate) use path::{join, without_indices};
pub use table::KEYS;

/// The key with this path, written without indices.
pub fn find(path: &str) -> Option<&'static Key> {
    KEYS.iter().find(|key| key.path == path)
}

/// Whether the path is a group of keys.
pub fn is_group(path: &str) -> bool {
    KEYS.iter().any(|key| {
        key.path.starts_with(path)
            && matches!(key.path.as_bytes().get(path.len()), Some(b'.' | b'['))
    })
}

/// The table of all keys in Markdown, as in `docs/scene.md`.
pub fn markdown_table() -> String {
    let mut text = "| key | value | default | meaning |\n|---|---|---|---|\n".to_owned();
    for key in KEYS {
        let value = match key.kind {
            Kind::Word(words) => format!("`{}`", words.join("`, `")),
            kind => kind.describe(),
        };
        let default = match key.default {
            KeyDefault::Value(value) => format!("`{value}`"),
            KeyDefault::Described(text) => text.to_owned(),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| `{}` | {value} | {default} | {} |",
            key.path, key.meaning
        );
    }
    text
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
}
