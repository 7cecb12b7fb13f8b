//! Several right-hand sides at once against one by one.

use std::fmt::Write;
use std::time::Instant;

use anyhow::{Context, Result};
use linalg::{KrylovParams, LinearOperator, fgmres_columns};
use rigid::Independent;
use swimmer::Scene;
use swimmer::models::{Configuration, FemModel};

/// Rounds of which the fastest counts.
const ROUNDS: usize = 3;

/// Right-hand sides a pass over the matrices.
const AT_ONCE: [usize; 4] = [1, 2, 3, 6];

/// One size of the mesh.
pub struct Row {
    unknowns: usize,
    iterations: (usize, usize),
    /// Seconds of all solves for each number of [`AT_ONCE`].
    seconds: [f64; AT_ONCE.len()],
}

/// Three unit spheres on a line, eight apart, in a ball of 40 radii, each under a force.
fn scene(size: f64) -> String {
    let mut text = format!(
        "domain = {{ kind = \"ball\", radius = 40 }}\nmodel.kind = \"fem\"\nfem = {{ size_factor = {size:?}, mirror = \"off\" }}\n"
    );
    for (k, x) in [-10, 0, 10].into_iter().enumerate() {
        let _ = write!(
            text,
            "[[bodies]]\nname = \"s{k}\"\nradius = 1\nposition = [{x}, 0, 0]\nforce = [1, 0, 0]\n"
        );
    }
    text
}

/// Solves for the 18 columns of the mobility of three spheres.
pub fn measure(quick: bool) -> Result<Vec<Row>> {
    let sizes: &[f64] = if quick { &[1.75] } else { &[1.0, 0.5] };
    sizes.iter().map(|&size| of_size(size)).collect()
}

fn of_size(size: f64) -> Result<Row> {
    let scene = Scene::parse(&scene(size))?;
    let state = scene.initial_state();
    let configuration = Configuration {
        state: &state,
        lengths: &[],
    };
    let constrained = FemModel::new(&scene)?.system(configuration, &[], &Independent)?;
    let mut preconditioner = constrained.preconditioner()?;
    let system = &constrained.system;
    let loads = system.border_range();
    let right = |load: usize| {
        let mut right = vec![0.0; constrained.rhs.len()];
        right[load] = 1.0;
        right
    };
    let parameters = KrylovParams::default();
    let mut iterations = Vec::new();
    let mut best = [f64::INFINITY; AT_ONCE.len()];
    // In turns, so that what else the machine does meets all.
    for _ in 0..ROUNDS {
        for (best, at_once) in best.iter_mut().zip(AT_ONCE) {
            let mut seconds = 0.0;
            for first in loads.clone().step_by(at_once) {
                let rights: Vec<_> = (first..loads.end.min(first + at_once)).map(right).collect();
                let mut solutions = vec![vec![0.0; constrained.rhs.len()]; rights.len()];
                let rights: Vec<&[f64]> = rights.iter().map(Vec::as_slice).collect();
                let mut columns: Vec<_> = solutions.iter_mut().map(Vec::as_mut_slice).collect();
                let clock = Instant::now();
                let reports = fgmres_columns(
                    system,
                    &mut preconditioner,
                    &rights,
                    &mut columns,
                    &parameters,
                )?;
                seconds += clock.elapsed().as_secs_f64();
                iterations.extend(reports.iter().map(|report| report.iterations));
            }
            *best = best.min(seconds);
        }
    }
    let (least, most) = (iterations.iter().min(), iterations.iter().max());
    let iterations = least.zip(most).context("a scene without bodies")?;
    Ok(Row {
        unknowns: system.rows(),
        iterations: (*iterations.0, *iterations.1),
        seconds: best,
    })
}

/// The rows as a section of a page.
pub fn section(rows: &[Row]) -> Result<String> {
    let mut text = String::from(
        "\n## Several right-hand sides\n\nThe 18 columns of the mobility of three spheres, solved one by one and several at once: set-up apart, the fastest of three rounds in turns.\n\
         Each column comes out the same to the last bit; a pass over the matrices serves all of those solved at once.\n\n\
         | unknowns | iterations | at once | seconds | of one by one |\n|--:|--:|--:|--:|--:|\n",
    );
    for row in rows {
        for (at_once, seconds) in AT_ONCE.iter().zip(row.seconds) {
            let (least, most) = row.iterations;
            writeln!(
                text,
                "| {} | {least} to {most} | {at_once} | {seconds:.2} | {:.2} |",
                row.unknowns,
                seconds / row.seconds[0]
            )?;
        }
    }
    Ok(text)
}
