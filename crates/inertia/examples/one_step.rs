//! One step in time of the flow around a sphere that another code can repeat:
//! `target/release/examples/one_step size=0.3 reynolds=10 out=/tmp/step`.
//!
//! A fixed sphere of radius 1 is in the middle of a ball of radius 10 whose wall moves. With
//! `reynolds=0` the step is one of unsteady Stokes flow from rest; otherwise one of Oseen flow from
//! the steady Navier-Stokes flow, which convects, and the wall becomes faster. Length: `step`.
//!
//! Prints the processor times of assembly, set-up and solve, medians of `repeats`. With `out=DIR`
//! mesh, data and exact solution are written as arrays of numbers in the order of the machine, for
//! `docs/figures/step_in_dolfinx.py`.

use std::error::Error;
use std::path::Path;

use inertia::{SteadyFlow, SteadyParameters};
use linalg::{KrylovParams, fgmres};
use mesh::TetMesh;
use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};
use nalgebra::Vector3;
use rigid::{Arms, Articulation, BodyKind, Drive, Eliminated, ExternalLoad, NodeRole};
use stokes::{InertialTerms, Problem};

/// Coefficient of the new velocity by BDF2 with equal steps.
const NEWEST: f64 = 1.5;

/// Speed of the wall in the step; before it is 1 in steady flow.
const FASTER: f64 = 1.2;

/// Residual of the solution that stands for the exact one.
const REFERENCE_RTOL: f64 = 1e-11;

/// Length of the Krylov basis, as in `stokes` for systems with convection.
const RESTART: usize = 200;

