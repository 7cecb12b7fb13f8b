//! The committed inputs of the fuzz targets, for the tests of the crates that include this file.

use std::path::Path;

/// Calls `read` with each file of the corpus of a target, in the order of their names, and says
/// which one it is if `read` panics.
///
/// # Panics
/// If `read` does, or there are no files.
pub fn replay(target: &str, read: fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus");
    let entries = std::fs::read_dir(folder.join(target)).expect("a folder of the repository");
    let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty(), "no corpus of {target}");
    for file in files {
        let bytes = std::fs::read(&file).unwrap();
        let done = std::panic::catch_unwind(|| read(&bytes));
        assert!(done.is_ok(), "{target} panics on {}", file.display());
    }
}
