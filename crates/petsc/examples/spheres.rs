//! Three linked spheres in a ball, solved by all processes of a job:
//! `mpirun -n 2 target/release/examples/spheres size=0.3 -log_view`.
//!
//! With `estimates=yes` errors are estimated; with `compare=yes` the first process also solves the
//! problem with the shared-memory solver.

use std::time::Instant;

use mesh::{NamedSurface, TetMesh};
use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};
use nalgebra::Vector3;
use petsc::{Session, solve};
use rigid::{
    Arms, Articulation, BodyKind, Drive, Eliminated, ExternalLoad, Formulation, Joint, Lagrange,
};
use stokes::fem::SurplusSpace;
use stokes::{InitialGuesses, Options, Problem, Solver};

const NAMES: [&str; 3] = ["left", "centre", "right"];

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let session = match Session::start(&words) {
        Ok(session) => session,
        Err(error) => {
            eprintln!("error: {error}");
            std::process::exit(1);
        }
    };
    if let Err(error) = run(&session, &words) {
        eprintln!("error on process {}: {error}", session.rank());
        session.abort(3);
    }
}

fn run(session: &Session, words: &[String]) -> Result<(), Box<dyn std::error::Error>> {
    let value = |name: &str| {
        let of = |word: &String| Some(word.strip_prefix(name)?.strip_prefix('=')?.to_owned());
        words.iter().find_map(of)
    };
    let size = value("size").map_or(Ok(0.5), |size| size.parse())?;
    let rtol = value("rtol").map_or(Ok(1e-8), |rtol| rtol.parse())?;
    let formulation: &'static dyn Formulation = match value("formulation").as_deref() {
        Some("lagrange") => &Lagrange,
        _ => &Eliminated,
    };
    let solver = match value("method").as_deref() {
        Some("direct") => Solver::Direct,
        _ => Solver::Block,
    };
    let spheres = [-10.0, 0.0, 10.0].map(|x| Sphere {
        centre: Vector3::new(x, 0.0, 0.0),
        radius: 1.0,
    });
    let container = Container::Ball(Sphere {
        centre: Vector3::zeros(),
        radius: 40.0,
    });
    let bodies: Vec<MeshedBody<'_>> = (NAMES.iter().zip(&spheres))
        .map(|(name, surface)| MeshedBody {
            name,
            surface,
            size,
        })
        .collect();
    let tets = generate(&bodies, &container, &GenerateParams::default())?.mesh;
    let surfaces: Vec<NamedSurface> = (NAMES.iter().zip(&spheres))
        .map(|(name, sphere)| (*name, sphere as &dyn mesh::Surface))
        .chain([(Container::TAG, container.surface())])
        .collect();
    let mesh = TetMesh::curved(tets, &surfaces)?;
    let centres = spheres.map(|sphere| sphere.centre);
    let bodies: Vec<_> = NAMES.into_iter().zip(centres).collect();
    let problem = Problem::new(&mesh, &bodies, &[Container::TAG])?;
    let joint = |body: usize| Joint::slide(NAMES[body], body, 1);
    let joints = vec![joint(0), joint(2)];
    let set = Articulation::new(&[BodyKind::Rigid; 3], joints, Arms::Clamped, &centres)?;
    let drive = Drive {
        set: &set,
        // The left arm becomes shorter.
        constraints: &set.constraints(&set.initial_state(), set.initial_shape(), &[-1.0, 0.0])?,
        loads: &[ExternalLoad::default(); 3],
    };
    let options = Options::default()
        .with_formulation(formulation)
        .with_solver(solver)
        .with_rtol(rtol);
    let with_estimates = value("estimates").is_some();
    let before = peak_memory();
    let mut solved = solve(
        session,
        &problem,
        std::slice::from_ref(&drive),
        &options,
        with_estimates,
    )?;
    let distributed = solved.pop().ok_or("no solution")?;
    let [before, after] = [before, peak_memory()].map(|mb| sum(session, mb));
    let [before, after] = [before?, after?];
    if session.rank() == 0 {
        report("petsc", &distributed.solution);
        let dofs = distributed.solution.dofs.total;
        println!(
            "{} processes, {} levels, {} dofs on the first; peak of all processes {after} MB, \
             {:.2} kB per dof, of which {before} MB before the solution; the first {} MB",
            session.ranks(),
            distributed.levels,
            distributed.own_dofs,
            after as f64 * 1024.0 * 1.024 / dofs as f64,
            peak_memory()
        );
    }
    if session.rank() == 0 && value("compare").is_some() {
        let options = Options::default()
            .with_formulation(formulation)
            .with_rtol(rtol);
        let clock = Instant::now();
        let space = match value("estimates") {
            Some(_) => Some(SurplusSpace::new(&mesh)?),
            None => None,
        };
        let mut guesses = InitialGuesses::new(0);
        let shared = problem.solve_all(&[drive], &options, &mut guesses, space.as_ref())?;
        let shared = shared.into_iter().next().ok_or("no solution")?;
        report("shared", &shared);
        println!("{:.2} s in all", clock.elapsed().as_secs_f64());
        let flows = [&shared.flow, &distributed.solution.flow];
        let [a, b] = flows.map(|flow| &flow.bodies);
        println!("velocities differ by {:.1e}", (a - b).amax() / a.amax());
        let [a, b] = flows.map(|flow| &flow.forces);
        println!("forces differ by {:.1e}", (a - b).amax() / a.amax());
        let [a, b] = flows.map(|flow| &flow.velocity);
        let differences = a.iter().zip(b).map(|(a, b)| (a - b).amax());
        println!("fields differ by {:.1e}", differences.fold(0.0, f64::max));
        let [a, b] = flows.map(|flow| &flow.pressure);
        let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        println!(
            "pressures differ by {:.1e}",
            differences.fold(0.0, f64::max)
        );
    }
    Ok(())
}

fn report(name: &str, solution: &stokes::Solution) {
    let (solver, seconds) = (&solution.solver, &solution.seconds);
    println!(
        "{name}: {} dofs, {} iterations, residual {:.1e}, assembly {:.2} s, set-up {:.2} s, solve \
         {:.2} s",
        solution.dofs.total,
        solver.iterations,
        solver.true_relative_residual,
        seconds.assembly,
        seconds.setup,
        seconds.solve
    );
    println!("  velocity {:?}", solution.flow.bodies[0]);
    if let Some(estimate) = &solution.estimate {
        println!(
            "  correction {:?}, uncertainty {:.3e}, relative {:.4}, in {:.2} s",
            estimate.change.bodies[0],
            estimate.uncertainty,
            estimate.relative_uncertainty,
            seconds.estimate
        );
    }
}

/// Sum over all processes.
fn sum(session: &Session, number: usize) -> Result<usize, petsc::PetscError> {
    let mut sum = [number as f64];
    session.sum(&mut sum)?;
    Ok(sum[0] as usize)
}

/// Largest memory of this process so far, in MB.
fn peak_memory() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|line| line.split_whitespace().next()?.parse::<usize>().ok());
    kib.unwrap_or(0) / 1024
}
