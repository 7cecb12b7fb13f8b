//! The output folder: found writable before any work starts, and written to in whole files only.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::SwimError;

/// A folder that exists and can be written to.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// Makes the folder if needed and tries to write to it.
    ///
    /// # Errors
    /// [`SwimError::Write`] when that fails.
    pub fn create(path: &Path) -> Result<Self, SwimError> {
        let folder = Self {
            path: path.to_owned(),
        };
        std::fs::create_dir_all(path).map_err(|source| SwimError::Write {
            path: path.to_owned(),
            source,
        })?;
        folder.write("writable", |file| file.write_all(b"?\n"))?;
        folder.remove("writable")?;
        Ok(folder)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file under another name and renames it, so that readers and crashes never see half of it.
    ///
    /// # Errors
    /// [`SwimError::Write`], with the file's name.
    pub fn write(
        &self,
        name: &str,
        content: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
    ) -> Result<PathBuf, SwimError> {
        let (path, partial) = (
            self.path.join(name),
            self.path.join(format!(".{name}.partial")),
        );
        let attempt = || {
            let mut file = BufWriter::new(File::create(&partial)?);
            content(&mut file)?;
            file.flush()?;
            file.get_ref().sync_all()?;
            std::fs::rename(&partial, &path)
        };
        match attempt() {
            Ok(()) => Ok(path),
            Err(source) => {
                // What is left of the attempt is of no use; that it cannot be removed changes nothing.
                let _ = std::fs::remove_file(&partial);
                Err(SwimError::Write { path, source })
            }
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
    /// [`SwimError::Write`], with the file's name.
    pub fn remove(&self, name: &str) -> Result<(), SwimError> {
        let path = self.path.join(name);
        std::fs::remove_file(&path).map_err(|source| SwimError::Write { path, source })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let temporary = tempfile::tempdir().unwrap();
        let folder = Folder::create(&temporary.path().join("a/b")).unwrap();
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
    fn a_folder_that_is_a_file_is_refused() {
        let temporary = tempfile::tempdir().unwrap();
        let path = temporary.path().join("file");
        std::fs::write(&path, "").unwrap();
        assert!(matches!(
            Folder::create(&path),
            Err(SwimError::Write { .. })
        ));
    }
}
