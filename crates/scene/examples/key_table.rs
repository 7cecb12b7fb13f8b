//! Prints all keys of a scene file in Markdown, as in `docs/scene.md`.

use scene::keys::{all, markdown};

/// Prints the tables.
pub fn main() {
    let text = markdown();
    print!("{text}");
    // One line per key, with its name in the first column.
    let rows = text.lines().filter(|line| line.starts_with("| `"));
    assert_eq!(rows.count(), all().count());
}
