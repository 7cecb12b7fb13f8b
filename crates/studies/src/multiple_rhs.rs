//! Time to solve for several right-hand sides at once, compared with one by one.

use std::fmt::Write;
use std::time::Instant;

use anyhow::{Context, Result};
use linalg::{KrylovParams, LinearOperator, fgmres_columns};
use rigid::Independent;
use swimmer::Scene;
use swimmer::models::{Configuration, FemModel};

/// Number of rounds; the fastest one counts.
const ROUNDS: usize = 3;

/// Number of right-hand sides that are solved at once.
const AT_ONCE: [usize; 4] = [1, 2, 3, 6];

/// Result on one mesh.
pub struct Row {
    dofs: usize,
    /// Smallest and largest number of iterations.
    iterations: (usize, usize),
    /// Seconds of all solves, for each number in [`AT_ONCE`].
    seconds: [f64; AT_ONCE.len()],
}

/// Three unit spheres on a line, eight apart, in a ball of 40 radii, each under a force.
fn scene(size: f64) -> String {
    let mut text = format!(
        "domain = {{ kind = \"ball\", radius = 40 }}\nmodel.kind = \"fem\"\nfem = {{ size_factor = {size:?}, symmetry = \"off\" }}\n"
    );
    for (k, x) in [-10, 0, 10].into_iter().enumerate() {
        let _ = write!(
            text,
            "[[bodies]]\nname = \"s{k}\"\nradius = 1\nposition = [{x}, 0, 0]\nforce = [1, 0, 0]\n"
        );
    }
    text
}

/// Solves for the 18 columns of the mobility matrix of three spheres.
pub fn measure(quick: bool) -> Result<Vec<Row>> {
    let sizes: &[f64] = if quick { &[1.75] } else { &[1.0, 0.5] };
    sizes.iter().map(|&size| of_size(size)).collect()
}

fn of_size(size: f64) -> Result<Row> {
    let scene = Scene::parse(&scene(size))?;
    let state = scene.initial_state();
    let configuration = Configuration {
        state: &state,
        shape: &[],
    };
    let constrained = FemModel::new(&scene)?.system(configuration, &[], &Independent)?;
    let mut preconditioner = constrained.preconditioner()?;
    let system = &constrained.system;
    let loads = system.border_range();
    let unit_rhs = |load: usize| {
        let mut rhs = vec![0.0; constrained.rhs.len()];
        rhs[load] = 1.0;
        rhs
    };
    let parameters = KrylovParams::default();
    let mut iterations = Vec::new();
    let mut best = [f64::INFINITY; AT_ONCE.len()];
    // Alternating, so that other load on the machine affects all of them alike.
    for _ in 0..ROUNDS {
        for (best, at_once) in best.iter_mut().zip(AT_ONCE) {
            let mut seconds = 0.0;
            for first in loads.clone().step_by(at_once) {
                let last = loads.end.min(first + at_once);
                let rhs: Vec<_> = (first..last).map(unit_rhs).collect();
                let mut solutions = vec![vec![0.0; constrained.rhs.len()]; rhs.len()];
                let rhs: Vec<&[f64]> = rhs.iter().map(Vec::as_slice).collect();
                let mut columns: Vec<_> = solutions.iter_mut().map(Vec::as_mut_slice).collect();
                let clock = Instant::now();
                let reports =
                    fgmres_columns(system, &mut preconditioner, &rhs, &mut columns, &parameters)?;
                seconds += clock.elapsed().as_secs_f64();
                iterations.extend(reports.iter().map(|report| report.iterations));
            }
            *best = best.min(seconds);
        }
    }
    let (least, most) = (iterations.iter().min(), iterations.iter().max());
    let iterations = least.zip(most).context("a scene without bodies")?;
    Ok(Row {
        dofs: system.rows(),
        iterations: (*iterations.0, *iterations.1),
        seconds: best,
    })
}

/// Section of the Markdown page with these rows.
pub fn section(rows: &[Row]) -> Result<String> {
    let mut text = String::from(
        "\n## Several right-hand sides\n\nThe 18 columns of the mobility matrix of three spheres, solved one by one and several at once: without set-up, the fastest of three alternating rounds.\n\
         Every column is the same to the last bit. Columns that are solved at once share each pass over the matrices.\n\n\
         | dofs | iterations | at once | seconds | relative to one by one |\n|--:|--:|--:|--:|--:|\n",
    );
    for row in rows {
        for (at_once, seconds) in AT_ONCE.iter().zip(row.seconds) {
            let (least, most) = row.iterations;
            writeln!(
                text,
                "| {} | {least} to {most} | {at_once} | {seconds:.2} | {:.2} |",
                row.dofs,
                seconds / row.seconds[0]
            )?;
        }
    }
    Ok(text)
}
