//! Manifests of the workspace.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use toml::Table;

/// A crate of the workspace, or beside its crates.
pub struct Member {
    /// Folder, relative to the root of the workspace.
    pub folder: String,
    /// Its manifest.
    pub manifest: Table,
    /// Whether the workspace excludes it, because it needs software that the others do not need.
    pub is_excluded: bool,
}

impl Member {
    /// Name of the folder, which is also the name of the library.
    pub fn name(&self) -> &str {
        self.folder.rsplit('/').next().unwrap_or(&self.folder)
    }

    /// Name of the package.
    pub fn package(&self) -> Option<&str> {
        self.manifest.get("package")?.get("name")?.as_str()
    }

    /// Whether the package may be published: its manifest does not have `publish = false`.
    pub fn is_publishable(&self) -> bool {
        let package = self.manifest.get("package");
        let publish = package.and_then(|package| package.get("publish"));
        publish.and_then(toml::Value::as_bool) != Some(false)
    }
}

/// Root of the workspace.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Content of a text file.
pub fn read(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).with_context(|| format!("could not read {}", path.display()))
}

/// Manifest in a folder, relative to the root of the workspace.
pub fn manifest(folder: &str) -> Result<Table> {
    let path = root().join(folder).join("Cargo.toml");
    read(&path)?
        .parse()
        .with_context(|| format!("{} is not valid TOML", path.display()))
}

/// All crates: `xtask` and the folders of `crates`, also those that the workspace excludes.
pub fn members() -> Result<Vec<Member>> {
    let mut folders = vec!["xtask".to_owned()];
    for entry in std::fs::read_dir(root().join("crates"))? {
        let name = entry?.file_name();
        folders.push(format!("crates/{}", name.to_string_lossy()));
    }
    folders.sort();
    let workspace = manifest(".")?;
    let excluded = workspace.get("workspace").and_then(|w| w.get("exclude"));
    let excluded: Vec<&str> = (excluded
        .and_then(toml::Value::as_array)
        .into_iter()
        .flatten())
    .filter_map(toml::Value::as_str)
    .collect();
    let member = |folder: String| {
        let manifest = manifest(&folder)?;
        let is_excluded = excluded.contains(&folder.as_str());
        Ok(Member {
            folder,
            manifest,
            is_excluded,
        })
    };
    folders.into_iter().map(member).collect()
}
