//! A helix under a torque along its axis: finite elements beside resistive-force theory.

use std::f64::consts::TAU;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use swimmer::{Scene, choose, solve_start};

use crate::chart::{Series, Style};
use crate::folder;
use crate::linear_chart::Linear;
use crate::machine::{processor, today};

/// Radius of the tube over that of the helix.
const TUBE: f64 = 0.1;

const TURNS: f64 = 2.0;

/// Factors on the default element sizes: of the picture, and of the table of sizes.
const COARSE: f64 = 2.0;
const FACTORS: [f64; 3] = [1.4, 1.0, 0.7];

/// Angles between the curve and the axis in degrees.
const ANGLES: [f64; 6] = [20.0, 30.0, 40.0, 50.0, 60.0, 70.0];

/// Angle of the table of sizes.
const MIDDLE: f64 = 40.0;

/// Drag per length for motion along and across a thin curve, over the viscosity.
struct Drag {
    along: f64,
    across: f64,
}

/// Velocity and angular velocity along the axis for a unit torque along it.
struct Motion {
    speed: f64,
    spin: f64,
}

impl Motion {
    /// Distance per turn.
    fn advance(&self) -> f64 {
        TAU * self.speed / self.spin
    }
}

/// One solution by elements.
struct Row {
    factor: f64,
    dofs: usize,
    corrected: Motion,
    uncorrected: Motion,
    /// Error bar of the speed.
    bar: f64,
    seconds: f64,
}

/// Solves helices of several angles and sizes, and writes `helix.md` and `helix.svg` into a folder.
pub fn run(quick: bool, out: &Path) -> Result<()> {
    let angles = if quick { &ANGLES[4..] } else { &ANGLES[..] };
    let sizes = if quick { &FACTORS[..1] } else { &FACTORS[..] };
    let row = |angle: f64, factor: f64| -> Result<Row> {
        let row = by_elements(angle, factor)
            .with_context(|| format!("helix of {angle} degrees, size factor {factor}"))?;
        eprintln!("{angle} degrees: {}", line(&row));
        Ok(row)
    };
    let table: Vec<Row> =
        (sizes.iter().map(|&factor| row(MIDDLE, factor))).collect::<Result<_>>()?;
    let mut advances = Vec::new();
    for &angle in angles {
        advances.push((angle, row(angle, COARSE)?.corrected.advance()));
    }
    let svg = chart(&advances)?;
    folder::write(
        out,
        [("helix.md", page(&table, &advances)), ("helix.svg", svg)],
    )
}

/// Pitch of a helix of radius one whose curve has this angle with the axis, in degrees.
fn pitch(angle: f64) -> f64 {
    TAU / angle.to_radians().tan()
}

fn by_elements(angle: f64, factor: f64) -> Result<Row> {
    let clock = Instant::now();
    let scene = Scene::parse(&format!(
        "model.kind = \"fem\"\nfem.size_factor = {factor:?}\n\
         bodies = [{{ name = \"helix\", shape = \"helix\", radius = 1, tube_radius = {TUBE}, \
         pitch = {:?}, turns = {TURNS:?}, position = [0, 0, 0], torque = [1, 0, 0] }}]",
        pitch(angle)
    ))?;
    let mut model = choose(&scene)?.model;
    let instant = solve_start(&scene, model.as_mut())?;
    let motion = |body: &swimmer::models::BodySolution| Motion {
        speed: body.velocity.x,
        spin: body.angular_velocity.x,
    };
    Ok(Row {
        factor,
        dofs: instant.dofs.total,
        corrected: motion(&instant.bodies[0]),
        uncorrected: motion(&instant.uncorrected().bodies[0]),
        bar: instant.error_estimate.total(),
        seconds: clock.elapsed().as_secs_f64(),
    })
}

impl Drag {
    /// Gray & Hancock 1955, with the pitch as the length of a wave.
    fn gray_hancock(angle: f64) -> Self {
        let logarithm = (2.0 * pitch(angle) / TUBE).ln();
        Self {
            along: TAU / (logarithm - 0.5),
            across: 2.0 * TAU / (logarithm + 0.5),
        }
    }

    /// Lighthill 1976: with `q = 0.09` of the length of the curve per turn.
    fn lighthill(angle: f64) -> Self {
        let length = TAU / angle.to_radians().sin();
        let logarithm = (2.0 * 0.09 * length / TUBE).ln();
        Self {
            along: TAU / logarithm,
            across: 2.0 * TAU / (logarithm + 0.5),
        }
    }

