//! Files of the repository: where they are, and which of them the checks read.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

/// Folders that hold the Rust crates of the repository.
pub const SOURCE_FOLDERS: [&str; 4] = ["crates", "fuzz", "python", "xtask"];

/// Root of the workspace.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Content of a text file.
pub fn read(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).with_context(|| format!("could not read {}", path.display()))
}

/// Folder of a file; empty for a file of the root.
pub fn folder_of(file: &str) -> &str {
    file.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// All files below a folder whose names end in `extension`, sorted, relative to the root of the
/// workspace; hidden folders and those with built or computed files are left out.
pub fn files_below(folder: &str, extension: &str) -> Result<Vec<String>> {
    let mut files = Vec::new();
    walk(&root(), folder, &mut |name| {
        if name.ends_with(extension) {
            files.push(name.to_owned());
        }
    })?;
    files.sort();
    Ok(files)
}

/// Calls `visit` with each file below a folder.
fn walk(root: &Path, folder: &str, visit: &mut impl FnMut(&str)) -> Result<()> {
    let entries =
        std::fs::read_dir(root.join(folder)).with_context(|| format!("could not list {folder}"))?;
    for entry in entries {
        let entry = entry?;
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let path = match folder {
            "." => name.clone().into_owned(),
            folder => format!("{folder}/{name}"),
        };
        if !entry.path().is_dir() {
            visit(&path);
        } else if !is_left_out(&path, &name) {
            walk(root, &path, visit)?;
        }
    }
    Ok(())
}

/// Whether a folder is hidden or, as in `.gitignore`, has built or computed files.
fn is_left_out(path: &str, name: &str) -> bool {
    name.starts_with('.')
        || name.starts_with("target")
        || ["out", "roofline", "validation"].contains(&path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_found_below_folders_and_from_the_root() {
        let sources = files_below("xtask", ".rs").unwrap();
        assert!(sources.contains(&"xtask/src/files.rs".to_owned()));
        assert!(sources.iter().all(|name| name.ends_with(".rs")));
        let pages = files_below(".", ".md").unwrap();
        for page in ["CONTRIBUTING.md", "docs/scene.md", "crates/mesh/README.md"] {
            assert!(pages.contains(&page.to_owned()), "{page}");
        }
        assert!(!pages.iter().any(|name| name.contains("target/")));
    }
}
