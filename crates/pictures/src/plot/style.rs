//! Colours, sizes and fonts of the plots, and names of directions.

use nalgebra::Vector3;
use plotters::chart::MeshStyle;
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use crate::numbers::rounded;

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
pub const GRID_COLOUR: RGBColor = RGBColor(225, 225, 225);
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

/// Axes with labels and thin lines of a grid.
pub fn grid_style(style: &mut MeshStyle<RangedCoordf64, RangedCoordf64, SVGBackend>) {
    style
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID_COLOUR.stroke_width(px(1)))
        .axis_style(INK.stroke_width(px(1)))
        .label_style(font(14, &INK));
}

/// Smallest and largest of some values.
pub fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
        (low.min(v), high.max(v))
    })
}

/// A number with at most five digits.
pub fn short(value: f64) -> String {
    let rounded = format!("{value:.4e}").parse::<f64>().unwrap_or(value);
    format!("{rounded}")
}

/// The map viridis of matplotlib (van der Walt & Smith 2015) at equal steps: its lightness
/// increases evenly, so that colour-blind readers and grey prints keep the order.
const VIRIDIS: [[u8; 3]; 16] = [
    [0x44, 0x01, 0x54],
    [0x48, 0x1a, 0x6c],
    [0x47, 0x2f, 0x7d],
    [0x41, 0x44, 0x87],
    [0x39, 0x56, 0x8c],
    [0x31, 0x68, 0x8e],
    [0x2a, 0x78, 0x8e],
    [0x23, 0x88, 0x8e],
    [0x1f, 0x98, 0x8b],
    [0x22, 0xa8, 0x84],
    [0x35, 0xb7, 0x79],
    [0x54, 0xc5, 0x68],
    [0x7a, 0xd1, 0x51],
    [0xa5, 0xdb, 0x36],
    [0xd2, 0xe2, 0x1b],
    [0xfd, 0xe7, 0x25],
];

/// The colour for a value from 0 to 1; other values have that of the nearer end.
pub fn viridis(value: f64) -> RGBColor {
    let last = VIRIDIS.len() - 1;
    let place = value.clamp(0.0, 1.0) * last as f64;
    let below = (place as usize).min(last - 1);
    let share = place - below as f64;
    let [red, green, blue] = std::array::from_fn(|k| {
        let [a, b] = [below, below + 1].map(|step| f64::from(VIRIDIS[step][k]));
        (a + share * (b - a)).round() as u8
    });
    RGBColor(red, green, blue)
}

/// The name of a direction: a coordinate or the unit vector.
pub fn direction_name(e: &Vector3<f64>) -> String {
    let axes = [
        ("x", Vector3::x()),
        ("y", Vector3::y()),
        ("z", Vector3::z()),
    ];
    match axes.into_iter().find(|(_, axis)| (e - axis).amax() < 5e-3) {
        Some((name, _)) => name.to_owned(),
        None => {
            let [x, y, z] = [e.x, e.y, e.z].map(|c| rounded(c, 2));
            format!("({x:.2}, {y:.2}, {z:.2})")
        }
    }
}

/// A place in pixels.
pub fn at(x: u32, y: u32) -> (i32, i32) {
    (px(x) as i32, px(y) as i32)
}
