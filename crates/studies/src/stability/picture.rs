//! A map as a picture with one coloured field per cell.

use std::fmt::Write;

use super::map::{Cell, Map, Outcome};

const LABEL: f64 = 330.0;
const WIDTH: f64 = 74.0;
const HEIGHT: f64 = 24.0;
const HEAD: f64 = 30.0;

/// The map as SVG text.
pub fn svg(map: &Map) -> String {
    let (columns, rows) = (map.columns.len() as f64, map.rows.len() as f64);
    // Columns are wide enough for the longest text.
    let longest = map
        .cells()
        .map(|cell| cell.outcome.mark().len())
        .max()
        .unwrap_or(0);
    let width = WIDTH.max(7.0 * longest as f64 + 14.0);
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{:.0}\" height=\"{:.0}\" font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        LABEL + width * columns + 8.0,
        HEAD + HEIGHT * rows + 8.0
    );
    // Writing to a String cannot fail.
    for (k, column) in map.columns.iter().enumerate() {
        let x = LABEL + width * (k as f64 + 0.5);
        let _ = writeln!(
            text,
            "<text x=\"{x:.1}\" y=\"20\" text-anchor=\"middle\" fill=\"#282828\">{column}</text>"
        );
    }
    for (r, row) in map.rows.iter().enumerate() {
        let y = HEAD + HEIGHT * r as f64;
        let _ = writeln!(
            text,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\" fill=\"#282828\">{}</text>",
            LABEL - 8.0,
            y + 16.0,
            row.case
        );
        for (c, cell) in row.cells.iter().enumerate() {
            let x = LABEL + width * c as f64;
            let (fill, ink) = colours(cell);
            let _ = writeln!(
                text,
                "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" rx=\"3\" fill=\"{fill}\"/>\
                 <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"{ink}\">{}</text>",
                x + 1.0,
                y + 1.0,
                width - 2.0,
                HEIGHT - 2.0,
                x + 0.5 * width,
                y + 16.0,
                cell.outcome.mark()
            );
        }
    }
    text.push_str("</svg>\n");
    text
}

/// Colours of field and text, from a palette that colour-blind readers can distinguish.
fn colours(cell: &Cell) -> (&'static str, &'static str) {
    match &cell.outcome {
        Outcome::Wrong { .. } => ("#b3261e", "#fff"),
        _ if !cell.as_expected => ("#e69f00", "#000"),
        Outcome::Right { .. } => ("#bfe3d7", "#00382b"),
        Outcome::Refused(_) => ("#d9dee5", "#39424d"),
    }
}
