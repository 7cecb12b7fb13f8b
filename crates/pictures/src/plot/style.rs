//! Colours, sizes and fonts of the plot.

use plotters::coord::Shift;
use plotters::prelude::*;

/// Colours of the bodies: the palette of Okabe & Ito (2008), which colour-blind readers can
/// distinguish.
pub const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(40, 40, 40),
];

/// The colour of a body, or of another series, as in style sheets.
pub fn body_colour(number: usize) -> String {
    let RGBColor(red, green, blue) = COLOURS[number % COLOURS.len()];
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Colour of text and axes.
pub const INK: RGBColor = RGBColor(40, 40, 40);
/// Colour of secondary text and joints.
pub const GREY: RGBColor = RGBColor(110, 110, 110);
/// Colour of grid lines.
pub const FAINT: RGBColor = RGBColor(225, 225, 225);
/// Background of every second phase.
pub const BAND: RGBColor = RGBColor(246, 246, 246);

/// Size of the plot in pixels.
pub const SIZE: (u32, u32) = (960, 760);

/// Drawing units per pixel: the plotting library rounds to whole units, and curves must stay
/// smooth.
pub const UNITS_PER_PIXEL: u32 = 4;

/// A part of the plot.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Converts pixels to drawing units.
pub const fn px(pixels: u32) -> u32 {
    UNITS_PER_PIXEL * pixels
}

/// The font with a size in pixels.
pub fn font(pixels: u32, colour: &'static RGBColor) -> TextStyle<'static> {
    ("sans-serif", px(pixels)).into_font().color(colour)
}

/// A number with at most five digits.
pub fn short(value: f64) -> String {
    let rounded = format!("{value:.4e}").parse::<f64>().unwrap_or(value);
    format!("{rounded}")
}
