//! Log-log charts as SVG.

use anyhow::{Result, anyhow};
use plotters::coord::combinators::IntoLogRange;
use plotters::coord::{CoordTranslate, Shift};
use plotters::drawing::DrawingAreaErrorKind;
use plotters::element::DashedPathElement;
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

const INK: RGBColor = RGBColor(40, 40, 40);
const FAINT: RGBColor = RGBColor(225, 225, 225);
const WIDTH: u32 = 1180;

/// Smallest height of a chart; long legends increase it.
const LEAST_HEIGHT: u32 = 620;

/// Width of the chart without its legend, which is beside it so that it covers no points.
const CHART_WIDTH: u32 = 860;

/// Largest number of characters in a line of the legend.
const LEGEND_CHARACTERS: usize = 40;

/// Top of the legend, height of its lines, and space between two entries.
const LEGEND_TOP: i32 = 60;
const LEGEND_LINE: i32 = 17;
const LEGEND_SPACE: i32 = 7;

/// Styles of lines: dash and gap in pixels, `None` for solid lines.
///
/// Series that repeat a colour are dashed.
const DASHES: [Option<(u32, u32)>; 4] = [None, Some((9, 5)), Some((3, 4)), Some((15, 3))];

/// Dash and gap of a line before an improvement.
const BEFORE_DASH: (u32, u32) = (4, 4);

/// Marks of points, by the corners relative to the point in pixels; no corners for a disc.
const MARKS: [&[(i32, i32)]; 4] = [
    &[],
    &[(-4, -4), (4, -4), (4, 4), (-4, 4)],
    &[(-5, 4), (0, -5), (5, 4)],
    &[(-6, 0), (0, -6), (6, 0), (0, 6)],
];

/// How the points of a series are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Points joined by a line.
    Curve,
    /// Points without a line.
    Points,
    /// A thin dashed line without points, in the colour of the series with this number: the same
    /// quantity before an improvement.
    Before(usize),
    /// A broad pale line under the others.
    Front,
}

/// Points with a name; those with an empty name are not in the legend.
#[derive(Clone, Debug)]
pub struct Series {
    pub name: String,
    pub points: Vec<(f64, f64)>,
    pub style: Style,
}

/// Result of drawing something.
type Drawn = std::result::Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// Appearance of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Look {
    colour: RGBColor,
    /// Width of the line; `None` for points without a line.
    line: Option<u32>,
    dash: Option<(u32, u32)>,
    /// Corners of the marks, empty for discs; `None` for lines without points.
    mark: Option<&'static [(i32, i32)]>,
}

/// Draws a mark at a point: discs are filled, others hollow, so that overlapping marks are
/// distinct.
fn draw_mark<C: CoordTranslate>(
    area: &DrawingArea<SVGBackend, C>,
    at: C::From,
    corners: &[(i32, i32)],
    colour: RGBColor,
) -> Drawn
where
    C::From: Clone,
{
    if corners.is_empty() {
        return area.draw(&Circle::new(at, 4, colour.filled()));
    }
    let outline: Vec<(i32, i32)> = corners.iter().chain(&corners[..2]).copied().collect();
    let mark = EmptyElement::at(at)
        + Polygon::new(corners.to_vec(), WHITE.filled())
        + PathElement::new(outline, colour.stroke_width(2));
    area.draw(&mark)
}

impl Look {
    /// Draws a line through some points of an area and marks at others.
    fn draw<C: CoordTranslate>(
        &self,
        area: &DrawingArea<SVGBackend, C>,
        line: &[C::From],
        marks: &[C::From],
    ) -> Drawn
    where
        C::From: Clone + 'static,
    {
        if let (Some(width), false) = (self.line, line.is_empty()) {
            let stroke = self.colour.stroke_width(width);
            match self.dash {
                None => area.draw(&PathElement::new(line.to_vec(), stroke))?,
                Some((dash, gap)) => {
                    area.draw(&DashedPathElement::new(line.to_vec(), dash, gap, stroke))?
                }
            }
        }
        if let Some(corners) = self.mark {
            for at in marks {
                draw_mark(area, at.clone(), corners, self.colour)?;
            }
        }
        Ok(())
    }
}

impl Series {
    pub fn new(
        name: impl Into<String>,
        points: impl IntoIterator<Item = (f64, f64)>,
        style: Style,
    ) -> Self {
        Self {
            name: name.into(),
            points: points.into_iter().collect(),
            style,
        }
    }

    /// Height of its lines in the legend.
    fn legend_height(&self) -> i32 {
        LEGEND_SPACE + LEGEND_LINE * wrapped(&self.name).len() as i32
    }

    /// Appearance of the series with this number: colours repeat after eight series, with other
    /// dashes and marks.
    fn look(&self, number: usize) -> Look {
        let line = |colour: RGBColor, width: u32| Look {
            colour,
            line: Some(width),
            dash: None,
            mark: None,
        };
        let round = number / COLOURS.len();
        let own = Look {
            // When the marks repeat, the dashes are shifted by one.
            dash: DASHES[(round + round / MARKS.len()) % DASHES.len()],
            mark: Some(MARKS[round % MARKS.len()]),
            ..line(COLOURS[number % COLOURS.len()], 2)
        };
        match self.style {
            Style::Front => line(RGBColor(205, 205, 205), 7),
            Style::Curve => own,
            Style::Points => Look { line: None, ..own },
            Style::Before(other) => Look {
                dash: Some(BEFORE_DASH),
                ..line(COLOURS[other % COLOURS.len()], 1)
            },
        }
    }
}

/// A chart with two logarithmic axes.
#[derive(Clone, Debug)]
pub struct LogLog {
    title: String,
    x: &'static str,
    y: &'static str,
    pub series: Vec<Series>,
}

