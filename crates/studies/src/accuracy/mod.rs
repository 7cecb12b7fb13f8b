//! Speed against accuracy: the error of each quantity over seconds and over dofs, for all methods.

mod instantaneous;
mod net;
mod quantity;
pub mod random;

use std::path::Path;

use anyhow::{Result, bail};

use crate::page::{self, Page};
use crate::table::{Table, count, exp, fixed, optional};
pub use quantity::Quantity;

/// Function that computes a quantity; the argument is `quick`.
type Compute = fn(bool) -> Result<Quantity>;

/// All quantities with their keys.
const QUANTITIES: [(&str, Compute); 4] = [
    ("drag", instantaneous::drag),
    ("pair", instantaneous::pair),
    ("speed", instantaneous::speed),
    ("net", net::net),
];

/// Kinds of meshes: name, geometry, and whether symmetry planes are used.
const MESHES: [[&str; 3]; 3] = [
    ["finite elements, curved", "curved", "auto"],
    ["whole fluid, curved", "curved", "off"],
    ["whole fluid, straight", "straight", "off"],
];

/// Element sizes on the spheres.
fn sizes(quick: bool) -> &'static [f64] {
    match quick {
        true => &[0.8, 0.5],
        false => &[0.8, 0.6, 0.5, 0.4, 0.3, 0.2, 0.15],
    }
}

/// Target errors of adapted meshes.
fn targets(quick: bool) -> &'static [f64] {
    match quick {
        true => &[1e-2],
        false => &[1e-2, 3e-3, 1e-3, 3e-4, 1e-4],
    }
}

/// Overrides of a scene for a kind of mesh with elements of `size` on the spheres.
fn mesh_overrides(geometry: &str, symmetry: &str, size: f64) -> [String; 3] {
    [
        format!("fem.surface_size={size}"),
        format!("fem.geometry={geometry}"),
        format!("fem.symmetry={symmetry}"),
    ]
}

/// Overrides of a scene for axisymmetric elements with a tolerance.
fn axisymmetric_overrides(tolerance: f64) -> [String; 2] {
    [
        "model.kind=axisymmetric".to_owned(),
        format!("model.tolerance={tolerance:e}"),
    ]
}

/// Computes all quantities, or one of them, and writes `accuracy.md`, `accuracy.csv` and two charts
/// per quantity into a folder.
pub fn run(quick: bool, only: Option<&str>, out: &Path) -> Result<Vec<Quantity>> {
    let is_asked = |key: &str| only.is_none_or(|only| only == key);
    let asked = QUANTITIES.iter().filter(|(key, _)| is_asked(key));
    let quantities = asked.map(|(_, compute)| compute(quick));
    let quantities: Vec<Quantity> = quantities.collect::<Result<_>>()?;
    if let (Some(only), true) = (only, quantities.is_empty()) {
        bail!("there is no quantity '{only}'; choose drag, pair, speed or net");
    }
    let mut page = Page::new(
        "Speed against accuracy",
        "accuracy",
        "Seconds are wall-clock times from the scene to the value, mesh generation included. Errors are \
         relative to exact values. error: that of the answer; uncorrected: that of the value before the estimated discretisation error was subtracted, which \
         takes the same seconds; bar: the error bar that the program gives; order: of both errors in the element size, from the next larger size to this one.",
    );
    for quantity in &quantities {
        page.heading(quantity.title.clone());
        quantity.add_charts(&mut page)?;
        page.table(table(std::slice::from_ref(quantity)));
        if let Some([least, largest]) = quantity.gains_at_equal_seconds() {
            page.text(format!(
                "In equal seconds, the best mesh of a given size has an error {least:.0} to {largest:.0} times smaller than before the correction."
            ));
        }
    }
    page.write(out, "accuracy")?;
    page::write(out, "accuracy.csv", &table(&quantities).csv())?;
    Ok(quantities)
}

/// The points of these quantities.
fn table(quantities: &[Quantity]) -> Table {
    let mut table = Table::new([
        "quantity",
        "method",
        "choice",
        "dofs",
        "seconds",
        "error",
        "uncorrected",
        "bar",
        "order",
        "uncorrected order",
    ]);
    for quantity in quantities {
        let order = |order: Option<f64>| optional(order, |order| fixed(order, 1));
        for (number, p) in quantity.points.iter().enumerate() {
            table.push([
                quantity.key.into(),
                p.method.clone().into(),
                p.choice.clone().into(),
                count(p.dofs),
                fixed(p.seconds, 3),
                exp(p.error, 1),
                optional(p.uncorrected, |error| exp(error, 1)),
                optional(p.bar, |bar| exp(bar, 1)),
                order(quantity.order(number, |p| Some(p.error))),
                order(quantity.order(number, |p| p.uncorrected)),
            ]);
        }
    }
    table
}
