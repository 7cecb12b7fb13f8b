//! Scanner of the words and numbers of a MSH file, text or binary, with their locations.

use crate::{FileLocation, MeshError};

/// Encoding of the numbers in a file.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// A reading position in the bytes of a file.
pub(super) struct Scanner<'a> {
    file: &'a str,
    bytes: &'a [u8],
    next: usize,
    /// Start of the item read last, where errors are reported.
    item: usize,
    section: String,
    pub(super) encoding: Encoding,
    /// Bytes of a `size_t` in the file: 4 or 8.
    pub(super) size_width: usize,
}

type Scan<T> = Result<T, MeshError>;

impl<'a> Scanner<'a> {
    pub(super) fn new(file: &'a str, bytes: &'a [u8]) -> Self {
        Self {
            file,
            bytes,
            next: 0,
            item: 0,
            section: String::new(),
            encoding: Encoding::Text,
            size_width: 8,
        }
    }

    /// Error at the item read last.
    pub(super) fn error<T>(&self, problem: impl Into<String>) -> Scan<T> {
        let location = if self.encoding == Encoding::Text {
            let before = &self.bytes[..self.item];
            FileLocation::Line(1 + before.iter().filter(|&&b| b == b'\n').count())
        } else {
            FileLocation::Byte(self.item)
        };
        Err(MeshError::Malformed {
            file: self.file.into(),
            location,
            problem: problem.into(),
        })
    }

    /// Error at an unexpected end of the file.
    fn unexpected_end<T>(&self) -> Scan<T> {
        self.error(format!(
            "the file ends in the middle of ${}; save it again",
            self.section
        ))
    }

    /// Opens the next section; returns its name without the dollar sign, or `None` at the end of
    /// the file.
    pub(super) fn open(&mut self) -> Scan<Option<String>> {
        self.skip_space();
        self.item = self.next;
        if self.next == self.bytes.len() {
            return Ok(None);
        }
        let line = self.line();
        match line.strip_prefix('$') {
            Some(name) if !name.is_empty() => {
                self.section = name.to_string();
                Ok(Some(name.to_string()))
            }
            _ => {
                let what = match self.section.is_empty() {
                    true => "; this is no mesh of Gmsh: save it as .msh, version 4.1 or 2.2",
                    false => "",
                };
                self.error(format!(
                    "expected a section such as $Nodes, found '{}'{what}",
                    brief(&line)
                ))
            }
        }
    }

    /// Closes the section: the next word must be `$End` with its name.
    pub(super) fn close(&mut self) -> Scan<()> {
        let word = self.word()?;
        if word == format!("$End{}", self.section) {
            return Ok(());
        }
        self.error(format!(
            "according to its counts ${0} should end here, but '{1}' is here instead of $End{0}",
            self.section,
            brief(&word)
        ))
    }

    /// Skips the section without reading it.
    pub(super) fn skip(&mut self) -> Scan<()> {
        let end = format!("$End{}", self.section);
        let rest = &self.bytes[self.next..];
        match rest
            .windows(end.len())
            .position(|window| window == end.as_bytes())
        {
            Some(offset) => {
                self.next += offset + end.len();
                Ok(())
            }
            None => self.error(format!("{end} is missing; the file is truncated")),
        }
    }

    /// The rest of the line as text, trimmed.
    pub(super) fn line(&mut self) -> String {
        let rest = &self.bytes[self.next..];
        let len = rest
            .iter()
            .position(|&b| b == b'\n')
            .map_or(rest.len(), |n| n + 1);
        self.next += len;
        String::from_utf8_lossy(&rest[..len]).trim().to_string()
    }

    /// The next word of text, also in binary files.
    pub(super) fn word(&mut self) -> Scan<String> {
        self.word_bytes()
            .map(|word| String::from_utf8_lossy(word).into_owned())
    }

