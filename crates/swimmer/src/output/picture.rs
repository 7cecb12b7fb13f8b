//! `trajectory.svg`: displacements against time above, the bodies at the ends of phases below.

use nalgebra::Vector3;
use plotters::coord::Shift;
use plotters::prelude::*;

use crate::SwimError;
use crate::outcome::Outcome;
use scene::Scene;

/// The palette of Okabe & Ito (2008), whose colours colour-blind readers can tell apart.
pub(super) const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(40, 40, 40),
];

/// Size of the picture in pixels.
const SIZE: (u32, u32) = (960, 760);

/// The drawing library rounds to whole units: that many units a pixel keep curves smooth.
const FINE: u32 = 4;

pub(super) const INK: RGBColor = RGBColor(40, 40, 40);
pub(super) const GREY: RGBColor = RGBColor(110, 110, 110);
const FAINT: RGBColor = RGBColor(225, 225, 225);
const BAND: RGBColor = RGBColor(246, 246, 246);

/// More phases than this are not labelled: the labels would run into each other.
const MOST_LABELS: usize = 12;

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Draws the trajectory as an SVG text.
///
/// # Errors
/// [`SwimError::Picture`] with the drawing library's reason.
pub fn trajectory_svg(scene: &Scene, outcome: &Outcome) -> Result<String, SwimError> {
    let mut svg = String::new();
    let fine_size = (FINE * SIZE.0, FINE * SIZE.1);
    {
        let root = SVGBackend::with_string(&mut svg, fine_size).into_drawing_area();
        draw(&root, scene, outcome).map_err(|error| SwimError::Picture(error.to_string()))?;
    }
    let size = |(width, height): (u32, u32)| format!("width=\"{width}\" height=\"{height}\"");
    Ok(svg.replacen(&size(fine_size), &size(SIZE), 1))
}

/// Pixels of the picture in units of the drawing.
pub(super) const fn px(pixels: u32) -> u32 {
    FINE * pixels
}

pub(super) fn font(pixels: u32, colour: &'static RGBColor) -> TextStyle<'static> {
    ("sans-serif", px(pixels)).into_font().color(colour)
}

fn draw(root: &Area, scene: &Scene, outcome: &Outcome) -> Result<(), Box<dyn std::error::Error>> {
    root.fill(&WHITE)?;
    let (above, below) = root.split_vertically(px(460));
    let axis = swimmer_axis(outcome);
    draw_curves(&above, scene, outcome, &axis)?;
    super::snapshots::draw(&below, scene, outcome, &axis)?;
    root.present()?;
    Ok(())
}

/// The direction along which bodies are spread, or along which a single body moves.
fn swimmer_axis(outcome: &Outcome) -> Vector3<f64> {
    let start = outcome.curve.first().map_or(&[][..], |(_, x)| x);
    let spread = start
        .iter()
        .skip(1)
        .map(|x| x - start[0])
        .max_by(|a, b| a.norm().total_cmp(&b.norm()));
    let collinear = |e: &Vector3<f64>| {
        start
            .iter()
            .all(|x| (x - start[0]).cross(e).norm() <= 1e-9 * e.norm().powi(2))
    };
    let net = outcome.displacement.iter().sum::<Vector3<f64>>();
    let direction = match spread {
        Some(e) if collinear(&e) => e,
        _ => net,
    };
    // Pointing the way of its largest component, so that x is to the right.
    let towards = direction[direction.iamax()].signum();
    direction
        .try_normalize(0.0)
        .map_or(Vector3::x(), |e| towards * e)
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

fn draw_curves(
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
    // A motion of nothing still needs an axis of some height.
    let room = 0.08 * (high - low).max(1e-9);
    let (low, high) = (low - room, high + 1.6 * room);
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
        if outcome.legs.len() <= MOST_LABELS {
            let label = phase_label(scene, leg % phases.len());
            let at = (
                phase_start + 0.02 * (phase_end - phase_start),
                high - 0.25 * room,
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
    match scene.gait().phases[phase].change {
        Some((link, length)) => format!("{} to {length}", scene.articulation().links()[link].name),
        None => "lengths held".to_owned(),
    }
}
