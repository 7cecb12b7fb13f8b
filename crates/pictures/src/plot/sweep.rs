//! The results of `swim sweep`: curves with error bars, or a map over two keys.

use std::collections::BTreeMap;

use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::canvas;
use super::colour_bar::{BarSpace, draw_colour_bar};
use super::style::{Area, COLOURS, INK, at, font, grid_style, px, range, short, viridis};
use crate::error::PictureError;

/// Size of a panel in pixels.
const PANEL: (u32, u32) = (840, 460);

/// Ratio of the largest to the smallest value from which an axis is logarithmic.
const LOGARITHMIC: f64 = 50.0;

/// Largest number of curves over the first of two keys with numbers; more points are dots whose
/// colour is the result, over both keys.
const MAX_CURVES: usize = 4;

/// Results at points, each with values of the same keys.
#[derive(Clone, Debug)]
pub struct SweptPoints<'a> {
    /// Names of the keys.
    pub keys: &'a [String],
    /// One list of values per point, in words.
    pub points: Vec<&'a [String]>,
    /// Result at each point.
    pub results: Vec<f64>,
    /// Error bars of the results; zero where there is none.
    pub bars: Vec<f64>,
    /// What the result is.
    pub label: String,
}

/// Draws results over the first key that has numbers, a curve for each combination of the others;
/// over two keys that have numbers and are combined with each other a map, else dots with colours
/// where there would be more than four curves; and single points, a
/// panel for each key, where there are more curves than colours.
///
/// # Errors
/// [`PictureError::Plot`], also without results or without a key that has numbers.
pub fn sweep_svg(swept: &SweptPoints) -> Result<String, PictureError> {
    let refuse = |problem: &str| Err(PictureError::Plot(problem.to_owned()));
    if swept.results.is_empty() {
        return refuse("no run of the sweep has a result");
    }
    let axes: Vec<Axis> = (0..swept.keys.len())
        .filter_map(|key| Axis::new(swept, key))
        .collect();
    if let [x, y] = &axes[..]
        && swept.keys.len() == 2
        && x.centres.len() > 1
        && y.centres.len() > 1
        && (is_grid(swept, x, y) || x.curves(swept).len() > MAX_CURVES)
    {
        return canvas::svg(PANEL, |root| draw_map(root, swept, x, y));
    }
    let Some(x) = axes.first() else {
        return refuse("no key of the sweep has numbers");
    };
    let curves = x.curves(swept);
    if curves.len() <= COLOURS.len() {
        return canvas::svg(PANEL, |root| draw_panel(root, swept, x, &curves, true));
    }
    let size = (PANEL.0, PANEL.1 * axes.len() as u32);
    canvas::svg(size, |root| {
        for (area, axis) in root.split_evenly((axes.len(), 1)).iter().zip(&axes) {
            let all = BTreeMap::from([(String::new(), (0..swept.results.len()).collect())]);
            draw_panel(area, swept, axis, &all, false)?;
        }
        Ok(())
    })
}

/// A key whose values are numbers.
struct Axis<'a> {
    key: usize,
    name: &'a str,
    /// Values on the axis: logarithms, if it is logarithmic.
    values: Vec<f64>,
    /// The different values, in ascending order.
    centres: Vec<f64>,
    is_logarithmic: bool,
}

impl<'a> Axis<'a> {
    /// None if some value is no number.
    fn new(swept: &SweptPoints<'a>, key: usize) -> Option<Self> {
        let values = swept.points.iter().map(|point| point[key].parse().ok());
        let mut values: Vec<f64> = values.collect::<Option<_>>()?;
        let (low, high) = range(values.iter().copied());
        let is_logarithmic = low > 0.0 && high > LOGARITHMIC * low;
        if is_logarithmic {
            values.iter_mut().for_each(|value| *value = value.log10());
        }
        let mut centres = values.clone();
        centres.sort_by(f64::total_cmp);
        centres.dedup();
        Some(Self {
            key,
            name: &swept.keys[key],
            values,
            centres,
            is_logarithmic,
        })
    }

    /// The text at a place on the axis.
    fn text(&self, place: f64) -> String {
        match self.is_logarithmic {
            true => format!("{:.2e}", 10_f64.powf(place)),
            false => short(place),
        }
    }

