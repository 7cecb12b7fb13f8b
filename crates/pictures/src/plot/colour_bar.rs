//! The colour bar beside a map.

use std::ops::Range;

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::coord::types::RangedCoordf64;
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

/// Largest number of labels at even distances.
const LABELS: usize = 11;

/// Decimal logarithms of the round numbers in a range of them: 1, 2 and 5 times powers of ten, or
/// those of all first digits where there are fewer than three of these; none if these are fewer
/// than two.
pub fn logarithmic_labels(range: &Range<f64>) -> Option<Vec<f64>> {
    let decades = range.start.floor() as i32..=range.end.floor() as i32;
    let of_digits = |digits: &[f64]| -> Vec<f64> {
        let all = decades.clone().flat_map(|decade| {
            let logarithm = move |digit: &f64| f64::from(decade) + digit.log10();
            digits.iter().map(logarithm).collect::<Vec<_>>()
        });
        all.filter(|place| range.contains(place)).collect()
    };
    let few = of_digits(&[1.0, 2.0, 5.0]);
    if few.len() > 2 {
        return Some(few);
    }
    let all = of_digits(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
    (all.len() > 1).then_some(all)
}

/// An axis with labels at these coordinates.
struct LabelledAxis {
    axis: RangedCoordf64,
    labels: Vec<f64>,
}

impl Ranged for LabelledAxis {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.axis.map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.labels.clone()
    }

    fn range(&self) -> Range<f64> {
        self.axis.range()
    }
}

/// Draws a bar with the colours of shares from 0 to 1, which `range` are coordinates of, and labels
/// at the coordinates `labels`, else at even distances.
pub fn draw_colour_bar(
    area: &Area,
    space: &BarSpace,
    range: Range<f64>,
    colour: impl Fn(f64) -> RGBColor,
    (label, labels): (&dyn Fn(f64) -> String, Option<Vec<f64>>),
) -> Result<(), Box<dyn std::error::Error>> {
    let (low, high) = (range.start, range.end);
    let axis = RangedCoordf64::from(range);
    let labels = labels.unwrap_or_else(|| axis.key_points(LABELS));
    let mut chart = ChartBuilder::on(area)
        .margin_left(px(space.left))
        .margin_top(px(space.above))
        .margin_bottom(px(space.below))
        .right_y_label_area_size(px(space.labels))
        .build_cartesian_2d(0.0..1.0, LabelledAxis { axis, labels })?;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bug_labels_of_logarithmic_bars_were_no_round_numbers() {
        let values = |low: f64, high: f64| {
            let labels = logarithmic_labels(&(low.log10()..high.log10()))?;
            let words = labels
                .iter()
                .map(|place| format!("{:.2}", 10_f64.powf(*place)));
            Some(words.collect::<Vec<_>>().join(" "))
        };
        let found = [(0.04, 1.1), (0.31, 0.83), (0.31, 0.32)].map(|(low, high)| values(low, high));
        let expected = [
            Some("0.05 0.10 0.20 0.50 1.00"),
            Some("0.40 0.50 0.60 0.70 0.80"),
            None,
        ];
        assert_eq!(found, expected.map(|words| words.map(str::to_owned)));
    }
}
