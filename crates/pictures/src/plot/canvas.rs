//! A picture as SVG text.

use std::ops::Range;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use plotters::prelude::*;

use super::style::{Area, UNITS_PER_PIXEL};
use crate::error::PictureError;

/// Draws on a white area of `size` pixels.
///
/// # Errors
/// As [`transparent_svg`].
pub fn svg(
    size: (u32, u32),
    draw: impl FnOnce(&Area) -> Result<(), Box<dyn std::error::Error>>,
) -> Result<String, PictureError> {
    transparent_svg(size, |root| {
        root.fill(&WHITE)?;
        draw(root)
    })
}

/// Draws on an area of `size` pixels.
///
/// # Errors
/// [`PictureError::Plot`] with the reason given by the plotting library.
pub fn transparent_svg(
    size: (u32, u32),
    draw: impl FnOnce(&Area) -> Result<(), Box<dyn std::error::Error>>,
) -> Result<String, PictureError> {
    let mut svg = String::new();
    let drawing_size = (UNITS_PER_PIXEL * size.0, UNITS_PER_PIXEL * size.1);
    {
        let root = SVGBackend::with_string(&mut svg, drawing_size).into_drawing_area();
        (draw(&root).and_then(|()| Ok(root.present()?)))
            .map_err(|error| PictureError::Plot(error.to_string()))?;
    }
    let text = |(width, height): (u32, u32)| format!("width=\"{width}\" height=\"{height}\"");
    Ok(svg.replacen(&text(drawing_size), &text(size), 1))
}

/// Colours of a rectangle, row by row from above: red, green, blue and opacity.
pub struct Raster {
    /// Number of columns.
    pub columns: usize,
    /// Number of rows.
    pub rows: usize,
    /// Four numbers per cell.
    pub colours: Vec<u8>,
}

/// The same picture on white, with a raster below all that was drawn, over a range of drawing
/// units.
///
/// The centres of the outer cells lie on the edges of the range; what is beyond is not shown.
///
/// # Errors
/// [`PictureError::Plot`] if the raster cannot be written as PNG.
pub fn over_raster(
    svg: &str,
    raster: &Raster,
    (x, y): (Range<i32>, Range<i32>),
) -> Result<String, PictureError> {
    let failed = |error: png::EncodingError| PictureError::Plot(error.to_string());
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, raster.columns as u32, raster.rows as u32);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(&raster.colours).map_err(failed)?;
    writer.finish().map_err(failed)?;
    let [width, height] = [&x, &y].map(|range| f64::from(range.end - range.start));
    let cell = [
        width / (raster.columns - 1) as f64,
        height / (raster.rows - 1) as f64,
    ];
    let below = format!(
        "<rect width=\"100%\" height=\"100%\" fill=\"#FFFFFF\"/>\n\
         <svg x=\"{}\" y=\"{}\" width=\"{width}\" height=\"{height}\">\
         <image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" \
         href=\"data:image/png;base64,{}\"/></svg>\n",
        x.start,
        y.start,
        -0.5 * cell[0],
        -0.5 * cell[1],
        width + cell[0],
        height + cell[1],
        STANDARD.encode(file),
    );
    let start = svg.find('>').map_or(0, |end| end + 1);
    let (head, rest) = svg.split_at(start);
    Ok(format!("{head}\n{below}{rest}"))
}
