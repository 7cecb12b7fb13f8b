//! The same problems on 1, 2 and 4 processes and by the shared-memory solver.
//!
//! The test starts itself under `mpirun`; the first process prints the numbers that are compared.

use std::process::{Command, ExitCode};

use mesh::{Container, GenerateParams, MeshedBody, NamedSurface, Sphere, TetMesh, generate};
use nalgebra::Vector3;
use petsc::{Method, PetscError, Session, solve};
use rigid::{
    Arms, Articulation, BodyKind, DirectRows, Drive, Eliminated, ExternalLoad, Formulation,
    Lagrange, Link,
};
use stokes::{Options, Problem, Solution};

const NAMES: [&str; 2] = ["left", "right"];

/// Tolerance of all solves. Answers differ by at most the error estimate, which is below it, times
/// the condition of the comparison: 1e-9 over ranks leaves a factor of a hundred.
const RTOL: f64 = 1e-11;
const OVER_RANKS: f64 = 1e-9;
const TO_SHARED: f64 = 1e-8;

/// Set for the processes that `mpirun` starts.
const UNDER_MPI: &str = "MICROSWIM_TEST_UNDER_MPI";

/// A problem on the mesh of two spheres in a ball.
struct Case {
    name: &'static str,
    formulation: &'static dyn Formulation,
    method: Method,
    /// Whether the left sphere is a wall and fluid leaves through the ball.
    is_open: bool,
}

const CASES: [Case; 4] = [
    Case {
        name: "p-tilde in a closed domain",
        formulation: &Eliminated,
        method: Method::Block,
        is_open: false,
    },
    Case {
        name: "multipliers in a closed domain",
        formulation: &Lagrange,
        method: Method::Block,
        is_open: false,
    },
    Case {
        name: "p-tilde in an open domain",
        formulation: &Eliminated,
        method: Method::Block,
        is_open: true,
    },
    Case {
        name: "direct solver in a closed domain",
        formulation: &Lagrange,
        method: Method::Direct,
        is_open: false,
    },
];

type Failure = Box<dyn std::error::Error>;

fn spheres() -> [Sphere; 2] {
    [-2.0, 2.0].map(|x| Sphere {
        centre: Vector3::new(x, 0.3 * x, 0.0),
        radius: 1.0,
    })
}

/// About twenty thousand degrees of freedom: three levels of multigrid.
fn two_spheres() -> Result<TetMesh, Failure> {
    let (spheres, container) = (
        spheres(),
        Container::Ball(Sphere {
            centre: Vector3::zeros(),
            radius: 10.0,
        }),
    );
    let bodies: Vec<MeshedBody<'_>> = (NAMES.iter().zip(&spheres))
        .map(|(name, surface)| MeshedBody {
            name,
            surface,
            size: 0.7,
        })
        .collect();
    let tets = generate(&bodies, &container, &GenerateParams::default())?.mesh;
    let surfaces: Vec<NamedSurface> = (NAMES.iter().zip(&spheres))
        .map(|(name, sphere)| (*name, sphere as &dyn mesh::Surface))
        .chain([(Container::TAG, container.surface())])
        .collect();
    Ok(TetMesh::curved(tets, &surfaces)?)
}

/// Velocities, forces, link loads and some values of the fields of a case.
fn numbers(
    mesh: &TetMesh,
    case: &Case,
    solve: impl FnOnce(&Problem, &Drive) -> Result<Solution, Failure>,
) -> Result<Vec<f64>, Failure> {
    let centres = spheres().map(|sphere| sphere.centre);
    let all: Vec<_> = NAMES.into_iter().zip(centres).collect();
    let (bodies, walls, links) = if case.is_open {
        (&all[1..], [NAMES[0]], vec![])
    } else {
        (&all[..], [Container::TAG], vec![Link::slide("arm", 0, 1)])
    };
    let centres: Vec<_> = bodies.iter().map(|(_, centre)| *centre).collect();
    let kinds = vec![BodyKind::Rigid; bodies.len()];
    let rates = vec![-1.0; links.len()];
    let set = Articulation::new(&kinds, links, Arms::Clamped, &centres)?;
    let mut loads = vec![ExternalLoad::default(); bodies.len()];
    loads[0].force = Vector3::new(0.0, 1.0, 0.5);
    let drive = Drive {
        set: &set,
        constraints: &set.constraints(&set.initial_state(), set.initial_lengths(), &rates)?,
        loads: &loads,
    };
    let solution = solve(&Problem::new(mesh, bodies, &walls)?, &drive)?;
    let flow = &solution.flow;
    let mut numbers: Vec<f64> = (flow.bodies.iter())
        .chain(flow.forces.iter())
        .chain(flow.link_loads.iter())
        .copied()
        .collect();
    numbers.extend(
        flow.velocity
            .iter()
            .step_by(97)
            .flat_map(|u| [u.x, u.y, u.z]),
    );
    numbers.extend(flow.pressure.iter().step_by(31));
    Ok(numbers)
}

