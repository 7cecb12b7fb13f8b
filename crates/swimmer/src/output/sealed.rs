//! Files of the program itself: JSON objects that end with a checksum of what stands before it.
//!
//! Such a file is read again by the program. A changed byte would often give another valid number,
//! and with it another result without a word.

use std::io::{Error, ErrorKind, Result};
use std::path::Path;

use mesh::{InputFile, content_hash};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::folder::Folder;
use crate::error::SwimError;

/// Largest file in bytes: a checkpoint of about a hundred thousand phase spans.
const MAX_SIZE: u64 = 1 << 31;

/// The last key, before the 16 hexadecimal digits of the checksum and [`END`].
const KEY: &str = ",\"checksum\":\"";
const END: &str = "\"}\n";
const DIGITS: usize = 16;

/// Writes a value that serialises as an object with at least one key, with its checksum.
///
/// # Errors
/// [`SwimError::Write`].
pub fn write_sealed(
    folder: &Folder,
    name: &str,
    value: &impl Serialize,
) -> std::result::Result<(), SwimError> {
    let write = |file: &mut dyn std::io::Write| file.write_all(sealed(value)?.as_bytes());
    folder.write(name, write).map(drop)
}

/// The text of a value that serialises as an object with at least one key, with its checksum.
///
/// # Errors
/// A value that is no object, or that cannot be serialised.
pub fn sealed(value: &impl Serialize) -> Result<String> {
    let mut text = serde_json::to_string(value)?;
    if text.len() < 4 || text.pop() != Some('}') {
        return Err(Error::other("only objects with keys can be sealed"));
    }
    let hash = content_hash(text.as_bytes());
    text += &format!("{KEY}{hash:0DIGITS$x}{END}");
    Ok(text)
}

/// Reads a file that [`write_sealed`] has written.
///
/// # Errors
/// [`ErrorKind::InvalidData`] with the reason for a damaged file; those of the operating system.
pub fn read_sealed<T: DeserializeOwned>(path: impl AsRef<Path>) -> Result<T> {
    from_sealed(&read_own(path)?.into_text()?)
}

/// The contents of a file of the program itself.
///
/// # Errors
/// Those of [`InputFile::read`].
pub fn read_own(path: impl AsRef<Path>) -> Result<InputFile> {
    InputFile::read(path, MAX_SIZE)
}

/// The value of a text of [`sealed`].
///
/// # Errors
/// [`ErrorKind::InvalidData`] with the reason.
pub fn from_sealed<T: DeserializeOwned>(text: &str) -> Result<T> {
    let damaged = |problem: String| Error::new(ErrorKind::InvalidData, problem);
    // The text is parsed first: what ends in the middle has no checksum either.
    let value = serde_json::from_str(text).map_err(|error| damaged(error.to_string()))?;
    let stated = || {
        let rest = text.strip_suffix(END)?;
        let (rest, digits) = rest.split_at_checked(rest.len().checked_sub(DIGITS)?)?;
        Some((rest.strip_suffix(KEY)?, digits))
    };
    let Some((content, digits)) = stated() else {
        return Err(damaged("it does not end with its checksum".to_owned()));
    };
    let hash = format!("{:0DIGITS$x}", content_hash(content.as_bytes()));
    match hash == digits {
        true => Ok(value),
        false => Err(damaged(format!(
            "its checksum is {digits}, and its contents have {hash}: it was changed"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[derive(serde::Deserialize, Serialize)]
    struct Numbers {
        a: f64,
        b: Option<f64>,
    }

    #[test]
    fn every_changed_bit_of_a_sealed_text_is_noticed() {
        let (a, b) = (0.1, Some(2e-7));
        let text = sealed(&Numbers { a, b }).unwrap();
        let read = |bytes: &[u8]| -> Option<Numbers> {
            from_sealed(std::str::from_utf8(bytes).ok()?).ok()
        };
        assert!(read(text.as_bytes()).is_some_and(|read| (read.a, read.b) == (a, b)));
        for bit in 0..8 * text.len() {
            let mut bytes = text.clone().into_bytes();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert!(read(&bytes).is_none(), "bit {bit}");
        }
        for end in 0..text.len() {
            assert!(read(&text.as_bytes()[..end]).is_none(), "{end}");
        }
    }

    #[test]
    fn what_is_no_object_with_keys_is_not_sealed() {
        assert!(sealed(&3.0).is_err() && sealed(&BTreeMap::<&str, f64>::new()).is_err());
    }
}
