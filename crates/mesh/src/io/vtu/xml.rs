//! The XML of a VTU file, and the encoding of its numbers.

use std::io::Read;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::read::ZlibEncoder;
use rayon::prelude::*;

/// Encoding of the numbers in a VTU file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum VtuEncoding {
    /// Bytes compressed by zlib after the XML: half the size, but not well-formed XML.
    #[default]
    Compressed,
    /// Raw bytes after the XML: fastest, but not well-formed XML.
    Appended,
    /// Base64 inside the XML: a third larger than raw bytes, but well-formed XML.
    Base64,
}

/// Bytes that are compressed together. Blocks are compressed in parallel; the window of zlib,
/// 32 kB, is small beside them.
const BLOCK: usize = 1 << 18;

/// Bytes compressed by zlib as `vtkZLibDataCompressor` does.
///
/// The number of blocks, their length before compression, that of the last one if it is shorter
/// and otherwise zero, and the lengths after compression, all `UInt64`; then the blocks.
fn compressed(bytes: &[u8], level: Compression) -> Vec<u8> {
    let compress = |block: &[u8]| {
        let mut encoder = ZlibEncoder::new(block, level);
        let mut bytes = Vec::new();
        // Reading from and writing to memory cannot fail.
        let _ = encoder.read_to_end(&mut bytes);
        bytes
    };
    let blocks: Vec<Vec<u8>> = bytes.par_chunks(BLOCK).map(compress).collect();
    let header = [blocks.len(), BLOCK, bytes.len() % BLOCK].into_iter();
    let lengths = header.chain(blocks.iter().map(Vec::len));
    let mut result: Vec<u8> = lengths.flat_map(|n| (n as u64).to_le_bytes()).collect();
    result.extend(blocks.iter().flatten());
    result
}

/// Values of an array, all of one type.
pub(super) enum Values {
    Reals(Vec<f64>),
    Integers(Vec<i64>),
    Bytes(Vec<u8>),
}

impl Values {
    fn type_name(&self) -> &'static str {
        match self {
            Self::Reals(_) => "Float64",
            Self::Integers(_) => "Int64",
            Self::Bytes(_) => "UInt8",
        }
    }

    /// The numbers, little-endian.
    fn bytes(&self) -> Vec<u8> {
        match self {
            Self::Reals(values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
            Self::Integers(values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
            Self::Bytes(values) => values.clone(),
        }
    }

    /// Level of the compression.
    ///
    /// From level 1 to level 2 the time doubles. Numbers of 64 bits become 9 % smaller, since most
    /// of their bits are random, but the connectivity 32 %.
    fn level(&self) -> Compression {
        match self {
            Self::Reals(_) => Compression::new(1),
            Self::Integers(_) | Self::Bytes(_) => Compression::new(2),
        }
    }

    /// The array in an encoding, with its header of `UInt64`.
    fn block(&self, encoding: VtuEncoding) -> Vec<u8> {
        let bytes = self.bytes();
        match encoding {
            VtuEncoding::Compressed => compressed(&bytes, self.level()),
            VtuEncoding::Appended | VtuEncoding::Base64 => {
                [(bytes.len() as u64).to_le_bytes().to_vec(), bytes].concat()
            }
        }
    }
}

/// A named array.
pub(super) struct Array {
    name: String,
    components: usize,
    values: Values,
}

impl Array {
    pub(super) fn new(name: &str, components: usize, values: Values) -> Self {
        Self {
            name: name.into(),
            components,
            values,
        }
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    fn rows(&self) -> usize {
        let numbers = match &self.values {
            Values::Reals(values) => values.len(),
            Values::Integers(values) => values.len(),
            Values::Bytes(values) => values.len(),
        };
        numbers / self.components
    }
}

/// Contents of a file, which has a single piece.
pub(super) struct Piece<'a> {
    pub(super) n_points: usize,
    pub(super) n_cells: usize,
    pub(super) points: &'a [Array],
    pub(super) cells: &'a [Array],
    pub(super) point_data: &'a [Array],
    pub(super) cell_data: &'a [Array],
    pub(super) file_data: &'a [Array],
    pub(super) encoding: VtuEncoding,
}

/// Bytes of the file.
pub(super) fn document(piece: &Piece) -> Vec<u8> {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\"",
    );
    text.push_str(match piece.encoding {
        VtuEncoding::Compressed => " compressor=\"vtkZLibDataCompressor\">\n",
        VtuEncoding::Appended | VtuEncoding::Base64 => ">\n",
    });
    let mut appended = Vec::new();
    text.push_str("<UnstructuredGrid>\n");
    if !piece.file_data.is_empty() {
        append_arrays(
            ("FieldData", piece.file_data),
            piece.encoding,
            (&mut text, &mut appended),
        );
    }
    text += &format!(
        "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
        piece.n_points, piece.n_cells
    );
    for element in [
        ("Points", piece.points),
        ("Cells", piece.cells),
        ("PointData", piece.point_data),
        ("CellData", piece.cell_data),
    ] {
        append_arrays(element, piece.encoding, (&mut text, &mut appended));
    }
    text.push_str("</Piece>\n</UnstructuredGrid>\n");
    let mut bytes = text.into_bytes();
    if piece.encoding != VtuEncoding::Base64 {
        // Offsets count from the byte after the underscore.
        bytes.extend(b"<AppendedData encoding=\"raw\">\n_");
        bytes.append(&mut appended);
        bytes.extend(b"\n</AppendedData>\n");
    }
    bytes.extend(b"</VTKFile>\n");
    bytes
}

/// Appends an element with arrays to the text, and their numbers to the appended data.
fn append_arrays(
    (element, arrays): (&str, &[Array]),
    encoding: VtuEncoding,
    (text, appended): (&mut String, &mut Vec<u8>),
) {
    *text += &format!("<{element}>\n");
    let blocks = arrays.par_iter().map(|array| array.values.block(encoding));
    let blocks: Vec<Vec<u8>> = blocks.collect();
    for (array, block) in arrays.iter().zip(blocks) {
        *text += &format!(
            "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" ",
            array.values.type_name(),
            escape(&array.name),
            array.components
        );
        if element == "FieldData" {
            // Points and cells tell the lengths of other arrays.
            *text += &format!("NumberOfTuples=\"{}\" ", array.rows());
        }
        if encoding == VtuEncoding::Base64 {
            let numbers = STANDARD.encode(&block);
            *text += &format!("format=\"binary\">\n{numbers}\n</DataArray>\n");
        } else {
            *text += &format!("format=\"appended\" offset=\"{}\"/>\n", appended.len());
            appended.extend(block);
        }
    }
    *text += &format!("</{element}>\n");
}

/// Text with XML escapes, for the value of an attribute.
pub(super) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            // XML 1.0 forbids most control characters, escaped or not.
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}
