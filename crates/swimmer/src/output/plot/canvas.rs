//! A picture as SVG text.

use plotters::prelude::*;

use super::style::{Area, UNITS_PER_PIXEL};
use crate::error::SwimError;

/// Draws on an area of `size` pixels.
///
/// # Errors
/// [`SwimError::Plot`] with the reason given by the plotting library.
pub fn svg(
    size: (u32, u32),
    draw: impl FnOnce(&Area) -> Result<(), Box<dyn std::error::Error>>,
) -> Result<String, SwimError> {
    let mut svg = String::new();
    let drawing_size = (UNITS_PER_PIXEL * size.0, UNITS_PER_PIXEL * size.1);
    {
        let root = SVGBackend::with_string(&mut svg, drawing_size).into_drawing_area();
        draw(&root).map_err(|error| SwimError::Plot(error.to_string()))?;
    }
    let text = |(width, height): (u32, u32)| format!("width=\"{width}\" height=\"{height}\"");
    Ok(svg.replacen(&text(drawing_size), &text(size), 1))
}
