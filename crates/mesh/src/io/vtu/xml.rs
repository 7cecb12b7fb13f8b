//! The XML of a VTU file and the numbers in or behind it.

use std::fmt::Write;

use super::VtuEncoding;
use super::base64::base64;

/// Numbers of one type.
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

    /// The length in bytes as a `UInt64`, then the numbers, little-endian.
    fn block(&self) -> Vec<u8> {
        let data = match self {
            Self::Reals(values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
            Self::Integers(values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
            Self::Bytes(values) => values.clone(),
        };
        [(data.len() as u64).to_le_bytes().to_vec(), data].concat()
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
}

/// The one piece of a file.
pub(super) struct Piece<'a> {
    pub(super) n_points: usize,
    pub(super) n_cells: usize,
    pub(super) points: &'a [Array],
    pub(super) cells: &'a [Array],
    pub(super) point_data: &'a [Array],
    pub(super) cell_data: &'a [Array],
    pub(super) encoding: VtuEncoding,
}

/// The whole file.
pub(super) fn document(piece: &Piece) -> Vec<u8> {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <UnstructuredGrid>\n",
    );
    push(
        &mut text,
        format_args!(
            "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
            piece.n_points, piece.n_cells
        ),
    );
    let mut appended = Vec::new();
    for (element, arrays) in [
        ("Points", piece.points),
        ("Cells", piece.cells),
        ("PointData", piece.point_data),
        ("CellData", piece.cell_data),
    ] {
        push(&mut text, format_args!("<{element}>\n"));
        for array in arrays {
            let block = array.values.block();
            push(
                &mut text,
                format_args!(
                    "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" ",
                    array.values.type_name(),
                    escape(&array.name),
                    array.components
                ),
            );
            match piece.encoding {
                VtuEncoding::Appended => {
                    push(
                        &mut text,
                        format_args!("format=\"appended\" offset=\"{}\"/>\n", appended.len()),
                    );
                    appended.extend(block);
                }
                VtuEncoding::Base64 => {
                    push(
                        &mut text,
                        format_args!("format=\"binary\">\n{}\n</DataArray>\n", base64(&block)),
                    );
                }
            }
        }
        push(&mut text, format_args!("</{element}>\n"));
    }
    text.push_str("</Piece>\n</UnstructuredGrid>\n");
    let mut bytes = text.into_bytes();
    if piece.encoding == VtuEncoding::Appended {
        // Offsets count from behind the underscore.
        bytes.extend(b"<AppendedData encoding=\"raw\">\n_");
        bytes.append(&mut appended);
        bytes.extend(b"\n</AppendedData>\n");
    }
    bytes.extend(b"</VTKFile>\n");
    bytes
}

/// Writing to a string cannot fail.
fn push(text: &mut String, arguments: std::fmt::Arguments) {
    let _ = text.write_fmt(arguments);
}

/// A text as the value of an XML attribute.
pub(super) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            // XML 1.0 knows no other control characters, escaped or not.
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}
