//! Atomic writing: a file is either complete or absent.

use std::fs::{File, Metadata};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::Builder;

use crate::MeshError;

/// Writes the file at `path` through a temporary file in the same folder.
///
/// The temporary file is renamed when it is complete. Readers therefore never see an incomplete
/// file, and after an error the previous file is unchanged. A new file has the permissions of the
/// previous one. Of a symbolic link the file that it points to is written, also if there is none
/// yet. What is no file, such as a pipe, `/dev/null` or `/dev/stdout`, is written directly.
///
/// # Errors
/// Those of the operating system, and of `write`.
pub fn write_atomically(
    path: impl AsRef<Path>,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> std::io::Result<()> {
    let path = &followed(path.as_ref());
    // Opened again they would have a place of their own in a file, and both outputs mix.
    let standard: Option<Box<dyn Write>> = match path.to_str() {
        Some("/dev/stdout" | "/dev/fd/1" | "/proc/self/fd/1") => Some(Box::new(std::io::stdout())),
        Some("/dev/stderr" | "/dev/fd/2" | "/proc/self/fd/2") => Some(Box::new(std::io::stderr())),
        _ => None,
    };
    if let Some(mut out) = standard {
        write(&mut out)?;
        return out.flush();
    }
    let present = path.metadata().ok();
    let is_special = |found: &Metadata| !found.is_file() && !found.is_dir();
    if is_descriptor(path) || present.as_ref().is_some_and(is_special) {
        let mut out = BufWriter::new(File::options().write(true).open(path)?);
        write(&mut out)?;
        return out.flush();
    }
    let Some(name) = path.file_name() else {
        return Err(std::io::Error::new(
            std::io::ErrorKind::InvalidInput,
            "the path names no file",
        ));
    };
    let mut prefix = std::ffi::OsString::from(".");
    prefix.push(name);
    let mut builder = Builder::new();
    builder.prefix(&prefix).suffix(SUFFIX).rand_bytes(RANDOM);
    // Temporary files are private by default; this file gets the permissions of any new file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    if let Some(present) = present {
        builder.permissions(present.permissions());
    }
    // Renaming works within one file system only, hence the same folder.
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut temporary = builder.tempfile_in(folder)?;
    let mut out = BufWriter::new(temporary.as_file_mut());
    write(&mut out)?;
    out.flush()?;
    drop(out);
    // The contents must reach the disk before the name does.
    temporary.as_file().sync_all()?;
    temporary.persist(path)?;
    Ok(())
}

/// The path that symbolic links lead to; those of descriptors are not followed.
fn followed(path: &Path) -> PathBuf {
    // As in Linux. The last link of a longer chain is replaced by the file.
    const LINKS: usize = 40;
    let mut path = path.to_path_buf();
    for _ in 0..LINKS {
        match path.read_link() {
            Ok(target) if !is_descriptor(&path) => {
                path = path.parent().unwrap_or(Path::new("")).join(target);
            }
            _ => break,
        }
    }
    path
}

/// Whether a path is that of an open file of a process.
fn is_descriptor(path: &Path) -> bool {
    let is_standard = ["/dev/stdin", "/dev/stdout", "/dev/stderr"]
        .map(Path::new)
        .contains(&path);
    let of_process = path.starts_with("/proc") && path.iter().any(|name| name == "fd");
    is_standard || of_process || path.starts_with("/dev/fd")
}

/// Whether a file name is that of a temporary file of [`write_atomically`], which a killed process
/// leaves behind.
///
/// ```
/// assert!(mesh::is_temporary_file(".mesh.vtuq1W2e3.tmp"));
/// assert!(!mesh::is_temporary_file(".notes.tmp") && !mesh::is_temporary_file("mesh.tmp"));
/// ```
pub fn is_temporary_file(name: &str) -> bool {
    // The six random characters follow the extension of the file.
    let stem = name
        .strip_prefix('.')
        .and_then(|name| name.strip_suffix(SUFFIX));
    let extension = stem.and_then(|stem| stem.rsplit_once('.'));
    extension.is_some_and(|(name, rest)| {
        let is_random = rest.len() > RANDOM && rest.chars().all(|c| c.is_ascii_alphanumeric());
        !name.is_empty() && is_random
    })
}