impl LogLog {
    pub fn new(
        title: impl Into<String>,
        x: &'static str,
        y: &'static str,
        series: impl IntoIterator<Item = Series>,
    ) -> Self {
        Self {
            title: title.into(),
            x,
            y,
            series: series.into_iter().collect(),
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
        let x_range = range(all.iter().map(|point| point.0));
        let y_range = range(all.iter().map(|point| point.1));
        let legend_height: i32 = self.named().map(|(_, series)| series.legend_height()).sum();
        let height = LEAST_HEIGHT.max((LEGEND_TOP + legend_height) as u32);
        let root = SVGBackend::with_string(svg, (WIDTH, height)).into_drawing_area();
        root.fill(&WHITE)?;
        let (plot, legend) = root.split_horizontally(CHART_WIDTH);
        let mut chart = ChartBuilder::on(&plot)
            .caption(&self.title, font(20))
            .margin(14)
            .x_label_area_size(46)
            .y_label_area_size(70)
            .build_cartesian_2d(
                (x_range.0..x_range.1).log_scale(),
                (y_range.0..y_range.1).log_scale(),
            )?;
        chart
            .configure_mesh()
            .x_desc(self.x)
            .y_desc(self.y)
            .label_style(font(14))
            .axis_desc_style(font(15))
            .x_label_formatter(&|x| power(*x))
            .y_label_formatter(&|y| power(*y))
            .bold_line_style(FAINT)
            .light_line_style(WHITE)
            .draw()?;
        // Fronts are drawn first, below the other series.
        let mut order: Vec<(usize, &Series)> = self.series.iter().enumerate().collect();
        order.sort_by_key(|(_, series)| series.style != Style::Front);
        for &(number, series) in &order {
            let points: Vec<(f64, f64)> = series.points.iter().copied().filter(shown).collect();
            let look = series.look(number);
            look.draw(chart.plotting_area(), &points, &points)?;
        }
        self.draw_legend(&legend)?;
        root.present()?;
        Ok(())
    }

    /// Series of the legend with their numbers.
    fn named(&self) -> impl Iterator<Item = (usize, &Series)> {
        let series = self.series.iter().enumerate();
        series.filter(|(_, series)| !series.name.is_empty())
    }

    fn draw_legend(&self, area: &DrawingArea<SVGBackend, Shift>) -> Drawn {
        let mut y = LEGEND_TOP;
        for (number, series) in self.named() {
            let middle = y + LEGEND_LINE / 2;
            let look = series.look(number);
            let wider = Look {
                line: look.line.map(|width| width + 1),
                ..look
            };
            wider.draw(area, &[(2, middle), (28, middle)], &[(15, middle)])?;
            for line in wrapped(&series.name) {
                area.draw(&Text::new(line, (34, y), font(13)))?;
                y += LEGEND_LINE;
            }
            y += LEGEND_SPACE;
        }
        Ok(())
    }
}

fn font(size: u32) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&INK)
}

/// Points for which no other point is both cheaper and better, by increasing cost.
pub fn pareto_front(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut sorted: Vec<(f64, f64)> = points
        .iter()
        .copied()
        .filter(|&(cost, error)| cost > 0.0 && error > 0.0)
        .collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut front: Vec<(f64, f64)> = Vec::new();
    for point in sorted {
        if front.last().is_none_or(|last| point.1 < last.1) {
            front.push(point);
        }
    }
    front
}

/// Range of whole decades around the values, so that axes begin and end with a label.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    (
        10.0_f64.powf(low.log10().floor()),
        10.0_f64.powf(
            (high.log10() * 1.000_001)
                .ceil()
                .max(low.log10().floor() + 1.0),
        ),
    )
}

/// Lines of a name that fit into the legend.
fn wrapped(name: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in name.split(' ') {
        let line = lines.len() - 1;
        if !lines[line].is_empty() && lines[line].len() + word.len() >= LEGEND_CHARACTERS {
            lines.push(word.to_owned());
            continue;
        }
        if !lines[line].is_empty() {
            lines[line].push(' ');
        }
        lines[line].push_str(word);
    }
    lines
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
        let series = Series::new("ours", points, Style::Curve);
        let svg = LogLog::new("t", "dofs", "s", [series]).svg().unwrap();
        // One more is in the legend.
        assert_eq!(svg.matches("<circle").count(), 2 + 1);
        assert!(svg.contains("ours"));
        let empty = LogLog::new("empty", "", "", []).svg();
        assert!(empty.unwrap_err().to_string().contains("empty"));
    }

    #[test]
    fn no_two_series_look_alike() {
        for style in [Style::Curve, Style::Points] {
            let of_style = |number| {
                let points = [(1.0, 1.0 + number as f64), (10.0, 2.0 + number as f64)];
                Series::new(format!("number {number}"), points, style)
            };
            let series: Vec<Series> = (0..20).map(of_style).collect();
            let looks: Vec<Look> = series.iter().zip(0..).map(|(s, k)| s.look(k)).collect();
            for (k, look) in looks.iter().enumerate() {
                assert!(!looks[..k].contains(look), "{style:?} {k}");
            }
            // The legend is high enough for all of them.
            let chart = LogLog::new("t", "x", "y", series);
            assert!(chart.svg().unwrap().contains("number 19"));
        }
    }

    #[test]
    fn the_front_has_the_best_points() {
        let others = [(2.0, 1e-1), (0.0, 1e-9)];
        let best = [(1.0, 1e-2), (2.0, 5e-3), (3.0, 1e-3)];
        assert_eq!(
            pareto_front(&[others, [best[2], best[0]], [best[1]; 2]].concat()),
            best
        );
    }
}
