//! The tables of displacements that `swim run` prints: of bodies phase by phase, and of swimmers.

use std::fmt::Write;

use nalgebra::Vector3;
use pictures::numbers::with_digits;
use swimmer::{Outcome, Scene, SwimmerOutcome};

use super::text::{entry, rounded, two_digits, with_uncertainty};

/// Largest number of phases, or of swimmers, in a table; `summary.json` has all of them.
const MAX_ROWS: usize = 24;

/// Largest number of bodies in the table, of which each has three columns.
const MAX_BODIES: usize = 12;

/// Digits of the work of a swimmer, whose error bar is known of the run only.
const WORK_DIGITS: i32 = 5;

/// Rounding of displacements, relative to the size of the scene.
const ROUNDING: f64 = 1e-14;

/// Numbers with five decimals have two significant digits from here on.
const SMALLEST_FIXED: f64 = 1e-4;

/// Displacements of all bodies, phase by phase and in total, with a common power of ten; of many
/// bodies where they are.
pub fn displacement_table(scene: &Scene, outcome: &Outcome) -> String {
    let count = scene.bodies().len();
    if count > MAX_BODIES {
        return format!("displacements of {count} bodies in summary.json\n");
    }
    let phase_names: Vec<String> = (outcome.spans.iter())
        .map(|span| scene.joint_label(&span.joints))
        .collect();
    let name_width = width_of(phase_names.iter().map(String::as_str));
    let numbers = Numbers::new(scene, outcome);
    let row = |name: &str, displacement: &[Vector3<f64>], bar: f64| {
        let columns: String = displacement.iter().map(|d| numbers.row(d, bar)).collect();
        format!("{name:<name_width$}{columns}\n")
    };
    let mut text = format!("displacements (x, y, z) in {}\n", numbers.unit());
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

/// Net displacement, rotation and work of each swimmer, of many their distances; empty for one.
pub fn swimmer_table(scene: &Scene, outcome: &Outcome) -> String {
    let swimmers = outcome.swimmers(scene);
    match swimmers.len() {
        0 => String::new(),
        1..=MAX_ROWS => "\n".to_owned() + &rows_of(scene, outcome, &swimmers),
        count => {
            let lengths = || swimmers.iter().map(|swimmer| swimmer.displacement.norm());
            let mean = lengths().sum::<f64>() / count as f64;
            let [least, most] = [
                lengths().fold(f64::INFINITY, f64::min),
                lengths().fold(0.0, f64::max),
            ];
            let bars = swimmers
                .iter()
                .map(|swimmer| swimmer.error_estimate.total());
            let moved = with_uncertainty(mean, bars.fold(0.0, f64::max));
            let range = format!("{} to {}", two_digits(least), two_digits(most));
            "\n".to_owned()
                + &entry("swimmers", format!("{count}, each in summary.json"))
                + &entry("mean distance", format!("{moved}, from {range}"))
        }
    }
}

fn rows_of(scene: &Scene, outcome: &Outcome, swimmers: &[SwimmerOutcome]) -> String {
    let width = width_of(swimmers.iter().map(|swimmer| swimmer.name(scene)));
    let numbers = Numbers::new(scene, outcome);
    let mut text = format!(
        "swimmers: displacement (x, y, z) in {}, turn in radians, work\n",
        numbers.unit()
    );
    for swimmer in swimmers {
        let bar = swimmer.error_estimate.total();
        // An angle within its error bar is zero, as components of a displacement are.
        let angle = Some(swimmer.rotation.norm());
        let angle = angle.filter(|angle| *angle > swimmer.rotation_error.total());
        let _ = writeln!(
            text,
            "{:<width$}{}  {:>9}  {}",
            swimmer.name(scene),
            numbers.row(&swimmer.displacement, bar),
            number(angle.unwrap_or(0.0)),
            (swimmer.work).map_or("-".to_owned(), |work| with_digits(work, WORK_DIGITS)),
        );
    }
    text
}

/// Width of the column of names.
fn width_of<'n>(names: impl Iterator<Item = &'n str>) -> usize {
    let longest = names.map(|name| name.chars().count()).max();
    longest.unwrap_or(0).max(12)
}

/// How displacements are written: with a common power of ten, and zero for rounding.
struct Numbers {
    rounding: f64,
    exponent: i32,
}

impl Numbers {
    fn new(scene: &Scene, outcome: &Outcome) -> Self {
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
        Self {
            rounding,
            exponent: common_exponent(largest),
        }
    }

    fn unit(&self) -> String {
        match self.exponent {
            0 => "the scene's unit of length".to_owned(),
            exponent => format!("1e{exponent} of the scene's unit of length"),
        }
    }

    /// Three columns.
    fn row(&self, displacement: &Vector3<f64>, bar: f64) -> String {
        let scale = 10_f64.powi(-self.exponent);
        let d = displacement.map(|x| match x.abs() > self.rounding.max(bar) {
            true => number(scale * x),
            false => number(0.0),
        });
        format!("  {:>9} {:>9} {:>9}", d.x, d.y, d.z)
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Works were printed with four decimals: 0.0000 in SI units.
    #[test]
    fn bug_works_in_si_units_were_printed_as_zero() {
        let works = [1.23456e-17, 0.0123456, 12.3456, -98_765.4, 1.23456e7, 0.0];
        let text = [
            "1.2346e-17",
            "0.012346",
            "12.346",
            "-98765",
            "1.2346e7",
            "0",
        ];
        assert_eq!(works.map(|work| with_digits(work, WORK_DIGITS)), text);
    }
}
