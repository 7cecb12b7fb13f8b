//! The objective of `swim sizes` against the sizes.

use plotters::prelude::*;

use super::canvas;
use super::style::{Area, COLOURS, INK, SIZE, at, font, grid_style, px, range, short};
use crate::error::PictureError;

/// Height of a panel in pixels.
const PANEL: u32 = 420;

/// The objective along a line on which one size changes.
#[derive(Clone, Debug)]
pub struct SliceCurve<'a> {
    /// Name of the size, which begins with `radius` or `length`.
    pub name: &'a str,
    /// Values of the size.
    pub values: &'a [f64],
    /// The objective at the values.
    pub objectives: &'a [f64],
    /// Its error bars.
    pub errors: &'a [f64],
    /// Number of the best value.
    pub best: usize,
}

/// Draws the objective along lines through the best sizes, with error bars and a circle at the best
/// value of each: a panel for radii and one for lengths.
///
/// # Errors
/// [`PictureError::Plot`].
pub fn size_slices_svg(slices: &[SliceCurve], objective: &str) -> Result<String, PictureError> {
    let panels: Vec<(&str, Vec<&SliceCurve>)> = ["radius", "length"]
        .into_iter()
        .map(|kind| {
            let is_of_kind = |slice: &&SliceCurve| slice.name.starts_with(kind);
            (kind, slices.iter().filter(is_of_kind).collect::<Vec<_>>())
        })
        .filter(|(_, slices)| !slices.is_empty())
        .collect();
    let height = PANEL * panels.len().max(1) as u32;
    canvas::svg((SIZE.0, height), |root| {
        let areas = root.split_evenly((panels.len().max(1), 1));
        for (area, (kind, slices)) in areas.iter().zip(&panels) {
            draw(area, kind, slices, objective)?;
        }
        Ok(())
    })
}

fn draw(
    area: &Area,
    kind: &str,
    slices: &[&SliceCurve],
    objective: &str,
) -> Result<(), Box<dyn std::error::Error>> {
    let (left, right) = range(slices.iter().flat_map(|slice| slice.values.iter().copied()));
    let (low, high) = range(slices.iter().flat_map(|slice| {
        let pairs = slice.objectives.iter().zip(slice.errors);
        pairs.flat_map(|(y, bar)| [y - bar, y + bar])
    }));
    let (side, margin) = (0.03 * (right - left), 0.08 * (high - low).max(1e-300));
    let mut chart = ChartBuilder::on(area)
        .margin(px(14))
        .caption(
            match kind {
                "radius" => {
                    "the best radii, and one of them changed; the sum of the volumes is kept"
                }
                _ => "the best arms, and one of them changed; the sum of the lengths is kept",
            },
            font(16, &INK),
        )
        .x_label_area_size(px(46))
        .y_label_area_size(px(100))
        .build_cartesian_2d(left - side..right + side, low - margin..high + 3.0 * margin)?;
    let mut axes = chart.configure_mesh();
    grid_style(&mut axes);
    axes.x_desc(kind)
        .y_desc(objective)
        .y_label_formatter(&|y| short(*y))
        .draw()?;
    for (number, slice) in slices.iter().enumerate() {
        let colour = &COLOURS[number % COLOURS.len()];
        let pairs = || slice.values.iter().zip(slice.objectives);
        let points = || pairs().map(|(x, y)| (*x, *y));
        chart.draw_series(LineSeries::new(points(), colour.stroke_width(px(2))))?;
        chart.draw_series(points().zip(slice.errors).map(|((x, y), bar)| {
            PathElement::new(vec![(x, y - bar), (x, y + bar)], colour.stroke_width(px(2)))
        }))?;
        let best = (slice.values[slice.best], slice.objectives[slice.best]);
        chart.draw_series([Circle::new(best, px(6), colour.stroke_width(px(2)))])?;
        let label = format!("{} = {}", slice.name, short(best.0));
        let place = at(120, 44 + 20 * number as u32);
        area.draw(&Text::new(label, place, font(14, colour)))?;
    }
    Ok(())
}
