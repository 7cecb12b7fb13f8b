//! Log-log charts as SVG.

use anyhow::{Result, anyhow};
use plotters::coord::combinators::IntoLogRange;
use plotters::prelude::*;

/// Palette of Okabe & Ito (2008), whose colours colour-blind readers can distinguish.
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(120, 94, 240),
    RGBColor(40, 40, 40),
];

const GRID_COLOUR: RGBColor = RGBColor(225, 225, 225);

/// Width and height of a chart.
const SIZE: (u32, u32) = (1180, 620);

/// Width of the chart without its legend, which is beside it so that it covers no points.
const CHART_WIDTH: u32 = 860;

/// Distance of two lines of the legend.
const LEGEND_LINE: i32 = 24;

/// Points with a name.
#[derive(Clone, Debug)]
pub struct Series {
    pub name: String,
    pub points: Vec<(f64, f64)>,
}

impl Series {
    pub fn new(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self {
            name: name.into(),
            points: points.into_iter().collect(),
        }
    }
}

/// A chart with two logarithmic axes and at most as many series as there are colours.
#[derive(Clone, Debug)]
pub struct LogLog {
    title: String,
    x: &'static str,
    y: &'static str,
    series: Vec<Series>,
    /// Whether the points of a series are joined by lines.
    has_lines: bool,
}

impl LogLog {
    pub fn new(
        title: impl Into<String>,
        [x, y]: [&'static str; 2],
        series: impl IntoIterator<Item = Series>,
        has_lines: bool,
    ) -> Self {
        Self {
            title: title.into(),
            x,
            y,
            series: series.into_iter().collect(),
            has_lines,
        }
    }

    /// Chart as SVG text, without points that are not positive and finite.
    pub fn svg(&self) -> Result<String> {
        let mut svg = String::new();
        self.draw(&mut svg)
            .map_err(|error| anyhow!("could not draw '{}': {error}", self.title))?;
        Ok(svg)
    }

    fn draw(&self, svg: &mut String) -> std::result::Result<(), Box<dyn std::error::Error>> {
        let shown = |&(x, y): &(f64, f64)| x > 0.0 && y > 0.0 && x.is_finite() && y.is_finite();
        let all = self.series.iter().flat_map(|series| &series.points);
        let all: Vec<(f64, f64)> = all.copied().filter(shown).collect();
        if all.is_empty() {
            return Err("there is no point to show".into());
        }
        let x_range = decades(all.iter().map(|point| point.0));
        let y_range = decades(all.iter().map(|point| point.1));
        let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let (plot, legend) = root.split_horizontally(CHART_WIDTH);
        let mut chart = ChartBuilder::on(&plot)
            .caption(&self.title, ("sans-serif", 20))
            .margin(14)
            .x_label_area_size(46)
            .y_label_area_size(70)
            .build_cartesian_2d(x_range.log_scale(), y_range.log_scale())?;
        chart
            .configure_mesh()
            .x_desc(self.x)
            .y_desc(self.y)
            .label_style(("sans-serif", 14))
            .x_label_formatter(&|x| power(*x))
            .y_label_formatter(&|y| power(*y))
            .bold_line_style(GRID_COLOUR)
            .light_line_style(WHITE)
            .draw()?;
        for (number, series) in self.series.iter().enumerate() {
            let colour = COLOURS[number % COLOURS.len()];
            let points = series.points.iter().copied().filter(shown);
            if self.has_lines {
                chart.draw_series(LineSeries::new(points.clone(), colour.stroke_width(2)))?;
            }
            chart.draw_series(points.map(|at| Circle::new(at, 4, colour.filled())))?;
            let y = 60 + LEGEND_LINE * number as i32;
            legend.draw(&Circle::new((15, y + 7), 4, colour.filled()))?;
            legend.draw(&Text::new(&*series.name, (34, y), ("sans-serif", 13)))?;
        }
        root.present()?;
        Ok(())
    }
}

/// Range of whole decades around the values, so that axes begin and end with a label.
fn decades(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    let first = low.log10().floor();
    let last = (high.log10() * 1.000_001).ceil().max(first + 1.0);
    10.0_f64.powf(first)..10.0_f64.powf(last)
}

fn power(value: f64) -> String {
    match value {
        v if (0.01..10_000.0).contains(&v) => format!("{v}"),
        v => format!("{v:.0e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chart_shows_its_series_without_points_that_have_no_logarithm() {
        let points = [(1e3, 0.1), (1e4, 1.0), (1e5, f64::NAN), (0.0, 1.0)];
        let series = Series::new("ours", points);
        let svg = LogLog::new("t", ["dofs", "s"], [series], true);
        let svg = svg.svg().unwrap();
        // One more is in the legend.
        assert_eq!(svg.matches("<circle").count(), 2 + 1);
        assert!(svg.contains("ours"));
        let empty = LogLog::new("empty", ["", ""], [], true).svg();
        assert!(empty.unwrap_err().to_string().contains("empty"));
    }
}