/// End of the names of temporary files, after this number of random characters.
const SUFFIX: &str = ".tmp";
const RANDOM: usize = 6;

/// Writes a mesh file by [`write_atomically`].
///
/// # Errors
/// [`MeshError::Io`] with the path.
pub(super) fn write_file(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), MeshError> {
    write_atomically(path, write).map_err(|source| MeshError::Io {
        path: path.into(),
        source,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn failed_write_keeps_the_old_file_and_leaves_no_temporary_file() {
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
    fn missing_folder_is_an_error_with_the_name_of_the_file() {
        let error = write_file(Path::new("no/such/folder/a.vtu"), |_| Ok(())).unwrap_err();
        assert!(
            error.to_string().starts_with("no/such/folder/a.vtu: "),
            "{error}"
        );
    }

    /// `swim solve --flow /dev/full` replaced the device by a file and was content.
    #[cfg(unix)]
    #[test]
    fn bug_outputs_replaced_devices_and_symbolic_links() {
        let folder = tempfile::tempdir().unwrap();
        let [file, link] = ["file", "link"].map(|name| folder.path().join(name));
        fs::write(&file, b"old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write_atomically(&link, |out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        // Of a link that leads to no file yet, given relative to its folder.
        let [new, chain, dangling] =
            ["new", "chain", "dangling"].map(|name| folder.path().join(name));
        std::os::unix::fs::symlink("new", &dangling).unwrap();
        std::os::unix::fs::symlink("dangling", &chain).unwrap();
        write_atomically(&chain, |out| out.write_all(b"first")).unwrap();
        assert_eq!(fs::read(&new).unwrap(), b"first");
        assert!(fs::symlink_metadata(&dangling).unwrap().is_symlink());
        let circle = folder.path().join("circle");
        std::os::unix::fs::symlink("circle", &circle).unwrap();
        write_atomically(&circle, |out| out.write_all(b"x")).unwrap();
        // A link to a device, whose folder nobody may write to in a test.
        let null = folder.path().join("null");
        std::os::unix::fs::symlink("/dev/null", &null).unwrap();
        write_atomically(&null, |out| out.write_all(b"gone")).unwrap();
        let found = fs::metadata("/dev/null").unwrap();
        assert!(!found.is_file() && fs::symlink_metadata(&null).unwrap().is_symlink());
        // A folder of ordinary files below that of devices.
        let memory = Path::new("/dev/shm");
        if memory.is_dir() {
            let folder = tempfile::tempdir_in(memory).unwrap();
            let file = folder.path().join("file");
            for text in ["longer", "new"] {
                write_atomically(&file, |out| out.write_all(text.as_bytes())).unwrap();
                assert_eq!(fs::read_to_string(&file).unwrap(), text);
            }
        }
        let full = Path::new("/dev/full");
        if full.exists() {
            let failure = write_atomically(full, |out| out.write_all(&[0; 100]));
            assert!(failure.is_err() && !fs::metadata(full).unwrap().is_file());
        }
    }

    /// Temporary files are readable by their owner only; the finished file must not be.
    #[cfg(unix)]
    #[test]
    fn written_file_has_the_permissions_of_a_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let mode = |name: &str| {
            let file = fs::metadata(folder.path().join(name)).unwrap();
            file.permissions().mode()
        };
        fs::write(folder.path().join("plain"), b"").unwrap();
        write_atomically(folder.path().join("atomic"), |_| Ok(())).unwrap();
        assert_eq!(mode("atomic"), mode("plain"));
        let private = folder.path().join("private");
        fs::write(&private, b"old").unwrap();
        fs::set_permissions(&private, fs::Permissions::from_mode(0o600)).unwrap();
        write_atomically(&private, |_| Ok(())).unwrap();
        assert_eq!(mode("private") & 0o777, 0o600);
    }
}
