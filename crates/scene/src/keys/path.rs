//! Paths of keys, such as `bodies[1].radius`.

/// The path of a key below a group; the path of the root is empty.
pub(crate) fn join(group: &str, key: &str) -> String {
    if group.is_empty() {
        key.to_owned()
    } else {
        format!("{group}.{key}")
    }
}

/// Removes the indices of a path: `bodies[1].radius` becomes `bodies[].radius`, as in the table.
pub(crate) fn without_indices(path: &str) -> String {
    let mut inside = false;
    path.chars()
        .filter(|&c| {
            inside = (inside || c == '[') && c != ']';
            !inside || c == '['
        })
        .collect()
}
