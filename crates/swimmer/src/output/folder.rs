//! The output folder: checked for write access first, then filled with complete files only.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use crate::error::SwimError;

/// A folder that exists and can be written to.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// Creates the folder if needed and checks that it can be written to.
    ///
    /// # Errors
    /// [`SwimError::Write`] when that fails.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, SwimError> {
        let path = path.as_ref();
        let check = || {
            std::fs::create_dir_all(path)?;
            tempfile::tempfile_in(path)
        };
        match check() {
            Ok(_) => Ok(Self {
                path: path.to_owned(),
            }),
            Err(source) => Err(SwimError::Write {
                path: path.to_owned(),
                source,
            }),
        }
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Reserves the folder for this run until the lock is dropped, and removes the temporary files
    /// that a killed run has left.
    ///
    /// The operating system holds the lock, so that of a process that no longer exists is free.
    /// On file systems without locks nothing is reserved.
    ///
    /// # Errors
    /// [`SwimError::Locked`] while another run has the folder; [`SwimError::Write`].
    pub fn lock(&self) -> Result<FolderLock, SwimError> {
        let path = self.path.join(LOCK_FILE);
        match FolderLock::new(&path) {
            Ok(lock) => {
                self.remove_temporary_files();
                Ok(lock)
            }
            Err(TryLockError::WouldBlock) => Err(SwimError::Locked {
                folder: self.path.clone(),
                process: process_in(&path),
            }),
            Err(TryLockError::Error(source)) => Err(SwimError::Write { path, source }),
        }
    }

    /// Removes the temporary files of [`Folder::write`], without those of tables, which other
    /// processes may be writing now. What cannot be removed does no harm.
    fn remove_temporary_files(&self) {
        let entries = std::fs::read_dir(&self.path).into_iter().flatten();
        for entry in entries.filter_map(Result::ok) {
            let name = entry.file_name();
            let name = name.to_string_lossy();
            if mesh::is_temporary_file(&name) && !name.starts_with(".table.") {
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }

    /// Writes a file through a temporary file that is renamed when it is complete.
    ///
    /// Readers never see an incomplete file, and after an error the previous file is unchanged.
    ///
    /// # Errors
    /// [`SwimError::Write`], with the name of the file.
    pub fn write(
        &self,
        name: &str,
        content: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
    ) -> Result<PathBuf, SwimError> {
        let path = self.path.join(name);
        match mesh::write_atomically(&path, content) {
            Ok(()) => Ok(path),
            Err(source) => Err(SwimError::Write { path, source }),
        }
    }

    /// Removes a file of an earlier run, if there is one.
    ///
    /// # Errors
    /// As [`Folder::remove`].
    pub fn remove_old(&self, name: &str) -> Result<(), SwimError> {
        match self.path.join(name).exists() {
            true => self.remove(name),
            false => Ok(()),
        }
    }

    /// Removes a file.
    ///
    /// # Errors
    /// [`SwimError::Write`], with the name of the file.
    pub fn remove(&self, name: &str) -> Result<(), SwimError> {
        let path = self.path.join(name);
        std::fs::remove_file(&path).map_err(|source| SwimError::Write { path, source })
    }
}

/// Name of the file that a run locks.
const LOCK_FILE: &str = "run.lock";

/// The right of one run to write into a folder ([`Folder::lock`]).
#[derive(Debug)]
pub struct FolderLock {
    path: PathBuf,
    /// The locked file; none on file systems without locks.
    file: Option<File>,
}

impl FolderLock {
    fn new(path: &Path) -> Result<Self, TryLockError> {
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true).truncate(false);
        loop {
            let mut file = options.open(path).map_err(TryLockError::Error)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Err(TryLockError::WouldBlock),
                // The file system has no locks.
                Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => {
                    let path = path.to_owned();
                    return Ok(Self { path, file: None });
                }
                Err(error) => return Err(error),
            }
            // The run that had the lock may have removed the file after it was opened here.
            if is_at(&file, path) {
                let process = std::process::id();
                (file
                    .set_len(0)
                    .and_then(|()| writeln!(file, "process {process}")))
                .map_err(TryLockError::Error)?;
                return Ok(Self {
                    path: path.to_owned(),
                    file: Some(file),
                });
            }
        }
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // While it is locked: a file that stays is taken over by the next run. Only where another
        // run notices that the file it has opened is gone.
        if self.file.is_some() && cfg!(unix) {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Whether an open file still has this path.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let number = |metadata: std::io::Result<std::fs::Metadata>| {
        let metadata = metadata.ok()?;
        Some((metadata.dev(), metadata.ino()))
    };
    let own = number(file.metadata());
    own.is_some() && own == number(std::fs::metadata(path))
}

/// Whether an open file still has this path: elsewhere, lock files are not removed.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}

/// The process that is named in a lock file, in words.
fn process_in(path: &Path) -> String {
    let mut text = String::new();
    // Other systems do not let a locked file be read.
    let read = File::open(path).and_then(|file| file.take(64).read_to_string(&mut text));
    match (read, text.trim()) {
        (Ok(_), process) if !process.is_empty() => process.to_owned(),
        _ => "another process".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_keeps_the_old_file_and_leaves_no_temporary_file() {
        let temporary = tempfile::tempdir().unwrap();
        let folder = Folder::create(temporary.path().join("a/b")).unwrap();
        folder.write("kept", |file| file.write_all(b"old")).unwrap();
        let failure = folder.write("kept", |file| {
            file.write_all(b"new")?;
            Err(std::io::Error::other("disk full"))
        });
        assert!(matches!(failure, Err(SwimError::Write { .. })));
        assert_eq!(std::fs::read(folder.path().join("kept")).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn two_runs_do_not_write_into_one_folder_and_a_killed_one_leaves_it_free() {
        let temporary = tempfile::tempdir().unwrap();
        let folder = Folder::create(temporary.path()).unwrap();
        // As a killed run leaves them.
        for name in [
            LOCK_FILE,
            ".trajectory.csvAb12cD.tmp",
            ".mine.tmp",
            "table.csv",
        ] {
            std::fs::write(folder.path().join(name), "process 1").unwrap();
        }
        let lock = folder.lock().unwrap();
        let message = folder.lock().unwrap_err().to_string();
        let own = format!("process {}", std::process::id());
        assert!(
            message.contains(&own) && message.contains("--out"),
            "{message}"
        );
        drop(lock);
        drop(folder.lock().unwrap());
        let entries = std::fs::read_dir(folder.path()).unwrap();
        let mut left: Vec<_> = entries.map(|entry| entry.unwrap().file_name()).collect();
        left.sort();
        assert_eq!(left, [".mine.tmp", "table.csv"]);
    }

    #[test]
    fn the_name_of_a_file_is_refused_as_a_folder() {
        let temporary = tempfile::tempdir().unwrap();
        let path = temporary.path().join("file");
        std::fs::write(&path, "").unwrap();
        assert!(matches!(
            Folder::create(&path),
            Err(SwimError::Write { .. })
        ));
    }
}