    /// Points with the same values of the other keys, in the order of this one.
    fn curves(&self, swept: &SweptPoints) -> BTreeMap<String, Vec<usize>> {
        let mut curves: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        for (number, point) in swept.points.iter().enumerate() {
            let others = point.iter().zip(swept.keys).enumerate();
            let words: Vec<String> = others
                .filter(|(key, _)| *key != self.key)
                .map(|(_, (value, key))| format!("{key} = {value}"))
                .collect();
            curves.entry(words.join(", ")).or_default().push(number);
        }
        for numbers in curves.values_mut() {
            numbers.sort_by(|a, b| self.values[*a].total_cmp(&self.values[*b]));
        }
        curves
    }

    /// Edges of cells around the different values: halfway between neighbours.
    fn edges(&self) -> Vec<f64> {
        let centres = &self.centres;
        let (first, last) = (0, centres.len() - 1);
        let half = |k: usize| 0.5 * (centres[k + 1] - centres[k]);
        let inner = (0..last).map(|k| centres[k] + half(k));
        std::iter::once(centres[first] - half(first))
            .chain(inner)
            .chain([centres[last] + half(last - 1)])
            .collect()
    }
}

/// A range around values, with a margin, that is not empty.
fn around((low, high): (f64, f64), margin: f64) -> std::ops::Range<f64> {
    let width = match high > low {
        true => high - low,
        false => low.abs().max(1e-300),
    };
    low - margin * width..high + margin * width
}

fn draw_panel(
    area: &Area,
    swept: &SweptPoints,
    x: &Axis,
    curves: &BTreeMap<String, Vec<usize>>,
    has_lines: bool,
) -> Result<(), Box<dyn std::error::Error>> {
    let ends = swept.results.iter().zip(&swept.bars);
    let y = range(ends.flat_map(|(y, bar)| [y - bar, y + bar]));
    let x_range = around(range(x.values.iter().copied()), 0.03);
    let mut chart = ChartBuilder::on(area)
        .margin(px(14))
        .margin_top(px(24 + 18 * curves.len() as u32))
        .x_label_area_size(px(46))
        .y_label_area_size(px(100))
        .build_cartesian_2d(x_range, around(y, 0.08))?;
    configure(&mut chart, x, &swept.label, &short)?;
    for (number, (label, points)) in curves.iter().enumerate() {
        let colour = &COLOURS[number % COLOURS.len()];
        let place = |&point: &usize| (x.values[point], swept.results[point]);
        if has_lines {
            let line = points.iter().map(place);
            chart.draw_series(LineSeries::new(line, colour.stroke_width(px(2))))?;
        }
        chart.draw_series(points.iter().map(|point| {
            let ((x, y), bar) = (place(point), swept.bars[*point]);
            PathElement::new(vec![(x, y - bar), (x, y + bar)], colour.stroke_width(px(2)))
        }))?;
        let dots = points.iter().map(place);
        chart.draw_series(dots.map(|dot| Circle::new(dot, px(3), colour.filled())))?;
        let style = font(14, colour);
        area.draw(&Text::new(
            label.clone(),
            at(118, 14 + 18 * number as u32),
            style,
        ))?;
    }
    Ok(())
}

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

fn configure(
    chart: &mut Chart,
    x: &Axis,
    y_label: &str,
    y_text: &dyn Fn(f64) -> String,
) -> Result<(), Box<dyn std::error::Error>> {
    let mut axes = chart.configure_mesh();
    grid_style(&mut axes);
    axes.x_desc(x.name)
        .y_desc(y_label)
        .x_label_formatter(&|place| x.text(*place))
        .y_label_formatter(&|place| y_text(*place))
        .draw()?;
    Ok(())
}

/// Whether the points are combinations of values, of which at most half failed.
fn is_grid(swept: &SweptPoints, x: &Axis, y: &Axis) -> bool {
    x.centres.len() * y.centres.len() <= 2 * swept.results.len()
}

