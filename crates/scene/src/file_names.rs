//! Names of files in scenes, relative to a folder.

use std::path::{Component, Path, PathBuf};

/// The name of a file seen from a folder; absolute if both have no common root.
///
/// Both are relative to the working directory, or absolute. Symbolic links are followed, because
/// `..` leads out of the folder to which a link points.
pub(crate) fn seen_from(folder: &Path, file: &Path) -> String {
    let full = |path: &Path| {
        let canonical = std::fs::canonicalize(path);
        canonical.or_else(|_| std::path::absolute(path))
    };
    // The name itself may be a link to a file elsewhere, and stays.
    let parent = match file.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let name = match (full(folder), full(parent), file.file_name()) {
        (Ok(folder), Ok(parent), Some(name)) => between(&folder, &parent.join(name)),
        _ => file.to_owned(),
    };
    name.display().to_string()
}

/// The way from a folder to a file, both absolute.
fn between(folder: &Path, file: &Path) -> PathBuf {
    let pairs = folder.components().zip(file.components());
    let common = pairs.take_while(|(a, b)| a == b).count();
    if common == 0 {
        return file.to_owned();
    }
    let up = folder
        .components()
        .skip(common)
        .map(|_| Component::ParentDir);
    up.chain(file.components().skip(common)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_seen_from_folders_above_beside_and_below() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(at("out/deep")).unwrap();
        for (from, file, name) in [
            ("out", "x.stl", "../x.stl"),
            ("out/deep", "x.stl", "../../x.stl"),
            ("out", "out/x.csv", "x.csv"),
            ("out", "out/deep/x.csv", "deep/x.csv"),
            ("out/deep", "out/../x.stl", "../../x.stl"),
        ] {
            let found = seen_from(&at(from), &at(file));
            assert_eq!(PathBuf::from(found), PathBuf::from(name), "{from} {file}");
        }
        // Relative to the working directory, which is another one.
        let found = seen_from(folder.path(), Path::new("Cargo.toml"));
        let again = std::fs::canonicalize(folder.path().join(found)).unwrap();
        assert_eq!(again, std::fs::canonicalize("Cargo.toml").unwrap());
    }
}
