//! Iterations of the block solver for varied element sizes, containers, gaps, numbers of bodies and
//! radius ratios, compared with those of an exact velocity solve, and its speed-up by two threads
//! and by several right-hand sides at once.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use linalg::{KrylovParams, LinearOperator, Multigrid, MultigridParams, fgmres, fgmres_columns};
use rayon::ThreadPoolBuilder;
use rigid::{Eliminated, Independent};
use swimmer::models::{Configuration, FemModel, InstantaneousSolution};
use swimmer::{Scene, solve_start};

use crate::page::Page;
use crate::scenes::SceneText;
use crate::table::{Cell, Table, count, exp, fixed, optional};

/// Number of rounds; the fastest one counts.
const ROUNDS: usize = 3;

/// Largest system whose velocity block is solved exactly: its factors take about a gigabyte.
const MAX_EXACT_DOFS: usize = 140_000;

/// Numbers of right-hand sides that are solved at once.
const AT_ONCE: [usize; 4] = [1, 2, 3, 6];

/// A scene of a family.
struct Case {
    /// What is varied.
    family: &'static str,
    choice: String,
    scene: SceneText,
}

/// Solves every case, prints the tables and writes `iterations.md` into a folder.
pub fn run(quick: bool, out: &Path) -> Result<()> {
    let mut page = Page::new(
        "Iterations of the block solver",
        "iterations",
        format!(
            "\n\nThree spheres on a line in a ball, gaps of 8 and a ball of 40 radii unless another value is given, one arm closing; for numbers of bodies, spheres on a lattice of\n\
             spacing four, each pulled in another direction. Solved to `fem.rtol` = 1e-8; velocities are compared with a solve to 1e-12 on the same mesh.\n\
             In boxes and cylinders the gaps are 1. \"Exact\" counts the iterations with an exact solve of the velocity block in the place of the V-cycle, up to {MAX_EXACT_DOFS} dofs."
        ),
    );
    let mut table = Table::new([
        "varied",
        "choice",
        "dofs",
        "iterations",
        "exact",
        "true residual",
        "solver error of U",
    ]);
    for case in cases(quick) {
        table.push(measure(case)?);
    }
    page.table(table);
    page.heading("A second thread");
    page.text("Seconds with one and with two threads, the fastest of three alternating rounds for each phase. Results are the same to the last bit.");
    page.table(scaling(quick)?);
    page.heading("Several right-hand sides");
    page.text(
        "The 18 columns of the mobility matrix of three spheres, solved one by one and several at once: without set-up, the fastest of three alternating rounds.\n\
         Every column is the same to the last bit. Columns that are solved at once share each pass over the matrices.",
    );
    page.table(several_rhs(quick)?);
    page.write(out, "iterations")
}

/// Three spheres on a line in a container, the left arm closing at unit speed.
fn chain(domain: &str, radii: [f64; 3], gap: f64, size: f64) -> SceneText {
    let smallest = radii.iter().copied().fold(f64::INFINITY, f64::min);
    let arms = [gap + radii[0] + radii[1], gap + radii[1] + radii[2]];
    SceneText::new(format!("domain = {domain}\nmodel.kind = \"fem\""))
        .key("fem.size_factor", size)
        .swimmer(radii, arms)
        .phase("left", radii[0] + radii[1] + gap - 0.05 * gap.min(smallest))
        .line("duration = 1")
}

fn ball(radius: f64) -> String {
    format!("{{ kind = \"ball\", radius = {radius:?} }}")
}

/// Unit spheres on a cubic lattice of spacing four inside a ball, each pulled in another direction.
fn lattice(bodies: usize) -> SceneText {
    let side = (bodies as f64).cbrt().ceil() as usize;
    let middle = 0.5 * (side as f64 - 1.0);
    let domain = ball(4.0 * middle * 3.0_f64.sqrt() + 12.0);
    let text = format!("domain = {domain}\nmodel.kind = \"fem\"\nfem.size_factor = 1.5");
    (0..bodies).fold(SceneText::new(text), |text, k| {
        let at = [k % side, k / side % side, k / side / side].map(|i| 4.0 * (i as f64 - middle));
        let turn = k as f64;
        let force = [turn.sin(), turn.cos(), 1.0];
        text.sphere(format_args!("s{k}"), 1.0, at)
            .key("force", force)
    })
}

