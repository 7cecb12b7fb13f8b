//! Files of users: regular files of a limited size, with the hash of their contents.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

use crate::MeshError;

/// Largest mesh or surface file in bytes: about the memory of the meshes that can be computed with.
pub const MAX_MESH_FILE: u64 = 1 << 32;

/// Contents of a file, with the hash by which a later change is noticed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputFile {
    /// The bytes of the file.
    pub bytes: Vec<u8>,
    /// [`content_hash`] of the bytes.
    pub hash: u64,
}

impl InputFile {
    /// Reads a regular file of at most `max_bytes` bytes.
    ///
    /// Devices and pipes are refused before they are opened, because some of them never end and
    /// others wait for a writer.
    ///
    /// # Errors
    /// Those of the operating system; [`ErrorKind::InvalidInput`] with the remedy for what is no
    /// regular file, and with both numbers for a file that is too large.
    ///
    /// ```
    /// # #[cfg(target_os = "linux")] {
    /// let error = mesh::InputFile::read("/dev/zero", 1000).unwrap_err();
    /// assert!(error.to_string().contains("not a regular file"));
    /// # }
    /// ```
    pub fn read(path: impl AsRef<Path>, max_bytes: u64) -> Result<Self> {
        let path = path.as_ref();
        let refused = |problem: String| Err(Error::new(ErrorKind::InvalidInput, problem));
        let too_large = |size: String| {
            refused(format!(
                "the file has {size} bytes, more than the limit of {max_bytes}; make it smaller"
            ))
        };
        let metadata = std::fs::metadata(path)?;
        if metadata.is_dir() {
            return refused("it is a folder; name a file in it".to_owned());
        }
        if !metadata.is_file() {
            return refused(
                "it is not a regular file but a device or a pipe; copy its contents into a file \
                 and name that one"
                    .to_owned(),
            );
        }
        if metadata.len() > max_bytes {
            return too_large(metadata.len().to_string());
        }
        let mut bytes = Vec::new();
        // The file may grow while it is read.
        (File::open(path)?.take(max_bytes.saturating_add(1))).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > max_bytes {
            return too_large(format!("at least {}", bytes.len()));
        }
        let hash = content_hash(&bytes);
        Ok(Self { bytes, hash })
    }

    /// The contents as text.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidData`] with the position of the first byte that is not UTF-8.
    pub fn into_text(self) -> Result<String> {
        String::from_utf8(self.bytes).map_err(|error| {
            let at = error.utf8_error().valid_up_to();
            let problem = format!("byte {at} is not UTF-8; save the file as UTF-8 text");
            Error::new(ErrorKind::InvalidData, problem)
        })
    }
}

/// Hash of some bytes, the same on all machines and in all versions: FNV-1a with 64 bits.
///
/// `h = 14695981039346656037; for each byte b: h = (h xor b) * 1099511628211 mod 2^64`
///
/// Every step is one-to-one in `h`, so a change of one byte always changes the hash; two unrelated
/// contents have the same one with a probability of 5e-20. It notices accidents, and is no
/// protection against somebody who wants to deceive. Source: G. Fowler, L. C. Noll, K.-P. Vo,
/// D. Eastlake, *The FNV Non-Cryptographic Hash Algorithm*.
///
/// ```
/// assert_eq!(mesh::content_hash(b"foobar"), 0x8594_4171_f739_67e8);
/// ```
pub fn content_hash(bytes: &[u8]) -> u64 {
    const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0000_0100_0000_01b3;
    (bytes.iter()).fold(OFFSET, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(PRIME)
    })
}

/// The bytes of a mesh or surface file.
///
/// # Errors
/// [`MeshError::Io`] with the path.
pub(super) fn read_mesh_file(path: &Path) -> std::result::Result<Vec<u8>, MeshError> {
    match InputFile::read(path, MAX_MESH_FILE) {
        Ok(file) => Ok(file.bytes),
        Err(source) => Err(MeshError::Io {
            path: path.into(),
            source,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_above_the_limit_is_refused_with_both_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        std::fs::write(&path, b"12345").unwrap();
        let read = InputFile::read(&path, 5).unwrap();
        assert_eq!(read.bytes, b"12345");
        let error = InputFile::read(&path, 4).unwrap_err().to_string();
        assert!(
            error.contains("5 bytes") && error.contains("limit of 4"),
            "{error}"
        );
        let error = InputFile::read(folder.path(), 4).unwrap_err().to_string();
        assert!(error.contains("a folder"), "{error}");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn an_endless_device_is_no_mesh_file() {
        let error = crate::MshFile::read("/dev/zero").unwrap_err().to_string();
        assert!(error.contains("not a regular file"), "{error}");
    }

    /// Offset basis, and two values of the table in the appendix of the authors' draft.
    #[test]
    fn hashes_are_those_of_the_published_table() {
        for (text, hash) in [
            ("", 0xcbf2_9ce4_8422_2325),
            ("a", 0xaf63_dc4c_8601_ec8c),
            ("foobar", 0x8594_4171_f739_67e8),
        ] {
            assert_eq!(content_hash(text.as_bytes()), hash, "{text}");
        }
    }
}