/// All cases on the processes of this job; the first one prints the numbers.
fn under_mpi() -> Result<(), Failure> {
    let session = Session::start(&[])?;
    let all = || -> Result<(), Failure> {
        let mesh = two_spheres()?;
        for case in &CASES {
            let numbers = numbers(&mesh, case, |problem, drive| {
                let (formulation, method) = (case.formulation, case.method);
                Ok(solve(&session, problem, drive, formulation, method, RTOL)?.solution)
            })?;
            if session.rank() == 0 {
                let words: Vec<String> = numbers.iter().map(|x| format!("{x:e}")).collect();
                println!("{}", words.join(" "));
            }
        }
        let direct_rows = numbers(&mesh, &CASES[0], |problem, drive| {
            Ok(solve(&session, problem, drive, &DirectRows, Method::Block, RTOL)?.solution)
        });
        match direct_rows.map_err(|error| error.downcast::<PetscError>()) {
            Err(Ok(error)) if matches!(*error, PetscError::NotSymmetric { .. }) => Ok(()),
            _ => Err("direct rows are not symmetric and must be refused".into()),
        }
    };
    all().map_err(|error| {
        eprintln!("process {}: {error}", session.rank());
        session.abort(1)
    })
}

/// Numbers of all cases on `ranks` processes.
fn on_ranks(ranks: usize) -> Result<Vec<Vec<f64>>, Failure> {
    let output = Command::new("mpirun")
        .args(["--oversubscribe", "--allow-run-as-root", "-n"])
        .arg(ranks.to_string())
        .arg(std::env::current_exe()?)
        .env(UNDER_MPI, "1")
        .env("RAYON_NUM_THREADS", "1")
        .output()
        .map_err(|error| format!("mpirun: {error}; install openmpi-bin"))?;
    if !output.status.success() {
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        return Err(format!("{ranks} processes: {message}").into());
    }
    let text = String::from_utf8(output.stdout)?;
    let line = |line: &str| line.split(' ').map(str::parse).collect::<Result<_, _>>();
    Ok(text.lines().map(line).collect::<Result<_, _>>()?)
}

/// Largest difference relative to the largest number of `a`.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let size = a.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
    let pairs = a.iter().zip(b);
    // NaN is no number that `max` would return.
    pairs.fold(0.0, |largest, (x, y)| {
        let difference = (x - y).abs() / size;
        if difference <= largest {
            largest
        } else {
            difference
        }
    })
}

fn compare() -> Result<(), Failure> {
    let mesh = two_spheres()?;
    let on_one = on_ranks(1)?;
    for (case, numbers_on_one) in CASES.iter().zip(&on_one) {
        let shared = numbers(&mesh, case, |problem, drive| {
            let options = Options::default()
                .with_formulation(case.formulation)
                .with_rtol(RTOL);
            Ok(problem.solve(drive, &options)?)
        })?;
        let difference = difference(&shared, numbers_on_one);
        println!(
            "{}: {difference:.1e} from the shared-memory solver",
            case.name
        );
        assert!(difference < TO_SHARED, "{}: {difference:e}", case.name);
    }
    for ranks in [2, 4] {
        let on_more = on_ranks(ranks)?;
        assert_eq!(on_more.len(), CASES.len());
        for ((case, one), more) in CASES.iter().zip(&on_one).zip(&on_more) {
            let difference = difference(one, more);
            println!("{}: {difference:.1e} from {ranks} processes", case.name);
            assert!(difference < OVER_RANKS, "{}: {difference:e}", case.name);
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    let is_under_mpi = std::env::var_os(UNDER_MPI).is_some();
    match if is_under_mpi { under_mpi() } else { compare() } {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