/// The first values of a quick study, or all of a full one.
fn some<T>(quick: bool, of_quick: &'static [T], all: &'static [T]) -> &'static [T] {
    if quick { of_quick } else { all }
}

fn cases(quick: bool) -> Vec<Case> {
    let mut cases = Vec::new();
    let mut add = |family, choice: String, scene| {
        cases.push(Case {
            family,
            choice,
            scene,
        });
    };
    let unit = [1.0; 3];
    for &size in some(quick, &[1.75, 1.0], &[1.75, 1.0, 0.5, 0.36, 0.27]) {
        let choice = format!("{:.2} radii", 0.4 * size);
        add("element size", choice, chain(&ball(40.0), unit, 8.0, size));
    }
    for &radius in some(quick, &[20.0, 100.0], &[20.0, 40.0, 100.0, 200.0, 500.0]) {
        let choice = format!("{radius} radii");
        add("container", choice, chain(&ball(radius), unit, 8.0, 1.0));
    }
    for &[x, y, z] in some(
        quick,
        &[[100.0, 10.0, 10.0]],
        &[
            [60.0, 60.0, 60.0],
            [80.0, 60.0, 60.0],
            [100.0, 40.0, 40.0],
            [60.0, 12.0, 12.0],
            [100.0, 10.0, 10.0],
        ],
    ) {
        let domain = format!("{{ kind = \"box\", size = [{x:?}, {y:?}, {z:?}] }}");
        let choice = format!("{x} x {y} x {z} radii");
        add("box", choice, chain(&domain, unit, 1.0, 1.0));
    }
    for &radius in some(quick, &[5.0], &[2.5, 5.0, 20.0]) {
        let domain = format!("{{ kind = \"cylinder\", radius = {radius:?} }}");
        let choice = format!("{radius} radii");
        add("cylinder", choice, chain(&domain, unit, 1.0, 1.0));
    }
    for &gap in some(quick, &[1.0, 0.1], &[8.0, 4.0, 1.0, 0.3, 0.1]) {
        let choice = format!("{gap} radii");
        add("gap", choice, chain(&ball(40.0), unit, gap, 1.0));
    }
    for &count in some(quick, &[1, 8], &[1, 2, 3, 8, 27]) {
        add("bodies", count.to_string(), lattice(count));
    }
    for &ratio in some(quick, &[5.0], &[1.0, 2.0, 5.0, 10.0, 20.0]) {
        let domain = ball(10.0 * f64::max(ratio, 4.0));
        let scene = chain(&domain, [1.0, ratio, 1.0], 4.0, 1.0);
        add("radius ratio", format!("1:{ratio}"), scene);
    }
    cases
}

fn solve(scene: &SceneText, rtol: f64) -> Result<InstantaneousSolution> {
    let keys = format!("fem.rtol = {rtol:e}\nfem.symmetry = \"off\"\nfem.estimates = \"off\"\n");
    let scene = Scene::parse(&(keys + &scene.0))?;
    let mut model = FemModel::new(&scene)?;
    Ok(solve_start(&scene, &mut model)?)
}