/// A map, or dots where the points are no grid.
fn draw_map(
    area: &Area,
    swept: &SweptPoints,
    x: &Axis,
    y: &Axis,
) -> Result<(), Box<dyn std::error::Error>> {
    let (low, high) = range(swept.results.iter().copied());
    let share = |value: f64| match high > low {
        true => (value - low) / (high - low),
        false => 0.5,
    };
    let (map, bar) = area.split_horizontally(px(PANEL.0 - 130));
    let is_grid = is_grid(swept, x, y);
    let [x_edges, y_edges] = [x, y].map(Axis::edges);
    let span = |edges: &[f64], axis: &Axis| match is_grid {
        true => edges[0]..edges[edges.len() - 1],
        false => around(range(axis.values.iter().copied()), 0.05),
    };
    let mut chart = ChartBuilder::on(&map)
        .margin(px(14))
        .caption(&swept.label, font(16, &INK))
        .x_label_area_size(px(46))
        .y_label_area_size(px(84))
        .build_cartesian_2d(span(&x_edges, x), span(&y_edges, y))?;
    configure(&mut chart, x, y.name, &|place| y.text(place))?;
    let cell = |edges: &[f64], value: f64| {
        let above = edges.partition_point(|edge| *edge <= value);
        let above = above.clamp(1, edges.len() - 1);
        (edges[above - 1], edges[above])
    };
    let results = || swept.results.iter().enumerate();
    if !is_grid {
        chart.draw_series(results().map(|(point, result)| {
            let colour = viridis(share(*result)).filled();
            Circle::new((x.values[point], y.values[point]), px(7), colour)
        }))?;
        chart.draw_series(results().map(|(point, _)| {
            Circle::new(
                (x.values[point], y.values[point]),
                px(7),
                INK.stroke_width(1),
            )
        }))?;
    }
    chart.draw_series(results().filter(|_| is_grid).map(|(point, result)| {
        let (left, right) = cell(&x_edges, x.values[point]);
        let (below, top) = cell(&y_edges, y.values[point]);
        Rectangle::new(
            [(left, below), (right, top)],
            viridis(share(*result)).filled(),
        )
    }))?;
    let space = BarSpace {
        left: 14,
        above: 44,
        below: 60,
        labels: 98,
        font: 14,
    };
    draw_colour_bar(
        &bar,
        &space,
        around((low, high), 0.0),
        viridis,
        (&short, None),
    )
}

#[cfg(test)]
mod tests {
    use super::super::colour_bar::STEPS;
    use super::*;

    fn points(texts: &[[&str; 2]]) -> Vec<[String; 2]> {
        texts.iter().map(|p| p.map(str::to_owned)).collect()
    }

    fn draw(points: &[[String; 2]]) -> Result<String, PictureError> {
        let keys = ["a.x".to_owned(), "b".to_owned()];
        sweep_svg(&SweptPoints {
            keys: &keys,
            points: points.iter().map(|point| &point[..]).collect(),
            results: (0..points.len()).map(|k| k as f64).collect(),
            bars: vec![0.1; points.len()],
            label: "net displacement".to_owned(),
        })
    }

    #[test]
    fn two_keys_with_numbers_are_a_map_and_words_are_curves() {
        let grid = points(&[["1", "5"], ["1", "6"], ["2", "5"], ["2", "6"]]);
        let map = draw(&grid).unwrap();
        assert!(
            map.matches("<rect").count() > 4 + STEPS,
            "cells and colours"
        );
        let words = points(&[
            ["1", "rpy"],
            ["1", "oseen"],
            ["100", "rpy"],
            ["100", "oseen"],
        ]);
        let curves = draw(&words).unwrap();
        assert!(curves.contains("b = oseen") && curves.contains("b = rpy"));
        assert_eq!(curves.matches("<circle").count(), 4);
        assert!(curves.contains("1.00e1"), "a logarithmic axis");
        assert!(draw(&points(&[["x", "y"]])).is_err(), "no numbers");
        assert!(draw(&[]).is_err(), "no results");
        // A grid with a run that failed is a map, points at random are dots.
        let part = draw(&grid[..3]).unwrap();
        assert!(
            part.matches("<rect").count() > 3 + STEPS,
            "cells and colours"
        );
        let random = ["1", "2", "3", "4", "5", "6"].map(|x| [x, x]);
        let dots = draw(&points(&random)).unwrap();
        assert_eq!(dots.matches("<circle").count(), 12, "each with its outline");
        assert!(dots.matches("<rect").count() > STEPS, "a colour bar");
        // One point, and equal results, make no empty axes.
        draw(&points(&[["1", "5"]])).unwrap();
    }
}