    /// Motion along the axis of a free helix under a unit torque along it: the drag is integrated
    /// along the curve, and the resistance of all six motions is inverted.
    fn motion(&self, angle: f64, turns: f64) -> Motion {
        /// Points per turn: the trapezoidal error is below the width of a line of the picture.
        const POINTS: f64 = 400.0;
        let count = (turns * POINTS).ceil();
        let advance = pitch(angle) / TAU;
        let mut resistance = Matrix6::zeros();
        for k in 0..count as usize {
            let theta = TAU * turns * ((k as f64 + 0.5) / count - 0.5);
            let (sin, cos) = theta.sin_cos();
            let position = Vector3::new(advance * theta, cos, sin);
            let derivative = Vector3::new(advance, -sin, cos);
            let tangent = derivative.normalize();
            let along = tangent * tangent.transpose();
            let drag = along * self.along + (Matrix3::identity() - along) * self.across;
            let drag = drag * (derivative.norm() * TAU * turns / count);
            let arm = position.cross_matrix();
            // The velocity at the position is U - arm ω, and a force f there has the torque arm f.
            let mut add = |row: usize, column: usize, block: Matrix3<f64>| {
                let mut view = resistance.fixed_view_mut::<3, 3>(row, column);
                view += block;
            };
            add(0, 0, drag);
            add(0, 3, -drag * arm);
            add(3, 0, arm * drag);
            add(3, 3, -arm * drag * arm);
        }
        let torque = Vector6::new(0.0, 0.0, 0.0, 1.0, 0.0, 0.0);
        let found = resistance.lu().solve(&torque).unwrap_or_default();
        Motion {
            speed: found[0],
            spin: found[3],
        }
    }
}

fn line(row: &Row) -> String {
    format!(
        "| {} | {} | {:.6e} | {:.6e} ± {:.1e} | {:.5} | {:.5} | {:.1} |",
        row.factor,
        row.dofs,
        row.uncorrected.speed,
        row.corrected.speed,
        row.bar,
        row.uncorrected.advance(),
        row.corrected.advance(),
        row.seconds
    )
}

fn page(table: &[Row], advances: &[(f64, f64)]) -> String {
    let mut text = format!(
        "# A helix beside resistive-force theory\n\n\
         Written by `cargo xtask helix`, {}, {}.\n\n\
         A right-handed helix of {TURNS} turns with a tube of {TUBE} radii, in unbounded fluid, free \
         under a unit torque along its axis; radius and viscosity are 1. The curve of the helix has \
         the angle `atan(2 π radius / pitch)` with the axis. Resistive-force theory has a drag per \
         length for motion along and across the curve and no interaction between its parts; both \
         variants are integrated along the curve of the same {TURNS} turns, without the ends.\n\n\
         ![Distance per turn against the angle](helix.svg)\n\n\
         | angle, degrees | elements | Gray & Hancock 1955 | Lighthill 1976 |\n|---|---|---|---|\n",
        today(),
        processor(),
    );
    for (angle, advance) in advances {
        let [gray, lighthill] = [Drag::gray_hancock(*angle), Drag::lighthill(*angle)]
            .map(|drag| drag.motion(*angle, TURNS).advance());
        text += &format!("| {angle} | {advance:.4} | {gray:.4} | {lighthill:.4} |\n");
    }
    text += &format!(
        "\n## Three mesh sizes, {MIDDLE} degrees\n\n\
         | size factor | dofs | speed, uncorrected | speed | distance per turn, uncorrected | \
         distance per turn | time, s |\n|---|---|---|---|---|---|---|\n"
    );
    for row in table {
        text += &line(row);
        text.push('\n');
    }
    text
}

/// Distance per turn against the angle.
fn chart(advances: &[(f64, f64)]) -> Result<String> {
    let curve = |name: &str, drag: fn(f64) -> Drag| Series {
        name: name.to_owned(),
        points: (20..=70)
            .map(f64::from)
            .map(|angle| (angle, drag(angle).motion(angle, TURNS).advance()))
            .collect(),
        style: Style::Guide,
    };
    let elements = Series {
        name: "finite elements".to_owned(),
        points: advances.to_vec(),
        style: Style::Points,
    };
    let series = vec![
        elements,
        curve("Gray & Hancock 1955", Drag::gray_hancock),
        curve("Lighthill 1976", Drag::lighthill),
    ];
    let points = series.iter().flat_map(|series| &series.points);
    let highest = points.fold(0.0_f64, |high, point| high.max(point.1));
    let chart = Linear {
        x: "angle between curve and axis, degrees",
        y: "distance per turn, radii",
        x_range: (15.0, 75.0),
        y_range: (0.0, 1.3 * highest),
        x_labels: 7,
        decimals: [0, 1],
        series,
    };
    chart.svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resistive_force_theory_has_the_speed_of_a_long_helix() {
        // Force balance along the axis of an infinite helix at rest across it.
        for angle in [25.0_f64, 45.0, 65.0] {
            let drag = Drag::gray_hancock(angle);
            let ratio = drag.across / drag.along;
            let (sin, cos) = angle.to_radians().sin_cos();
            let exact = TAU * (ratio - 1.0) * sin * cos / (ratio * sin * sin + cos * cos);
            let error = |turns: f64| (drag.motion(angle, turns).advance() / exact - 1.0).abs();
            // Whole turns: the other motions decay as the inverse square of the length.
            assert!(error(40.0) < 1e-3, "{angle}: {:e}", error(40.0));
            assert!(error(40.0) < 0.3 * error(20.0), "{angle}");
        }
        assert!((pitch(45.0) - TAU).abs() < 1e-14);
    }
}
