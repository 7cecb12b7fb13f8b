//! Speed against accuracy: one quantity at a time, every way to compute it, error over seconds and over unknowns.

mod quantities;
mod strokes;

use std::fmt::Write;
use std::path::Path;

use anyhow::Result;

use crate::chart::{LogLog, Series, Style, pareto_front};
use crate::{folder, machine};

/// One computed value.
#[derive(Clone, Debug)]
pub struct Point {
    /// Which curve it is on.
    pub method: String,
    /// What was chosen on that curve: an element size, an order, a tolerance.
    pub choice: String,
    /// Unknowns of the largest system; zero for models without a mesh.
    pub dofs: usize,
    /// Wall-clock seconds of everything, from the scene to the value.
    pub seconds: f64,
    /// Relative error against the exact value.
    pub error: f64,
    /// The error bar that came with the value, relative to it, where there was one.
    pub claimed: Option<f64>,
}

/// A quantity with all its points.
#[derive(Clone, Debug)]
pub struct Quantity {
    /// Name in file names.
    pub key: &'static str,
    /// What it is, with its exact value.
    pub title: String,
    pub points: Vec<Point>,
}

/// Computes all quantities, or the one of a key, and writes `accuracy.md`, `accuracy.csv` and two charts a quantity into a folder.
pub fn run(quick: bool, only: Option<&str>, out: &Path) -> Result<Vec<Quantity>> {
    let quantities = quantities::all(quick, only)?;
    let text = markdown(&quantities)?;
    println!("{text}");
    folder::write(
        out,
        [("accuracy.md", text), ("accuracy.csv", csv(&quantities)?)],
    )?;
    for quantity in &quantities {
        let key = quantity.key;
        // Models without a mesh have no unknowns to speak of.
        let unknowns = quantity.chart("unknowns", |p| p.dofs as f64).svg()?;
        folder::write(
            out,
            [
                (
                    format!("accuracy-{key}.svg"),
                    quantity.chart("seconds", |p| p.seconds).svg()?,
                ),
                (format!("accuracy-{key}-unknowns.svg"), unknowns),
            ],
        )?;
    }
    Ok(quantities)
}

impl Quantity {
    /// Error over a cost, a curve a method, with the Pareto front.
    pub fn chart(&self, cost_name: &str, cost: impl Fn(&Point) -> f64) -> LogLog {
        let mut methods: Vec<&str> = Vec::new();
        for point in &self.points {
            if !methods.contains(&point.method.as_str()) {
                methods.push(&point.method);
            }
        }
        let mut series: Vec<Series> = methods
            .into_iter()
            .map(|method| Series {
                name: method.to_owned(),
                points: self
                    .points
                    .iter()
                    .filter(|p| p.method == method)
                    .map(|p| (cost(p), p.error))
                    .collect(),
                style: Style::Curve,
            })
            .collect();
        let all: Vec<(f64, f64)> = self.points.iter().map(|p| (cost(p), p.error)).collect();
        series.push(Series {
            name: "Pareto front: nothing here is both cheaper and better".into(),
            points: pareto_front(&all),
            style: Style::Front,
        });
        LogLog {
            title: self.title.clone(),
            x: cost_name.into(),
            y: "relative error".into(),
            series,
        }
    }
}

fn markdown(quantities: &[Quantity]) -> Result<String> {
    let mut text = format!(
        "# Speed against accuracy\n\n{}, {}. Made by `cargo xtask accuracy`. Seconds are wall-clock and hold everything, meshes included; errors are \
         against exact values; the bar is what the program itself said of its error.\n",
        machine::today(),
        machine::processor()
    );
    for quantity in quantities {
        write!(
            text,
            "\n## {}\n\n![error against seconds](accuracy-{}.svg)\n\n| method | choice | unknowns | seconds | error | bar |\n|:--|:--|--:|--:|--:|--:|\n",
            quantity.title, quantity.key
        )?;
        for p in &quantity.points {
            let bar = p.claimed.map_or("-".into(), |bar| format!("{bar:.1e}"));
            writeln!(
                text,
                "| {} | {} | {} | {:.3} | {:.1e} | {bar} |",
                p.method, p.choice, p.dofs, p.seconds, p.error
            )?;
        }
    }
    Ok(text)
}

fn csv(quantities: &[Quantity]) -> Result<String> {
    let mut text = String::from("quantity,method,choice,unknowns,seconds,error,claimed\n");
    for quantity in quantities {
        for p in &quantity.points {
            let claimed = p.claimed.map_or(String::new(), |bar| format!("{bar:e}"));
            writeln!(
                text,
                "{},{},{},{},{:.5},{:e},{claimed}",
                quantity.key,
                p.method.replace(',', ";"),
                p.choice.replace(',', ";"),
                p.dofs,
                p.seconds,
                p.error
            )?;
        }
    }
    Ok(text)
}