/// Solves one step, and checks that it is solved.
pub fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let text = |name: &str| {
        let value = |word: &String| Some(word.strip_prefix(name)?.strip_prefix('=')?.to_owned());
        words.iter().find_map(value)
    };
    let number = |name: &str, default: f64| text(name).map_or(Ok(default), |text| text.parse());
    let (size, reynolds) = (number("size", 0.8)?, number("reynolds", 0.0)?);
    let (length, repeats) = (number("step", 0.1)?, number("repeats", 1.0)? as usize);

    let [sphere, ball] = [1.0, 10.0].map(|radius| Sphere {
        centre: Vector3::zeros(),
        radius,
    });
    let body = MeshedBody {
        name: "sphere",
        surface: &sphere,
        size,
    };
    let tets = generate(&[body], &Container::Ball(ball), &GenerateParams::default())?.mesh;
    let mesh = TetMesh::curved(tets, &[("sphere", &sphere), (Container::TAG, &ball)])?;
    let set = Articulation::new(
        &[BodyKind::Rigid],
        vec![],
        Arms::Clamped,
        &[Vector3::zeros()],
    )?
    .with_held(&[0], &[0])?;
    let constraints = set.constraints(&set.initial_state(), &[], &[])?;
    let drive = Drive {
        set: &set,
        constraints: &constraints,
        loads: &[ExternalLoad::default()],
    };
    let bodies = [("sphere", Vector3::zeros())];
    let problem = Problem::new(&mesh, &bodies, &[Container::TAG])?;
    let wall = |speed: f64| vec![-speed * Vector3::z(); mesh.n_points()];

    let with_convection = reynolds > 0.0;
    let (density, speed) = match with_convection {
        true => (reynolds, FASTER),
        false => (1.0, 1.0),
    };
    let before = match with_convection {
        true => {
            let flow = SteadyFlow {
                mesh: &mesh,
                bodies: &bodies,
                walls: &[Container::TAG],
                slip: None,
                wall_velocity: Some(&wall(1.0)),
                moves_with_body: false,
            };
            let parameters = SteadyParameters::default().with_tolerance(1e-3);
            flow.solve(&drive, density, &parameters)?
                .solved
                .flow
                .velocity
        }
        false => wall(0.0),
    };
    let coefficient = density * NEWEST / length;
    let momentum: Vec<Vector3<f64>> = before.iter().map(|u| coefficient * u).collect();
    let wall = wall(speed);
    let terms = InertialTerms {
        density,
        coefficient,
        force: Some(&momentum),
        convecting: with_convection.then_some(&before),
        wall_velocity: Some(&wall),
        ..InertialTerms::default()
    };

    let mut times = [const { Vec::new() }; 3];
    let mut last = None;
    for _ in 0..repeats.max(1) {
        let clock = processor_seconds();
        let assembled = problem.assemble_inertial(&drive, &Eliminated, &terms)?;
        let system = &assembled.system;
        let parts = [clock, processor_seconds()];
        let mut preconditioner = system.preconditioner()?;
        let set_up = processor_seconds();
        let mut solution = vec![0.0; system.rhs.len()];
        let parameters = KrylovParams::default().with_restart(RESTART);
        let (operator, rhs) = (&system.system, &system.rhs);
        let report = fgmres(
            operator,
            &mut preconditioner,
            rhs,
            &mut solution,
            &parameters,
        )?;
        let ends = [parts[0], parts[1], set_up, processor_seconds()];
        for (times, ends) in times.iter_mut().zip(ends.windows(2)) {
            times.push(ends[1] - ends[0]);
        }
        last = Some((assembled, preconditioner, solution, report));
    }
    let (assembled, mut preconditioner, solution, report) = last.ok_or("no step")?;
    let system = &assembled.system;
    let mut exact = solution.clone();
    let parameters = KrylovParams::default()
        .with_restart(RESTART)
        .with_rel_tol(REFERENCE_RTOL);
    fgmres(
        &system.system,
        &mut preconditioner,
        &system.rhs,
        &mut exact,
        &parameters,
    )?;
    let flow_of = |solution: &[f64]| system.flow_with_forces(solution, &assembled.forces, &set);
    let (flow, exact) = (flow_of(&solution)?, flow_of(&exact)?);
    let pairs = exact.velocity.iter().zip(&flow.velocity);
    let error: f64 = pairs.map(|(a, b)| (a - b).norm_squared()).sum();
    let size: f64 = exact.velocity.iter().map(|u| u.norm_squared()).sum();
    let (dofs, error) = (solution.len(), (error / size).sqrt());
    let [assembly, set_up, solve] = times.map(median);
    let force = flow.forces[2];
    println!(
        "{{\"dofs\": {dofs}, \"density\": {density}, \"coefficient\": {coefficient}, \"iterations\": \
         {}, \"residual\": {:.2e}, \"error\": {error:.2e}, \"assembly\": {assembly:.3}, \"setup\": {set_up:.3}, \"solve\": \
         {solve:.3}, \"force\": {force}}}",
        report.iterations, report.true_rel_residual
    );
    if let Some(out) = text("out") {
        let out = Path::new(&out);
        std::fs::create_dir_all(out)?;
        let vectors = |field: &[Vector3<f64>]| -> Vec<u8> {
            let numbers = field.iter().flat_map(|v| [v.x, v.y, v.z]);
            numbers.flat_map(f64::to_ne_bytes).collect()
        };
        let prescribed = |(role, wall): (NodeRole, &Vector3<f64>)| match role {
            NodeRole::Free => Vector3::repeat(f64::NAN),
            NodeRole::Fixed => *wall,
            NodeRole::Body(_) => Vector3::zeros(),
        };
        let roles = problem.roles().into_iter();
        let prescribed: Vec<_> = roles.zip(&wall).map(prescribed).collect();
        for (name, field) in [
            ("points", mesh.points()),
            ("prescribed", &prescribed),
            ("before", &before),
            ("velocity", &exact.velocity),
        ] {
            std::fs::write(out.join(name), vectors(field))?;
        }
        let cells = mesh.cells().as_flattened();
        let cells: Vec<u8> = cells.iter().flat_map(|node| node.to_ne_bytes()).collect();
        std::fs::write(out.join("cells"), cells)?;
    }
    // the wall drags the sphere along
    assert!(force > 0.0 && report.true_rel_residual <= 1e-8);
    Ok(())
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Processor time of all threads so far, in seconds, on Linux; zero elsewhere.
fn processor_seconds() -> f64 {
    // clock ticks of all Linux systems for programs
    const TICKS_PER_SECOND: f64 = 100.0;
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // the name of the program, in brackets, may have blanks
    let after_name = text.rsplit(')').next().unwrap_or_default();
    // fields 14 and 15, of which the first two are before the name's end
    let ticks = after_name.split_whitespace().skip(11).take(2);
    let ticks = ticks.filter_map(|ticks| ticks.parse::<f64>().ok());
    ticks.sum::<f64>() / TICKS_PER_SECOND
}
