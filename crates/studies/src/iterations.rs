//! Iterations of the block solver for varied element sizes, containers, gaps, numbers of bodies and
//! radius ratios, beside those with an exact velocity solve, and its speed-up by two threads and by
//! several right-hand sides at once.

use std::fmt::Write;
use std::path::Path;

use anyhow::Result;
use linalg::{KrylovParams, LinearOperator, Multigrid, MultigridParams, fgmres};
use rayon::ThreadPoolBuilder;
use rigid::Eliminated;
use swimmer::Scene;
use swimmer::models::{Configuration, FemModel, InstantaneousSolution};
use swimmer::solve_start;

use crate::{folder, machine, multiple_rhs};

/// Number of rounds; the fastest one counts.
const ROUNDS: usize = 3;

/// Largest system whose velocity block is solved exactly: its factors take about a gigabyte.
const EXACT_DOFS: usize = 140_000;

/// One scene, solved to the default tolerance and down to rounding errors.
struct Row {
    family: &'static str,
    choice: String,
    dofs: usize,
    iterations: usize,
    /// Iterations with an exact velocity solve, up to [`EXACT_DOFS`].
    floor: Option<usize>,
    residual: f64,
    /// Largest difference between the velocities of both solves, over the largest velocity.
    velocity_error: f64,
}

/// Solves every case, prints the table and writes `iterations.md` into a folder.
pub fn run(quick: bool, out: &Path) -> Result<()> {
    let rows = cases(quick)
        .into_iter()
        .map(|(family, choice, scene)| measure(family, choice, &scene))
        .collect::<Result<Vec<_>>>()?;
    let scaling = scaling(quick)?;
    let mut text = markdown(&rows, &scaling)?;
    text += &multiple_rhs::section(&multiple_rhs::measure(quick)?)?;
    println!("{text}");
    folder::write(out, [("iterations.md", text)])
}

/// Three spheres on a line in a ball, the left arm closing at unit speed.
fn chain(radii: [f64; 3], arm: f64, container: f64, size: f64) -> String {
    let ball = format!("{{ kind = \"ball\", radius = {container:?} }}");
    chain_in(&ball, radii, arm, size)
}

/// Three unit spheres, one apart, in a box of these edges or, without edges, in a cylinder.
fn channel(edges: Option<[f64; 3]>, radius: f64) -> String {
    let domain = match edges {
        Some(edges) => format!("{{ kind = \"box\", size = {edges:?} }}"),
        None => format!("{{ kind = \"cylinder\", radius = {radius:?} }}"),
    };
    chain_in(&domain, [1.0; 3], 1.0, 1.0)
}

/// Three spheres on a line in a container, the left arm closing at unit speed.
fn chain_in(domain: &str, radii: [f64; 3], arm: f64, size: f64) -> String {
    let smallest = radii.iter().copied().fold(f64::INFINITY, f64::min);
    let mut text = format!("domain = {domain}\nmodel.kind = \"fem\"\nfem.size_factor = {size:?}\n");
    let place = [-arm - radii[0] - radii[1], 0.0, arm + radii[1] + radii[2]];
    for (k, (radius, x)) in radii.iter().zip(place).enumerate() {
        let _ = write!(
            text,
            "[[bodies]]\nname = \"s{k}\"\nradius = {radius:?}\nposition = [{x:?}, 0, 0]\n"
        );
    }
    for (name, body) in [("left", 0), ("right", 2)] {
        let _ = write!(
            text,
            "[[links]]\nname = \"{name}\"\nbody = \"s{body}\"\nto = \"s1\"\n"
        );
    }
    let _ = write!(
        text,
        "[[gait.phases]]\nlink = \"left\"\nlength = {:?}\nduration = 1\n",
        radii[0] + radii[1] + arm - 0.05 * arm.min(smallest)
    );
    text
}

/// Unit spheres on a cubic lattice of spacing four inside a ball, each pulled in another direction.
fn lattice(bodies: usize) -> String {
    let side = (bodies as f64).cbrt().ceil() as usize;
    let middle = 0.5 * (side as f64 - 1.0);
    let radius = 4.0 * middle * 3.0_f64.sqrt() + 12.0;
    let mut text = format!(
        "domain = {{ kind = \"ball\", radius = {radius:?} }}\nmodel.kind = \"fem\"\nfem.size_factor = 1.5\n"
    );
    for k in 0..bodies {
        let at = [k % side, k / side % side, k / side / side].map(|i| 4.0 * (i as f64 - middle));
        let turn = k as f64;
        let _ = write!(
            text,
            "[[bodies]]\nname = \"s{k}\"\nradius = 1\nposition = [{:?}, {:?}, {:?}]\nforce = [{:?}, {:?}, 1]\n",
            at[0],
            at[1],
            at[2],
            turn.sin(),
            turn.cos()
        );
    }
    text
}

