//! The upper half of the plot: displacements against time.

use nalgebra::Vector3;
use plotters::prelude::*;
use scene::{LengthPath, Scene};

use super::style::{Area, BAND, COLOURS, FAINT, GREY, INK, font, px};
use crate::outcome::Outcome;

/// Largest number of phases with labels: more would overlap.
const MAX_LABELS: usize = 12;

/// Draws the displacement of every body along `axis`.
pub(super) fn draw(
    area: &Area,
    scene: &Scene,
    outcome: &Outcome,
    axis: &Vector3<f64>,
) -> Result<(), Box<dyn std::error::Error>> {
    let origin = &outcome.curve[0].1;
    let value = |body: usize, x: &Vector3<f64>| (x - origin[body]).dot(axis);
    let end = scene.gait().duration();
    let all = outcome
        .curve
        .iter()
        .flat_map(|(_, x)| x.iter().enumerate().map(|(b, x)| value(b, x)));
    let (low, high) = all.fold((0.0_f64, 0.0_f64), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    // Without any motion the axis still needs some height.
    let margin = 0.08 * (high - low).max(1e-9);
    let (low, high) = (low - margin, high + 1.6 * margin);
    let title = format!(
        "{}: displacement of the bodies {}",
        scene.name(),
        axis_name(axis)
    );
    let mut chart = ChartBuilder::on(area)
        .margin(px(14))
        .caption(title, font(20, &INK))
        .x_label_area_size(px(46))
        .y_label_area_size(px(70))
        .build_cartesian_2d(0.0..end, low..high)?;
    let mut phase_start = 0.0;
    let phases = &scene.gait().phases;
    for leg in 0..outcome.legs.len() {
        let phase_end = phase_start + phases[leg % phases.len()].duration;
        if leg % 2 == 1 {
            chart.draw_series([Rectangle::new(
                [(phase_start, low), (phase_end, high)],
                BAND.filled(),
            )])?;
        }
        if outcome.legs.len() <= MAX_LABELS {
            let label = phase_label(scene, leg % phases.len());
            let at = (
                phase_start + 0.02 * (phase_end - phase_start),
                high - 0.25 * margin,
            );
            chart.draw_series([Text::new(label, at, font(13, &GREY))])?;
        }
        phase_start = phase_end;
    }
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(FAINT.stroke_width(px(1)))
        .axis_style(INK.stroke_width(px(1)))
        .set_all_tick_mark_size(px(5))
        .label_style(font(14, &INK))
        .x_desc("time (the scene's unit)")
        .y_desc("displacement (the scene's unit of length)")
        .draw()?;
    for (number, body) in scene.bodies().iter().enumerate() {
        let colour = COLOURS[number % COLOURS.len()];
        let curve = outcome
            .curve
            .iter()
            .map(|(time, x)| (*time, value(number, &x[number])));
        let net = outcome.displacement[number].dot(axis);
        chart
            .draw_series(LineSeries::new(curve, colour.stroke_width(px(2))))?
            .label(format!("{}: net {net:+.5}", body.name))
            .legend(move |(x, y)| {
                PathElement::new([(x, y), (x + px(18) as i32, y)], colour.stroke_width(px(3)))
            });
        let solved = outcome
            .samples
            .iter()
            .filter(|sample| sample.bodies.is_some());
        let points = solved.map(|sample| {
            (
                sample.time,
                value(number, &sample.poses[number].translation.vector),
            )
        });
        chart.draw_series(points.map(|at| Circle::new(at, px(3), colour.filled())))?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerRight)
        .background_style(WHITE.mix(0.85))
        .border_style(FAINT)
        .legend_area_size(px(26))
        .margin(px(8))
        .label_font(font(14, &INK))
        .draw()?;
    Ok(())
}

fn phase_label(scene: &Scene, phase: usize) -> String {
    let path = &scene.gait().phases[phase].path;
    let name = |link: usize| &scene.articulation().links()[link].name;
    match path {
        LengthPath::Linear(changes) if changes.is_empty() => "constant lengths".to_owned(),
        LengthPath::Linear(changes) => {
            let labels = changes
                .iter()
                .map(|&(link, length)| format!("{} to {length}", name(link)));
            labels.collect::<Vec<_>>().join(", ")
        }
        LengthPath::Cubic(_) => format!("row {}", phase + 2),
        LengthPath::Own(_) => format!("path {}", phase + 1),
        LengthPath::Harmonic { span, .. } => format!("to {} of a period", span.1),
    }
}

fn axis_name(axis: &Vector3<f64>) -> String {
    for (name, unit) in [
        ("x", Vector3::x()),
        ("y", Vector3::y()),
        ("z", Vector3::z()),
    ] {
        if (axis - unit).norm() < 1e-9 {
            return format!("along {name}");
        }
    }
    format!("along ({:.2}, {:.2}, {:.2})", axis.x, axis.y, axis.z)
}