    /// The next number written as text, also in binary files.
    pub(super) fn number<T: std::str::FromStr>(&mut self) -> Scan<T> {
        let word = self.word_bytes()?;
        match std::str::from_utf8(word)
            .ok()
            .and_then(|text| text.parse().ok())
        {
            Some(number) => Ok(number),
            None => self.error(format!(
                "expected a number, found '{}'",
                brief(&String::from_utf8_lossy(word))
            )),
        }
    }

    /// The next `int` in the encoding of the file.
    pub(super) fn int(&mut self) -> Scan<i32> {
        match self.encoding {
            Encoding::Text => self.number(),
            Encoding::LittleEndian => Ok(i32::from_le_bytes(self.take()?)),
            Encoding::BigEndian => Ok(i32::from_be_bytes(self.take()?)),
        }
    }

    /// The next `size_t` in the encoding of the file.
    pub(super) fn size(&mut self) -> Scan<u64> {
        match (self.encoding, self.size_width) {
            (Encoding::Text, _) => self.number(),
            (Encoding::LittleEndian, 4) => Ok(u32::from_le_bytes(self.take()?).into()),
            (Encoding::BigEndian, 4) => Ok(u32::from_be_bytes(self.take()?).into()),
            (Encoding::LittleEndian, _) => Ok(u64::from_le_bytes(self.take()?)),
            (Encoding::BigEndian, _) => Ok(u64::from_be_bytes(self.take()?)),
        }
    }

    /// The next `double` in the encoding of the file, which must be finite.
    pub(super) fn real(&mut self) -> Scan<f64> {
        let value: f64 = match self.encoding {
            Encoding::Text => self.number()?,
            Encoding::LittleEndian => f64::from_le_bytes(self.take()?),
            Encoding::BigEndian => f64::from_be_bytes(self.take()?),
        };
        if value.is_finite() {
            Ok(value)
        } else {
            self.error(format!("the coordinate {value} is not a finite number"))
        }
    }

    /// Checks that `count` items of at least `numbers` numbers each fit into the rest of the file.
    ///
    /// A number takes at least four bytes in binary files and two (a digit and a space) in text.
    /// This bounds the memory reserved for a count by the size of the file.
    pub(super) fn fits(&self, what: &str, count: u64, numbers: u64) -> Scan<usize> {
        let width = if self.encoding == Encoding::Text {
            2
        } else {
            4
        };
        // The last number of a text file may be at its very end, without a space.
        let remaining = (self.bytes.len() - self.next) as u64 + 1;
        let at_most = remaining / (width * numbers);
        if count <= at_most {
            return Ok(count as usize);
        }
        self.error(format!(
            "${} announces {count} {what}, but the rest of the file can hold at most {at_most}",
            self.section
        ))
    }

    fn take<const N: usize>(&mut self) -> Scan<[u8; N]> {
        self.item = self.next;
        match self.bytes[self.next..].first_chunk::<N>() {
            Some(chunk) => {
                self.next += N;
                Ok(*chunk)
            }
            None => self.unexpected_end(),
        }
    }

    fn word_bytes(&mut self) -> Scan<&'a [u8]> {
        self.skip_space();
        self.item = self.next;
        let rest = &self.bytes[self.next..];
        let len = rest
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(rest.len());
        if len == 0 {
            return self.unexpected_end();
        }
        self.next += len;
        Ok(&rest[..len])
    }

    fn skip_space(&mut self) {
        let rest = &self.bytes[self.next..];
        self.next += rest
            .iter()
            .position(|b| !b.is_ascii_whitespace())
            .unwrap_or(rest.len());
    }
}

/// The beginning of a text, for error messages.
fn brief(text: &str) -> String {
    const SHOWN: usize = 30;
    let printable = |c: char| if c.is_control() { '\u{fffd}' } else { c };
    let mut brief: String = text.chars().take(SHOWN).map(printable).collect();
    if text.chars().nth(SHOWN).is_some() {
        brief.push_str("...");
    }
    brief
}
