//! Charts with linear axes as SVG.

use anyhow::{Result, anyhow};
use plotters::prelude::*;

use crate::chart::{COLOURS, Series, Style};

const SIZE: (u32, u32) = (760, 460);

/// A chart with two linear axes and its legend at the upper left.
pub struct Linear {
    pub x: &'static str,
    pub y: &'static str,
    pub x_range: (f64, f64),
    pub y_range: (f64, f64),
    /// Number of labels of the x axis, and decimals of those of both axes.
    pub x_labels: usize,
    pub decimals: [usize; 2],
    /// Curves with marks; points without a line; guides without marks.
    pub series: Vec<Series>,
}

impl Linear {
    /// Chart as SVG text.
    pub fn svg(&self) -> Result<String> {
        let mut svg = String::new();
        self.draw(&mut svg)
            .map_err(|error| anyhow!("could not draw the chart of {}: {error}", self.y))?;
        Ok(svg)
    }

    fn draw(&self, svg: &mut String) -> std::result::Result<(), Box<dyn std::error::Error>> {
        let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&root)
            .margin(16)
            .x_label_area_size(46)
            .y_label_area_size(76)
            .build_cartesian_2d(
                self.x_range.0..self.x_range.1,
                self.y_range.0..self.y_range.1,
            )?;
        let [x_decimals, y_decimals] = self.decimals;
        chart
            .configure_mesh()
            .x_desc(self.x)
            .y_desc(self.y)
            .x_labels(self.x_labels)
            .x_label_formatter(&|x| format!("{x:.x_decimals$}"))
            .y_label_formatter(&|y| format!("{y:.y_decimals$}"))
            .label_style(("sans-serif", 14))
            .axis_desc_style(("sans-serif", 15))
            .disable_x_mesh()
            .draw()?;
        for (series, colour) in self.series.iter().zip(COLOURS.iter().cycle()) {
            let Series {
                name,
                points,
                style,
            } = series;
            let has_line = *style != Style::Points;
            let line = if has_line { points.clone() } else { Vec::new() };
            chart
                .draw_series(LineSeries::new(line, colour.stroke_width(2)))?
                .label(name)
                .legend(move |(x, y)| match has_line {
                    true => PathElement::new([(x, y), (x + 20, y)], colour).into_dyn(),
                    false => Circle::new((x + 10, y), 4, colour.filled()).into_dyn(),
                });
            if *style != Style::Guide {
                chart.draw_series(points.iter().map(|at| Circle::new(*at, 4, colour.filled())))?;
            }
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperLeft)
            .background_style(WHITE)
            .label_font(("sans-serif", 14))
            .draw()?;
        root.present()?;
        Ok(())
    }
}
