//! Prints the table of all keys of a scene file in Markdown, as in `docs/scene.md`.

use scene::keys::{KEYS, markdown_table};

/// Prints the table.
pub fn main() {
    let table = markdown_table();
    print!("{table}");
    // Two lines of header, then one line per key.
    assert_eq!(table.lines().count(), 2 + KEYS.len());
}
