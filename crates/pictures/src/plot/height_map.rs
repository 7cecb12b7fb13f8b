//! Height functions: the curvature of the connection over two joints, with a stroke.

use models::ShapeGeometry;
use plotters::prelude::*;

use super::canvas;
use super::style::{Area, GRID_COLOUR, INK, font, px};
use crate::error::PictureError;

/// Number of coloured cells along each axis.
const CELLS: usize = 48;

/// Size of one panel in pixels.
const PANEL: (u32, u32) = (480, 440);

/// Names of the components of the curvature.
const COMPONENTS: [&str; 6] = ["x", "y", "z", "rotation x", "rotation y", "rotation z"];

/// Size below which a component counts as zero, relative to the largest one.
const ZERO: f64 = 1e-6;

/// Draws the components of the curvature that are not zero, one panel per component.
///
/// The axes are the first two joints of the table, the other joints have the middle of their
/// ranges. `names` are those of the joints, `stroke` is a curve of shapes. Displacement per area of
/// a small stroke, anticlockwise: orange is positive, blue negative.
///
/// # Errors
/// A table of one joint, [`PictureError::Plot`].
pub fn height_map_svg(
    geometry: &ShapeGeometry,
    names: &[String],
    stroke: &[Vec<f64>],
) -> Result<String, PictureError> {
    let ranges = geometry.ranges();
    if ranges.len() < 2 {
        return Err(PictureError::Plot(
            "a map needs two joints that move".to_owned(),
        ));
    }
    let middle = ranges
        .iter()
        .map(|r| 0.5 * (r.0 + r.1))
        .collect::<Vec<f64>>();
    let centre = |axis: usize, k: usize| {
        let (from, to) = ranges[axis];
        from + (to - from) * (k as f64 + 0.5) / CELLS as f64
    };
    let mut cells = Vec::with_capacity(CELLS * CELLS);
    for row in 0..CELLS {
        for column in 0..CELLS {
            let mut shape = middle.clone();
            (shape[0], shape[1]) = (centre(0, column), centre(1, row));
            cells.push(geometry.at(&shape)?.curvature(0, 1));
        }
    }
    let largest = |c: usize| {
        cells
            .iter()
            .fold(0.0_f64, |largest, cell| largest.max(cell[c].abs()))
    };
    let scale = (0..6).map(largest).fold(0.0, f64::max);
    let components: Vec<usize> = (0..6).filter(|&c| largest(c) > ZERO * scale).collect();
    let size = (PANEL.0 * components.len().max(1) as u32, PANEL.1);
    canvas::svg(size, |root| {
        let panels = root.split_evenly((1, components.len().max(1)));
        for (panel, &component) in panels.iter().zip(&components) {
            let values: Vec<f64> = cells.iter().map(|cell| cell[component]).collect();
            draw(panel, ranges, names, &values, COMPONENTS[component], stroke)?;
        }
        Ok(())
    })
}

fn draw(
    area: &Area,
    ranges: &[(f64, f64)],
    names: &[String],
    values: &[f64],
    component: &str,
    stroke: &[Vec<f64>],
) -> Result<(), Box<dyn std::error::Error>> {
    let (x, y) = (ranges[0], ranges[1]);
    let largest = values
        .iter()
        .fold(0.0_f64, |largest, v| largest.max(v.abs()));
    let title = format!(
        "{component} per area, from {:.2e} to {largest:.2e}",
        -largest
    );
    let mut chart = ChartBuilder::on(area)
        .margin(px(12))
        .caption(title, font(15, &INK))
        .x_label_area_size(px(42))
        .y_label_area_size(px(62))
        .build_cartesian_2d(x.0..x.1, y.0..y.1)?;
    chart
        .configure_mesh()
        .disable_mesh()
        .axis_style(INK.stroke_width(px(1)))
        .label_style(font(13, &INK))
        .x_desc(&names[0][..])
        .y_desc(&names[1][..])
        .draw()?;
    let edge = |(from, to): (f64, f64), k: usize| from + (to - from) * k as f64 / CELLS as f64;
    chart.draw_series(values.iter().enumerate().map(|(number, value)| {
        let (row, column) = (number / CELLS, number % CELLS);
        let corners = [
            (edge(x, column), edge(y, row)),
            (edge(x, column + 1), edge(y, row + 1)),
        ];
        Rectangle::new(corners, colour(value / largest).filled())
    }))?;
    let curve = stroke.iter().map(|shape| (shape[0], shape[1]));
    chart.draw_series(LineSeries::new(curve, INK.stroke_width(px(2))))?;
    if let Some(start) = stroke.first() {
        let dot = Circle::new((start[0], start[1]), px(4) as i32, INK.filled());
        chart.draw_series([dot])?;
    }
    Ok(())
}

/// Blue for -1, light for 0, orange for 1.
fn colour(value: f64) -> RGBColor {
    const ENDS: [(f64, f64, f64); 2] = [(0.0, 114.0, 178.0), (213.0, 94.0, 0.0)];
    let end = if value < 0.0 { ENDS[0] } else { ENDS[1] };
    let share = value.abs().min(1.0);
    let mix = |light: u8, end: f64| (f64::from(light) + share * (end - f64::from(light))) as u8;
    RGBColor(
        mix(GRID_COLOUR.0, end.0),
        mix(GRID_COLOUR.1, end.1),
        mix(GRID_COLOUR.2, end.2),
    )
}