/// Iterations with an exact velocity solve on the mesh of the first configuration.
fn iterations_with_exact_velocities(scene: &SceneText) -> Result<Option<usize>> {
    let scene = Scene::parse(&("fem.symmetry = \"off\"\n".to_owned() + &scene.0))?;
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
    if system.rows() > MAX_EXACT_DOFS {
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

/// The cells of a case, solved to the default tolerance and down to rounding errors.
fn measure(case: Case) -> Result<[Cell; 7]> {
    let [usual, exact] = [1e-8, 1e-12].map(|rtol| solve(&case.scene, rtol));
    let (usual, exact) = (usual?, exact?);
    let largest = |velocities: &mut dyn Iterator<Item = f64>| velocities.fold(0.0_f64, f64::max);
    let pairs = usual.bodies.iter().zip(&exact.bodies);
    let miss = largest(&mut pairs.map(|(a, b)| (a.velocity - b.velocity).norm()));
    let speed = largest(&mut exact.bodies.iter().map(|b| b.velocity.norm()));
    let floor = iterations_with_exact_velocities(&case.scene)?;
    let iterations = usual.solver.iterations;
    eprintln!(
        "{} {}: {iterations} iterations, exact {floor:?}",
        case.family, case.choice
    );
    Ok([
        case.family.into(),
        case.choice.into(),
        count(usual.dofs.total),
        count(iterations),
        optional(floor, count),
        exp(usual.solver.true_relative_residual, 1),
        exp(miss / speed, 1),
    ])
}

fn scaling(quick: bool) -> Result<Table> {
    let headings = ["dofs", "assembly", "set-up", "solve", "all", "ratio"];
    let mut table = Table::new(headings);
    for &size in some(quick, &[1.0], &[0.5, 0.36, 0.27]) {
        let scene = chain(&ball(40.0), [1.0; 3], 8.0, size);
        let mut dofs = 0;
        // Seconds of assembly, set-up and solve, without mesh generation.
        let mut phases = [[f64::INFINITY; 2]; 3];
        // Alternating, so that other load on the machine affects both alike.
        for _ in 0..ROUNDS {
            for threads in [1, 2] {
                let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
                let solved = pool.install(|| solve(&scene, 1e-8))?;
                let seconds = solved.seconds;
                let own = [seconds.assembly, seconds.setup, seconds.solve];
                for (best, own) in phases.iter_mut().zip(own) {
                    best[threads - 1] = best[threads - 1].min(own);
                }
                dofs = solved.dofs.total;
            }
        }
        let all = [0, 1].map(|threads| phases.iter().map(|phase| phase[threads]).sum::<f64>());
        let pairs = phases.iter().chain([&all]);
        let pairs = pairs.map(|[one, two]| format!("{one:.3}, {two:.3}").into());
        let ratio = fixed(all[0] / all[1], 2);
        table.push([count(dofs)].into_iter().chain(pairs).chain([ratio]));
    }
    Ok(table)
}

/// The solves for several right-hand sides on one mesh.
struct SeveralRhs {
    dofs: usize,
    /// Smallest and largest number of iterations.
    iterations: (usize, usize),
    /// Seconds of all solves, for each number in [`AT_ONCE`].
    seconds: [f64; AT_ONCE.len()],
}

fn several_rhs(quick: bool) -> Result<Table> {
    let mut table = Table::new([
        "dofs",
        "iterations",
        "at once",
        "seconds",
        "relative to one by one",
    ]);
    for &size in some(quick, &[1.75], &[1.0, 0.5]) {
        let found = of_several_rhs(size)?;
        let (least, most) = found.iterations;
        for (at_once, seconds) in AT_ONCE.into_iter().zip(found.seconds) {
            table.push([
                count(found.dofs),
                format!("{least} to {most}").into(),
                count(at_once),
                fixed(seconds, 2),
                fixed(seconds / found.seconds[0], 2),
            ]);
        }
    }
    Ok(table)
}

/// Solves for the 18 columns of the mobility matrix of three spheres.
fn of_several_rhs(size: f64) -> Result<SeveralRhs> {
    let ball = "domain = { kind = \"ball\", radius = 40 }\nmodel.kind = \"fem\"";
    let fem = format!("fem = {{ size_factor = {size:?}, symmetry = \"off\" }}");
    let scene = SceneText::new(ball).line(fem);
    let scene = scene
        .spheres_on_axis(&[1.0; 3], [-10.0, 0.0, 10.0])
        .parse()?;
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
    Ok(SeveralRhs {
        dofs: system.rows(),
        iterations: (*iterations.0, *iterations.1),
        seconds: best,
    })
}
