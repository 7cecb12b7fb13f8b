//! Files that are either whole or not there.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use crate::MeshError;

/// Tells apart the files that this process is writing.
static SERIAL: AtomicU64 = AtomicU64::new(0);

/// Writes the file at `path` by way of a neighbour that takes its name when complete.
///
/// A reader (or a killed writer) never leaves or sees half a file; on an error the old file stays.
pub(super) fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), MeshError> {
    let io_error = |source| MeshError::Io {
        path: path.into(),
        source,
    };
    let temporary = neighbour(path).map_err(io_error)?;
    let result = fill(&temporary, write).and_then(|()| fs::rename(&temporary, path));
    if result.is_err() {
        // The error that matters is the first one.
        let _ = fs::remove_file(&temporary);
    }
    result.map_err(io_error)
}

fn fill(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> std::io::Result<()> {
    let mut out = BufWriter::new(File::create_new(path)?);
    write(&mut out)?;
    // Buffered bytes must reach the disk before the name does.
    out.into_inner()?.sync_all()
}

/// A name in the same folder, as renaming works within a file system only.
fn neighbour(path: &Path) -> std::io::Result<PathBuf> {
    let Some(name) = path.file_name() else {
        return Err(std::io::Error::new(
            std::io::ErrorKind::InvalidInput,
            "the path names no file",
        ));
    };
    let serial = SERIAL.fetch_add(1, Ordering::Relaxed);
    let mut hidden = std::ffi::OsString::from(".");
    hidden.push(name);
    hidden.push(format!(".{}-{serial}.tmp", std::process::id()));
    Ok(path.with_file_name(hidden))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failed_write_keeps_the_old_file_and_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.vtu");
        write_atomically(&path, |out| out.write_all(b"old")).unwrap();
        let failure = write_atomically(&path, |out| {
            out.write_all(b"half of the new")?;
            Err(std::io::Error::other("disk full"))
        });
        assert!(failure.unwrap_err().to_string().contains("disk full"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn missing_folder_is_an_error_that_names_the_file() {
        let error = write_atomically(Path::new("no/such/folder/a.vtu"), |_| Ok(())).unwrap_err();
        assert!(
            error.to_string().starts_with("no/such/folder/a.vtu: "),
            "{error}"
        );
    }
}