fn cases(quick: bool) -> Vec<(&'static str, String, String)> {
    let mut cases = Vec::new();
    let unit = [1.0; 3];
    let sizes: &[f64] = if quick {
        &[1.75, 1.0]
    } else {
        &[1.75, 1.0, 0.5, 0.36, 0.27]
    };
    for &size in sizes {
        cases.push((
            "element size",
            format!("{:.2} radii", 0.4 * size),
            chain(unit, 8.0, 40.0, size),
        ));
    }
    let containers: &[f64] = if quick {
        &[20.0, 100.0]
    } else {
        &[20.0, 40.0, 100.0, 200.0, 500.0]
    };
    for &container in containers {
        cases.push((
            "container",
            format!("{container} radii"),
            chain(unit, 8.0, container, 1.0),
        ));
    }
    let boxes: &[[f64; 3]] = if quick {
        &[[100.0, 10.0, 10.0]]
    } else {
        &[
            [60.0, 60.0, 60.0],
            [80.0, 60.0, 60.0],
            [100.0, 40.0, 40.0],
            [60.0, 12.0, 12.0],
            [100.0, 10.0, 10.0],
        ]
    };
    for &edges in boxes {
        let [x, y, z] = edges;
        cases.push((
            "box",
            format!("{x} x {y} x {z} radii"),
            channel(Some(edges), 0.0),
        ));
    }
    let cylinders: &[f64] = if quick { &[5.0] } else { &[2.5, 5.0, 20.0] };
    for &radius in cylinders {
        cases.push(("cylinder", format!("{radius} radii"), channel(None, radius)));
    }
    let gaps: &[f64] = if quick {
        &[1.0, 0.1]
    } else {
        &[8.0, 4.0, 1.0, 0.3, 0.1]
    };
    for &gap in gaps {
        cases.push(("gap", format!("{gap} radii"), chain(unit, gap, 40.0, 1.0)));
    }
    let bodies: &[usize] = if quick { &[1, 8] } else { &[1, 2, 3, 8, 27] };
    for &count in bodies {
        cases.push(("bodies", count.to_string(), lattice(count)));
    }
    let ratios: &[f64] = if quick {
        &[5.0]
    } else {
        &[1.0, 2.0, 5.0, 10.0, 20.0]
    };
    for &ratio in ratios {
        let radii = [1.0, ratio, 1.0];
        cases.push((
            "radius ratio",
            format!("1:{ratio}"),
            chain(radii, 4.0, 10.0 * ratio.max(4.0), 1.0),
        ));
    }
    cases
}

fn solve(scene: &str, rtol: f64) -> Result<InstantaneousSolution> {
    let scene = Scene::parse(&format!(
        "fem.rtol = {rtol:e}\nfem.symmetry = \"off\"\nfem.estimates = \"off\"\n{scene}"
    ))?;
    let mut model = FemModel::new(&scene)?;
    Ok(solve_start(&scene, &mut model)?)
}

/// Iterations with an exact velocity solve on the mesh of the first configuration.
fn floor(scene: &str) -> Result<Option<usize>> {
    let scene = Scene::parse(&format!("fem.symmetry = \"off\"\n{scene}"))?;
    let state = scene.initial_state();
    let shape = scene.articulation().initial_shape();
    let configuration = Configuration {
        state: &state,
        shape,
    };
    let mut rates = vec![0.0; shape.len()];
    if let Some(first) = rates.first_mut() {
        *first = -1.0;
    }
    let assembled = FemModel::new(&scene)?.system(configuration, &rates, &Eliminated)?;
    let system = &assembled.system;
    if system.rows() > EXACT_DOFS {
        return Ok(None);
    }
    let exact = Multigrid::new(system.velocity_block(), &MultigridParams::direct())?;
    let mut preconditioner = assembled.preconditioner_with(exact)?;
    let mut solution = vec![0.0; system.rows()];
    let report = fgmres(
        system,
        &mut preconditioner,
        &assembled.rhs,
        &mut solution,
        &KrylovParams::default(),
    )?;
    Ok(Some(report.iterations))
}

