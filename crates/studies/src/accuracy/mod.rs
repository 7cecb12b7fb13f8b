//! Speed against accuracy: the error of each quantity over seconds and over dofs, for all methods.

mod instantaneous;
mod parameters;
mod quantity;
pub mod random;
mod strokes;

use std::fmt::Write;
use std::path::Path;

use anyhow::{Result, bail};

pub use quantity::Quantity;

use crate::{folder, machine};

/// Function that computes a quantity; the argument is `quick`.
type Compute = fn(bool) -> Result<Quantity>;

/// All quantities with their keys.
const QUANTITIES: [(&str, Compute); 4] = [
    ("drag", instantaneous::drag),
    ("pair", instantaneous::pair),
    ("speed", instantaneous::speed),
    ("net", strokes::net),
];

/// All quantities, or the one with the given key.
fn all(quick: bool, only: Option<&str>) -> Result<Vec<Quantity>> {
    if let Some(key) = only
        && !QUANTITIES.iter().any(|(name, _)| *name == key)
    {
        bail!("there is no quantity '{key}'; choose drag, pair, speed or net");
    }
    QUANTITIES
        .iter()
        .filter(|(name, _)| only.is_none_or(|key| key == *name))
        .map(|(_, compute)| compute(quick))
        .collect()
}

/// Computes all quantities, or one of them, and writes `accuracy.md`, `accuracy.csv` and two charts
/// per quantity into a folder.
pub fn run(quick: bool, only: Option<&str>, out: &Path) -> Result<Vec<Quantity>> {
    let quantities = all(quick, only)?;
    let text = markdown(&quantities)?;
    println!("{text}");
    folder::write(
        out,
        [("accuracy.md", text), ("accuracy.csv", csv(&quantities)?)],
    )?;
    for quantity in &quantities {
        let key = quantity.key;
        // Models without a mesh have zero dofs, and are left out of this chart.
        let over_dofs = quantity.chart("dofs", |p| p.dofs as f64).svg()?;
        folder::write(
            out,
            [
                (
                    format!("accuracy-{key}.svg"),
                    quantity.chart("seconds", |p| p.seconds).svg()?,
                ),
                (format!("accuracy-{key}-dofs.svg"), over_dofs),
            ],
        )?;
    }
    Ok(quantities)
}

fn markdown(quantities: &[Quantity]) -> Result<String> {
    let mut text = format!(
        "# Speed against accuracy\n\n{}, {}. Made by `cargo xtask accuracy`. Seconds are wall-clock times from the scene to the value, mesh generation included. Errors are \
         relative to exact values. error: that of the answer; uncorrected: that of the value before the estimated discretisation error was subtracted, which \
         takes the same seconds; bar: the error bar that the program gives; order: of both errors in the element size, from the next larger size to this one.\n",
        machine::today(),
        machine::processor()
    );
    for quantity in quantities {
        write!(
            text,
            "\n## {}\n\n![error against seconds](accuracy-{}.svg)\n\n| method | choice | dofs | seconds | error | uncorrected | bar | order | uncorrected order |\n|:--|:--|--:|--:|--:|--:|--:|--:|--:|\n",
            quantity.title, quantity.key
        )?;
        let shown = |error: Option<f64>| error.map_or("-".into(), |error| format!("{error:.1e}"));
        let order = |order: Option<f64>| order.map_or("-".into(), |order| format!("{order:.1}"));
        for (number, p) in quantity.points.iter().enumerate() {
            writeln!(
                text,
                "| {} | {} | {} | {:.3} | {:.1e} | {} | {} | {} | {} |",
                p.method,
                p.choice,
                p.dofs,
                p.seconds,
                p.error,
                shown(p.uncorrected),
                shown(p.bar),
                order(quantity.order(number, |p| Some(p.error))),
                order(quantity.order(number, |p| p.uncorrected)),
            )?;
        }
        if let Some([least, largest]) = quantity.gains_at_equal_seconds() {
            writeln!(
                text,
                "\nIn equal seconds, the best mesh of a given size has an error {least:.0} to {largest:.0} times smaller than before the correction."
            )?;
        }
    }
    Ok(text)
}

fn csv(quantities: &[Quantity]) -> Result<String> {
    let mut text = String::from("quantity,method,choice,dofs,seconds,error,uncorrected,bar\n");
    for quantity in quantities {
        for p in &quantity.points {
            let shown =
                |error: Option<f64>| error.map_or(String::new(), |error| format!("{error:e}"));
            writeln!(
                text,
                "{},{},{},{},{:.5},{:e},{},{}",
                quantity.key,
                p.method.replace(',', ";"),
                p.choice.replace(',', ";"),
                p.dofs,
                p.seconds,
                p.error,
                shown(p.uncorrected),
                shown(p.bar),
            )?;
        }
    }
    Ok(text)
}
