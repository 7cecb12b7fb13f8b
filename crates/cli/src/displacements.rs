//! The table of displacements that `swim run` prints.

use std::fmt::Write;

use nalgebra::Vector3;
use swimmer::{Outcome, Scene};

use super::text::rounded;

/// Largest number of phases in the table; `summary.json` has all of them.
const MAX_ROWS: usize = 24;

/// Rounding of displacements, relative to the size of the scene.
const ROUNDING: f64 = 1e-14;

/// Numbers with five decimals have two significant digits from here on.
const SMALLEST_FIXED: f64 = 1e-4;

/// Displacements of all bodies, phase by phase and in total, with a common power of ten.
pub fn displacement_table(scene: &Scene, outcome: &Outcome) -> String {
    let phase_names: Vec<String> = (outcome.spans.iter())
        .map(|span| scene.joint_names(&span.joints))
        .collect();
    let name_width = phase_names
        .iter()
        .map(|name| name.chars().count())
        .max()
        .unwrap_or(0)
        .max(12);
    let largest = outcome
        .spans
        .iter()
        .flat_map(|span| &span.displacement)
        .chain(&outcome.displacement)
        .fold(0.0_f64, |m, d| m.max(d.amax()));
    let sizes = scene.bodies().iter().map(|body| {
        body.position.norm() + body.bounding_radius() + largest.max(outcome.longest_arc)
    });
    // Displacements by rounding are zero, and so are those within their error bars.
    let rounding = ROUNDING * sizes.fold(0.0, f64::max);
    let largest = if largest > rounding { largest } else { 0.0 };
    let exponent = common_exponent(largest);
    let scale = 10_f64.powi(-exponent);
    let row = |name: &str, displacement: &[Vector3<f64>], bar: f64| {
        let mut row = format!("{name:<name_width$}");
        for d in displacement {
            let d = d.map(|x| match x.abs() > rounding.max(bar) {
                true => number(scale * x),
                false => number(0.0),
            });
            // Writing to a String cannot fail.
            let _ = write!(row, "  {:>9} {:>9} {:>9}", d.x, d.y, d.z);
        }
        row + "\n"
    };
    let unit = match exponent {
        0 => "the scene's unit of length".to_owned(),
        _ => format!("1e{exponent} of the scene's unit of length"),
    };
    let mut text = format!("displacements (x, y, z) in {unit}\n");
    let header = scene
        .bodies()
        .iter()
        .fold(format!("{:<name_width$}", "phase"), |header, body| {
            format!("{header}  {:<29}", body.name)
        });
    text += header.trim_end();
    text += "\n";
    for (span, name) in outcome.spans.iter().zip(&phase_names).take(MAX_ROWS) {
        text += &row(name, &span.displacement, span.error_estimate.total());
    }
    if outcome.spans.len() > MAX_ROWS {
        let more = outcome.spans.len() - MAX_ROWS;
        text += &format!("... {more} more phases in summary.json\n");
    }
    text + &row(
        "total",
        &outcome.displacement,
        outcome.error_estimate.total(),
    )
}

/// A number with five decimals, or two significant digits where these show less of it.
fn number(x: f64) -> String {
    match x != 0.0 && x.abs() < SMALLEST_FIXED {
        true => format!("{x:.1e}"),
        false => format!("{:.5}", rounded(x, 5)),
    }
}

/// The exponent of the power of ten in which displacements are printed; 0 if they fit the columns.
fn common_exponent(largest: f64) -> i32 {
    match largest {
        x if x == 0.0 || (1e-2..1e3).contains(&x) => 0,
        x => x.log10().floor() as i32,
    }
}
