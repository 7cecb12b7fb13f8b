//! Height functions: the curvature of the connection over two joints, with a stroke.

use models::ShapeGeometry;
use plotters::prelude::*;

use super::canvas;
use super::colour_bar::{BarSpace, draw_colour_bar};
use super::style::{Area, GRID_COLOUR, INK, font, px, short};
use crate::error::PictureError;

/// Number of coloured cells along each axis.
const CELLS: usize = 48;

/// Size of one panel in pixels.
const PANEL: (u32, u32) = (560, 440);

/// Width of the colour bar with its labels in pixels.
const BAR: u32 = 92;

/// Number of contours on each side of zero.
const CONTOURS: usize = 4;

/// Number of arrow heads along the stroke.
const ARROWS: usize = 4;

/// Names of the components of the curvature.
const COMPONENTS: [&str; 6] = ["x", "y", "z", "rotation x", "rotation y", "rotation z"];

/// Size below which a component counts as zero, relative to the largest one.
const ZERO: f64 = 1e-6;

/// Draws the components of the curvature that are not zero, one panel per component.
///
/// The axes are the first two joints of the table, the other joints have the middle of their
/// ranges. `names` are those of the joints, `stroke` is a curve of shapes. Displacement per area of
/// a small stroke, anticlockwise: orange is positive, blue negative. Contours divide the range from
/// zero to the largest size evenly; that of zero is thick. Arrows show the direction of the stroke.
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
    let (area, bar) = area.split_horizontally(px(PANEL.0 - BAR));
    let mut chart = ChartBuilder::on(&area)
        .margin(px(12))
        .caption(format!("{component} per area"), font(15, &INK))
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
        // Up to the upper ends, below the cells that follow: no gaps by rounding.
        let corners = [(edge(x, column), edge(y, row)), (x.1, y.1)];
        Rectangle::new(corners, colour(value / largest).filled())
    }))?;
    let place = |[a, b]: [f64; 2]| {
        let at =
            |(from, to): (f64, f64), cells: f64| from + (to - from) * (cells + 0.5) / CELLS as f64;
        (at(x, a), at(y, b))
    };
    for number in 0..=2 * CONTOURS {
        let level = largest * (number as f64 / CONTOURS as f64 - 1.0);
        let style = match number == CONTOURS {
            true => INK.stroke_width(px(2)),
            false => INK.mix(0.4).stroke_width(px(1)),
        };
        for ends in contour(values, level) {
            chart.draw_series([PathElement::new(ends.map(place).to_vec(), style)])?;
        }
    }
    let curve = stroke.iter().map(|shape| (shape[0], shape[1]));
    chart.draw_series(LineSeries::new(curve, INK.stroke_width(px(2))))?;
    if let Some(start) = stroke.first() {
        let dot = Circle::new((start[0], start[1]), px(4) as i32, INK.filled());
        chart.draw_series([dot])?;
    }
    for head in arrow_heads(stroke, [x, y]) {
        chart.draw_series([Polygon::new(head.to_vec(), INK.filled())])?;
    }
    let space = BarSpace {
        left: 0,
        above: 40,
        below: 54,
        labels: 70,
        font: 13,
    };
    let of_share = |share: f64| colour(2.0 * share - 1.0);
    draw_colour_bar(&bar, &space, -largest..largest, of_share, (&short, None))
}

/// The straight pieces of a contour, in cells of the grid of values, by linear interpolation along
/// the edges between four neighbours.
fn contour(values: &[f64], level: f64) -> Vec<[[f64; 2]; 2]> {
    let mut pieces = Vec::new();
    for (row, column) in (0..CELLS - 1).flat_map(|row| (0..CELLS - 1).map(move |c| (row, c))) {
        let corners = [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(up, right)| {
            let (row, column) = (row + up, column + right);
            (
                [column as f64, row as f64],
                values[row * CELLS + column] - level,
            )
        });
        let crossings = (0..4).filter_map(|k| {
            let ((a, from), (b, to)) = (corners[k], corners[(k + 1) % 4]);
            let share = from / (from - to);
            ((from > 0.0) != (to > 0.0)).then(|| [0, 1].map(|c| a[c] + share * (b[c] - a[c])))
        });
        let crossings: Vec<[f64; 2]> = crossings.collect();
        pieces.extend(crossings.chunks_exact(2).map(|ends| [ends[0], ends[1]]));
    }
    pieces
}

/// Triangles along a stroke, at equal numbers of its shapes, in its direction.
fn arrow_heads(
    stroke: &[Vec<f64>],
    ranges: [(f64, f64); 2],
) -> impl Iterator<Item = [(f64, f64); 3]> + '_ {
    /// Half of the width, relative to the ranges.
    const HALF_WIDTH: f64 = 0.012;
    let sizes = ranges.map(|(from, to)| to - from);
    (0..ARROWS).filter_map(move |number| {
        let at = stroke.len() * (2 * number + 1) / (2 * ARROWS);
        let (from, to) = (stroke.get(at)?, stroke.get(at + 1)?);
        let [dx, dy] = [0, 1].map(|k| (to[k] - from[k]) / sizes[k]);
        let length = dx.hypot(dy);
        let corner = |ahead: f64, aside: f64| {
            let [ahead, aside] = [ahead, aside].map(|part| part * HALF_WIDTH / length);
            let offset = [ahead * dx - aside * dy, ahead * dy + aside * dx];
            (to[0] + sizes[0] * offset[0], to[1] + sizes[1] * offset[1])
        };
        (length > 0.0).then(|| [corner(2.2, 0.0), corner(-1.2, 1.0), corner(-1.2, -1.0)])
    })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contours_are_where_the_values_have_their_level_and_arrows_follow_the_stroke() {
        // Columns from zero on: the contour of 3.25 is a vertical line.
        let values: Vec<f64> = (0..CELLS * CELLS).map(|k| (k % CELLS) as f64).collect();
        let pieces = contour(&values, 3.25);
        assert_eq!(pieces.len(), CELLS - 1);
        assert!(
            pieces
                .iter()
                .flatten()
                .all(|[x, _]| (x - 3.25).abs() < 1e-12)
        );
        assert!(contour(&values, -1.0).is_empty());
        let stroke: Vec<Vec<f64>> = (0..=8).map(|k| vec![f64::from(k), 2.0]).collect();
        let heads: Vec<_> = arrow_heads(&stroke, [(0.0, 8.0), (0.0, 4.0)]).collect();
        assert_eq!(heads.len(), ARROWS);
        assert!(
            heads
                .iter()
                .all(|[tip, back, _]| tip.0 > back.0 && tip.1 == 2.0)
        );
        assert!(arrow_heads(&[], [(0.0, 1.0); 2]).next().is_none());
    }
}
