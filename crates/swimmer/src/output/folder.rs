//! The output folder: checked for write access first, then filled with complete files only.

use std::io::Write;
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