fn measure(family: &'static str, choice: String, scene: &str) -> Result<Row> {
    let [usual, exact] = [1e-8, 1e-12].map(|rtol| solve(scene, rtol));
    let (usual, exact) = (usual?, exact?);
    let largest = |velocities: &mut dyn Iterator<Item = f64>| velocities.fold(0.0_f64, f64::max);
    let pairs = usual.bodies.iter().zip(&exact.bodies);
    let miss = largest(&mut pairs.map(|(a, b)| (a.velocity - b.velocity).norm()));
    let speed = largest(&mut exact.bodies.iter().map(|b| b.velocity.norm()));
    let floor = floor(scene)?;
    eprintln!(
        "{family} {choice}: {} iterations, floor {floor:?}",
        usual.solver.iterations
    );
    Ok(Row {
        family,
        choice,
        dofs: usual.dofs.total,
        iterations: usual.solver.iterations,
        floor,
        residual: usual.solver.true_relative_residual,
        velocity_error: miss / speed,
    })
}

/// Seconds with one and with two threads.
struct Scaling {
    dofs: usize,
    /// Assembly, set-up and solve, without mesh generation.
    phases: [[f64; 2]; 3],
}

fn scaling(quick: bool) -> Result<Vec<Scaling>> {
    let sizes: &[f64] = if quick { &[1.0] } else { &[0.5, 0.36, 0.27] };
    sizes
        .iter()
        .map(|&size| {
            let scene = chain([1.0; 3], 8.0, 40.0, size);
            let mut found = Scaling {
                dofs: 0,
                phases: [[f64::INFINITY; 2]; 3],
            };
            // Alternating, so that other load on the machine affects both alike.
            for _ in 0..ROUNDS {
                for threads in [1, 2] {
                    let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
                    let solved = pool.install(|| solve(&scene, 1e-8))?;
                    let seconds = solved.seconds;
                    let phases = [seconds.assembly, seconds.setup, seconds.solve];
                    for (best, own) in found.phases.iter_mut().zip(phases) {
                        best[threads - 1] = best[threads - 1].min(own);
                    }
                    found.dofs = solved.dofs.total;
                }
            }
            Ok(found)
        })
        .collect()
}

fn markdown(rows: &[Row], scaling: &[Scaling]) -> Result<String> {
    let mut text = format!(
        "# Iterations of the block solver\n\n{}, {}. Made by `cargo xtask iterations`.\n\n\
         Three spheres on a line in a ball, gaps of 8 and a ball of 40 radii unless another value is given, one arm closing; for numbers of bodies, spheres on a lattice of\n\
         spacing four, each pulled in another direction. Solved to `fem.rtol` = 1e-8; velocities are compared with a solve to 1e-12 on the same mesh.\n\
         In boxes and cylinders the gaps are 1. \"Exact\" counts the iterations with an exact solve of the velocity block in the place of the V-cycle, up to {EXACT_DOFS} dofs.\n\n\
         | varied | choice | dofs | iterations | exact | true residual | solver error of U |\n|:--|:--|--:|--:|--:|--:|--:|\n",
        machine::today(),
        machine::processor()
    );
    for row in rows {
        let floor = row.floor.map_or("-".to_owned(), |floor| floor.to_string());
        writeln!(
            text,
            "| {} | {} | {} | {} | {floor} | {:.1e} | {:.1e} |",
            row.family, row.choice, row.dofs, row.iterations, row.residual, row.velocity_error
        )?;
    }
    text.push_str(
        "\n## A second thread\n\nSeconds with one and with two threads, the fastest of three alternating rounds for each phase. Results are the same to the last bit.\n\n\
         | dofs | assembly | set-up | solve | all | ratio |\n|--:|--:|--:|--:|--:|--:|\n",
    );
    for Scaling { dofs, phases } in scaling {
        let all = [0, 1].map(|threads| phases.iter().map(|phase| phase[threads]).sum::<f64>());
        write!(text, "| {dofs} ")?;
        for [one, two] in phases.iter().chain([&all]) {
            write!(text, "| {one:.3}, {two:.3} ")?;
        }
        writeln!(text, "| {:.2} |", all[0] / all[1])?;
    }
    Ok(text)
}
