//! Manifests of the workspace.

use anyhow::{Context, Result};
use toml::Table;

use crate::files::{files_below, read, root};

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

/// Manifest in a folder, relative to the root of the workspace.
pub fn manifest(folder: &str) -> Result<Table> {
    let path = root().join(folder).join("Cargo.toml");
    read(&path)?
        .parse()
        .with_context(|| format!("{} is not valid TOML", path.display()))
}

/// Folders of all crates of the repository, also of those beside the workspace.
pub fn crate_folders() -> Result<Vec<String>> {
    let manifests = files_below(".", "/Cargo.toml")?;
    let folders = manifests
        .iter()
        .filter_map(|path| path.strip_suffix("/Cargo.toml"));
    Ok(folders.map(str::to_owned).collect())
}

/// `xtask` and the crates in `crates`, also those that the workspace excludes.
pub fn members() -> Result<Vec<Member>> {
    let mut folders = crate_folders()?;
    folders.retain(|folder| folder == "xtask" || folder.starts_with("crates/"));
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
