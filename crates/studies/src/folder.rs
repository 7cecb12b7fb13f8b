//! The folder to which a study writes its pages.

use std::path::Path;

use anyhow::{Context, Result};

/// Writes files, given by names and contents, into a folder; creates the folder if necessary.
pub fn write<N: AsRef<str>, C: AsRef<str>>(
    folder: &Path,
    files: impl IntoIterator<Item = (N, C)>,
) -> Result<()> {
    std::fs::create_dir_all(folder).with_context(|| {
        let folder = folder.display();
        format!("could not create the folder {folder}; choose another with --out")
    })?;
    for (name, content) in files {
        let path = folder.join(name.as_ref());
        std::fs::write(&path, content.as_ref()).with_context(|| {
            let path = path.display();
            format!("could not write {path}; choose another folder with --out")
        })?;
    }
    Ok(())
}
