//! The colour bar beside a map.

use std::ops::Range;

use plotters::prelude::*;

use super::style::{Area, INK, font, px};

/// Number of steps of the bar.
pub const STEPS: usize = 128;

/// Space around a colour bar in pixels.
pub struct BarSpace {
    /// To the left of the bar.
    pub left: u32,
    pub above: u32,
    pub below: u32,
    /// Width of the labels to the right, and the size of their font.
    pub labels: u32,
    pub font: u32,
}

/// Draws a bar with the colours of shares from 0 to 1, which `range` are coordinates of, and labels
/// at coordinates.
pub fn draw_colour_bar(
    area: &Area,
    space: &BarSpace,
    range: Range<f64>,
    colour: impl Fn(f64) -> RGBColor,
    label: &dyn Fn(f64) -> String,
) -> Result<(), Box<dyn std::error::Error>> {
    let (low, high) = (range.start, range.end);
    let mut chart = ChartBuilder::on(area)
        .margin_left(px(space.left))
        .margin_top(px(space.above))
        .margin_bottom(px(space.below))
        .right_y_label_area_size(px(space.labels))
        .build_cartesian_2d(0.0..1.0, range)?;
    chart.draw_series((0..STEPS).map(|k| {
        let share = |place: f64| place / STEPS as f64;
        let below = low + (high - low) * share(k as f64);
        // Up to the upper end, below the steps that follow: no gaps by rounding.
        let corners = [(0.0, below), (1.0, high)];
        Rectangle::new(corners, colour(share(k as f64 + 0.5)).filled())
    }))?;
    chart
        .configure_mesh()
        .disable_mesh()
        .disable_x_axis()
        .axis_style(INK.stroke_width(px(1)))
        .set_all_tick_mark_size(px(5))
        .label_style(font(space.font, &INK))
        .y_label_formatter(&|coordinate| label(*coordinate))
        .draw()?;
    Ok(())
}
