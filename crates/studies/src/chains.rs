//! Chains of three to six spheres: the best stroke, beside the one that learning finds.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use anyhow::{Result, anyhow};
use design::{DesignedStroke, design_stroke};
use swimmer::Scene;

use crate::chart::{Series, Style};
use crate::folder;
use crate::linear_chart::Linear;
use crate::machine::{processor, today};

/// Lengths of extended and contracted arms in radii, those of the three-sphere swimmer of Table 1.
const ARMS: (f64, f64) = (10.0, 6.0);

/// Numbers of spheres, and the displacement per step of the learned cycle: the largest mean of a
/// cycle over all states of the joints (Karp 1978), `swim learn`; the first two are exact ones.
const LEARNED: [(usize, f64); 4] = [
    (3, 0.039_951_335),
    (4, 0.064_539_809),
    (5, 0.081_774_8),
    (6, 0.094_786_8),
];

/// One chain.
struct Row {
    spheres: usize,
    found: DesignedStroke,
    /// Efficiency of the best stroke, by its run.
    efficiency: f64,
    /// Displacement per step and efficiency of the learned cycle, by the table.
    learned: (f64, f64),
    seconds: f64,
}

/// Largest relative error of the displacement of the learned cycle by a table of degree 4, whose
/// coefficients decrease by a factor of `3 + sqrt(8)` per degree.
const LARGEST_ERROR: f64 = 1e-3;

/// Folder of the tables and strokes, with which an interrupted study continues.
const STROKES: &str = "out/chains";

/// Searches the best strokes and writes `chains.md` and `chains.svg` into a folder.
pub fn run(quick: bool, out: &Path) -> Result<()> {
    let mut rows = Vec::new();
    for (spheres, known) in LEARNED.iter().take(if quick { 1 } else { LEARNED.len() }) {
        let row = chain(*spheres, &Path::new(STROKES).join(spheres.to_string()))?;
        let error = (row.learned.0 / known - 1.0).abs();
        anyhow::ensure!(
            error < LARGEST_ERROR,
            "{spheres} spheres: the learned cycle moves by {} per step instead of {known}",
            row.learned.0
        );
        eprintln!("{}", line(&row));
        rows.push(row);
    }
    let svg = chart(&rows)?;
    folder::write(out, [("chains.md", page(&rows)), ("chains.svg", svg)])
}

fn chain(spheres: usize, out: &Path) -> Result<Row> {
    let clock = Instant::now();
    let scene = Scene::parse(&scene_text(spheres))?;
    let found = design_stroke(&scene, out, &mut ())?;
    // Drag of all spheres, with radius and viscosity 1.
    let drag = 6.0 * std::f64::consts::PI * spheres as f64;
    let efficiency = |displacement: f64, product: f64| drag * displacement.powi(2) / product;
    let (totals, product) = found
        .gait
        .ok_or_else(|| anyhow!("the learned cycle of {spheres} spheres leaves the table"))?;
    let learned = totals.displacement.norm();
    Ok(Row {
        spheres,
        efficiency: efficiency(found.run_displacement, found.outcome.work * found.period),
        learned: (
            learned / (2 * (spheres - 1)) as f64,
            efficiency(learned, product),
        ),
        seconds: clock.elapsed().as_secs_f64(),
        found,
    })
}

/// A chain along x whose gait is the learned cycle: all arms contract one after the other, then
/// extend in the same order.
fn scene_text(spheres: usize) -> String {
    let (extended, contracted) = ARMS;
    let mut text = "model.kind = \"multipole\"\ndomain.kind = \"unbounded\"\n".to_owned();
    // Four digits for three spheres; tables of more joints are coarser.
    text += match spheres {
        3 => "optimise.tolerance = 2e-4\n",
        _ => "optimise.tolerance = 1e-2\noptimise.terms = 16\n",
    };
    // Writing to a String cannot fail.
    for k in 0..spheres {
        let x = extended * k as f64;
        let _ = writeln!(
            text,
            "[[bodies]]\nname = \"s{k}\"\nradius = 1\nposition = [{x:?}, 0, 0]"
        );
    }
    let arms = 0..spheres - 1;
    for k in arms.clone() {
        let to = k + 1;
        let _ = writeln!(
            text,
            "[[links]]\nname = \"a{k}\"\nbody = \"s{k}\"\nto = \"s{to}\""
        );
    }
    for length in [contracted, extended] {
        for k in arms.clone() {
            let _ = writeln!(
                text,
                "[[gait.phases]]\nlink = \"a{k}\"\nlength = {length:?}"
            );
        }
    }
    text
}

fn line(row: &Row) -> String {
    let optimum = &row.found.optimum;
    let (interpolation, model) = row.found.table.geometry.errors();
    format!(
        "| {} | {:.4e} | {:.5} ± {:.5} | {:.5} | {:.2} % | {:.4e} | {:.6} | {} | {:.1e} | {} | {:.0} |",
        row.spheres,
        row.efficiency,
        row.found.run_displacement,
        row.found.outcome.error_estimate.total(),
        optimum.totals.displacement.norm(),
        100.0 * optimum.refinement_error,
        row.learned.1,
        row.learned.0,
        row.found.table.geometry.points(),
        interpolation + model,
        optimum.iterations,
        row.seconds,
    )
}

fn page(rows: &[Row]) -> String {
    let (extended, contracted) = ARMS;
    let mut text = format!(
        "# Chains of spheres\n\n\
         Written by `cargo xtask chains`, {}, {}.\n\n\
         Equal spheres in a row, in unbounded fluid, each arm between {contracted} and {extended} \
         radii: the closed stroke of the highest Lighthill efficiency `6 π μ r Δ² / (E T)`, with the \
         sum `r` of the radii. Displacement and energy are those of the run of the optimum by \
         multipoles, without the table. \"Refinement\" is the change of the efficiency by the last \
         doubling of the number of terms.\n\n\
         The learned cycle contracts the arms one after the other and extends them in the same order: \
         the best cycle of the states that [`swim learn`](design.md#swim-learn) knows. Its efficiency \
         is that at constant power, by the table.\n\n\
         ![Efficiency against the number of spheres](chains.svg)\n\n\
         | spheres | efficiency | displacement per cycle | by the table | refinement | efficiency, learned | \
         displacement per step, learned | shapes | table error per unit rate | iterations | time, s |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n",
        today(),
        processor(),
    );
    for row in rows {
        text += &line(row);
        text.push('\n');
    }
    text
}

/// Efficiencies against the number of spheres.
fn chart(rows: &[Row]) -> Result<String> {
    let most = rows.iter().map(|row| row.spheres).max().unwrap_or(3);
    let highest = (rows.iter()).fold(0.0_f64, |high, row| high.max(row.efficiency));
    let series = |name: &str, of: fn(&Row) -> f64| Series {
        name: name.to_owned(),
        points: rows
            .iter()
            .map(|row| (row.spheres as f64, of(row)))
            .collect(),
        style: Style::Curve,
    };
    let chart = Linear {
        x: "number of spheres",
        y: "Lighthill efficiency",
        x_range: (2.5, most as f64 + 0.5),
        y_range: (0.0, 1.15 * highest),
        x_labels: most - 1,
        decimals: [0, 4],
        series: vec![
            series("best stroke", |row| row.efficiency),
            series("learned cycle, at constant power", |row| row.learned.1),
        ],
    };
    chart.svg()
}
