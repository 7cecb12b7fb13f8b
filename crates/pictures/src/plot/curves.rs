//! The upper half of the plot: displacements or angles against time.

use plotters::prelude::*;
use scene::{Scene, ShapePath};

use super::quantity::Quantity;
use super::style::{Area, BAND, COLOURS, GREY, INK, at, font, grid_style, px, short};
use crate::numbers::rounded;
use swimmer::Outcome;

/// Width of a character of a label relative to the size of the font.
const CHARACTER: f64 = 0.55;

/// Size of the font of labels.
const LABEL_SIZE: u32 = 13;

/// Height of a line of the legend in pixels.
const LINE: u32 = 20;

/// Largest number of lines of the legend; further bodies are counted only.
const MAX_LINES: u32 = 2;

/// Largest number of bodies whose curves have dots at the solves.
const MAX_DOTTED: usize = 60;

/// Draws the quantity for every body, under a title and a legend.
pub(super) fn draw(
    area: &Area,
    scene: &Scene,
    outcome: &Outcome,
    quantity: &Quantity,
) -> Result<(), Box<dyn std::error::Error>> {
    let curve = quantity.curve(outcome);
    let points = quantity.points(outcome);
    let end = scene.gait().duration();
    let all = curve.iter().chain(&points).flat_map(|(_, values)| values);
    let (low, high) = all.fold((0.0_f64, 0.0_f64), |(low, high), v| {
        (low.min(*v), high.max(*v))
    });
    // Without any motion the axis still needs some height.
    let margin = 0.08 * (high - low).max(1e-9);
    let (low, high) = (low - margin, high + 1.6 * margin);
    let title = format!("{}: {}", scene.name(), quantity.title());
    area.draw(&Text::new(title, at(14, 10), font(20, &INK)))?;
    let net = curve.last().map_or(&[][..], |(_, values)| values);
    let lines = legend(area, scene, net)?;
    let (_, area) = area.split_vertically(px(40 + LINE * lines));
    let mut chart = ChartBuilder::on(&area)
        .margin(px(14))
        .margin_right(px(28))
        .x_label_area_size(px(46))
        .y_label_area_size(px(70))
        .build_cartesian_2d(0.0..end, low..high)?;
    let mut phase_start = 0.0;
    let phases = &scene.gait().phases;
    for span in 0..outcome.spans.len() {
        let phase_end = phase_start + phases[span % phases.len()].duration;
        if span % 2 == 1 {
            chart.draw_series([Rectangle::new(
                [(phase_start, low), (phase_end, high)],
                BAND.filled(),
            )])?;
        }
        let label = phase_label(scene, span % phases.len());
        let length = label.chars().count() as f64 * CHARACTER * f64::from(px(LABEL_SIZE));
        let (across, _) = chart.plotting_area().get_pixel_range();
        let share = (phase_end - phase_start) / end;
        // A label that is longer than its phase would cover the next one.
        if length < f64::from(across.end - across.start) * share {
            let at = (
                phase_start + 0.02 * (phase_end - phase_start),
                high - 0.25 * margin,
            );
            chart.draw_series([Text::new(label, at, font(LABEL_SIZE, &GREY))])?;
        }
        phase_start = phase_end;
    }
    let mut axes = chart.configure_mesh();
    grid_style(&mut axes);
    axes.set_all_tick_mark_size(px(5))
        .x_desc("time (the scene's unit)")
        .y_desc(quantity.label())
        .y_label_formatter(&|v| {
            short(if v.abs() < 1e-9 * (high - low) {
                0.0
            } else {
                *v
            })
        })
        .draw()?;
    for body in 0..scene.bodies().len() {
        let colour = COLOURS[body % COLOURS.len()];
        let of_body = |(time, values): &(f64, Vec<f64>)| (*time, values[body]);
        chart.draw_series(LineSeries::new(
            curve.iter().map(of_body),
            colour.stroke_width(px(2)),
        ))?;
        if scene.bodies().len() > MAX_DOTTED {
            continue;
        }
        let points = points.iter().map(of_body);
        chart.draw_series(points.map(|at| Circle::new(at, px(3), colour.filled())))?;
    }
    Ok(())
}

/// Draws the colour, name and value at the end of each body, and returns the number of lines.
fn legend(area: &Area, scene: &Scene, net: &[f64]) -> Result<u32, Box<dyn std::error::Error>> {
    let (width, _) = area.dim_in_pixel();
    let (mut x, mut line) = (14, 0);
    for (number, (body, net)) in scene.bodies().iter().zip(net).enumerate() {
        let text = format!("{} {:+.5}", body.name, rounded(*net, 5));
        // Letters of this font are about half as wide as high.
        let needed = 32 + 8 * text.chars().count() as u32;
        if px(x + needed + 100) > width && line + 1 == MAX_LINES {
            let more = format!("and {} more", scene.bodies().len() - number);
            area.draw(&Text::new(more, at(x, 40 + LINE * line), font(14, &INK)))?;
            break;
        }
        if px(x + needed) > width && x > 14 {
            (x, line) = (14, line + 1);
        }
        let y = 40 + LINE * line;
        let colour = COLOURS[number % COLOURS.len()];
        let stroke = [at(x, y + 8), at(x + 18, y + 8)];
        area.draw(&PathElement::new(stroke, colour.stroke_width(px(3))))?;
        area.draw(&Text::new(text, at(x + 24, y), font(14, &INK)))?;
        x += needed + 12;
    }
    Ok(line + 1)
}

fn phase_label(scene: &Scene, phase: usize) -> String {
    let path = &scene.gait().phases[phase].path;
    let name = |joint: usize| &scene.articulation().joints()[joint].name;
    match path {
        ShapePath::Linear(changes) if changes.is_empty() => String::new(),
        ShapePath::Linear(changes) => {
            let labels = changes
                .iter()
                .map(|&(joint, length)| format!("{} to {}", name(joint), short(length)));
            labels.collect::<Vec<_>>().join(", ")
        }
        ShapePath::Spline(path) => match path.rows() {
            (from, to) if to == from + 1 => format!("row {}", to + 1),
            (from, to) => format!("rows {} to {}", from + 2, to + 1),
        },
        ShapePath::Own(_) => format!("path {}", phase + 1),
        ShapePath::Harmonic { span, .. } => format!("to {} of a period", span.1),
    }
}
