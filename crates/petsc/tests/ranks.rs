//! The same problems on 1, 2 and 4 processes and by the shared-memory solver.
//!
//! The test starts itself under `mpirun`; the first process prints the numbers that are compared.

use std::process::{Command, ExitCode};

use mesh::{NamedSurface, TetMesh};
use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};
use nalgebra::Vector3;
use petsc::{PetscError, Session, solve};
use rigid::{
    Arms, Articulation, BodyKind, DirectRows, Drive, Eliminated, ExternalLoad, FlowSolution,
    Formulation, Joint, Lagrange,
};
use stokes::fem::SurplusSpace;
use stokes::{InitialGuesses, Options, Problem, Solution, Solver, SurfaceFlow};

const NAMES: [&str; 2] = ["left", "right"];

/// Tolerance of all solves. Answers differ by at most the error estimate, which is below it, times
/// the condition of the comparison: 1e-9 over ranks leaves a factor of a hundred.
const RTOL: f64 = 1e-11;
const OVER_RANKS: f64 = 1e-9;

/// Tolerance of the systems of estimates, and the agreement of estimates relative to their own
/// size, with the factor of above. Corrected flows agree as flows do, because changes are small.
const ESTIMATE_RTOL: f64 = 1e-9;
const OF_ESTIMATES: f64 = 1e-7;
const TO_SHARED: f64 = 1e-8;

/// Set for the processes that `mpirun` starts.
const UNDER_MPI: &str = "MICROSWIM_TEST_UNDER_MPI";

/// A problem on the mesh of two spheres in a ball.
struct Case {
    name: &'static str,
    formulation: &'static dyn Formulation,
    solver: Solver,
    /// Whether the left sphere is a wall and fluid leaves through the ball.
    is_open: bool,
    /// Whether the surfaces of the bodies have slip.
    has_slip: bool,
    has_estimates: bool,
}

impl Case {
    fn options(&self) -> Options {
        Options::default()
            .with_formulation(self.formulation)
            .with_solver(self.solver)
            .with_rtol(RTOL)
            .with_estimate_rtol(ESTIMATE_RTOL)
    }
}

/// Slip of a squirmer with swirl, and no background flow.
struct Squirmer;

impl SurfaceFlow for Squirmer {
    fn slip(&self, body: usize, x: &Vector3<f64>) -> Vector3<f64> {
        let normal = (x - spheres()[body].centre).normalize();
        let axis = Vector3::new(0.6, 0.0, 0.8);
        let along = axis.dot(&normal);
        (1.0 + along) * (along * normal - axis) + 0.3 * along * axis.cross(&normal)
    }

    fn background(&self, _: &Vector3<f64>) -> Vector3<f64> {
        Vector3::zeros()
    }

    fn background_pressure(&self, _: &Vector3<f64>) -> f64 {
        0.0
    }
}

const CASES: [Case; 4] = [
    Case {
        name: "p-tilde with slip in a closed domain",
        formulation: &Eliminated,
        solver: Solver::Block,
        is_open: false,
        has_slip: true,
        has_estimates: true,
    },
    Case {
        name: "multipliers in a closed domain",
        formulation: &Lagrange,
        solver: Solver::Block,
        is_open: false,
        has_slip: false,
        has_estimates: false,
    },
    Case {
        name: "p-tilde in an open domain",
        formulation: &Eliminated,
        solver: Solver::Block,
        is_open: true,
        has_slip: false,
        has_estimates: true,
    },
    Case {
        name: "direct solver in a closed domain",
        formulation: &Lagrange,
        solver: Solver::Direct,
        is_open: false,
        has_slip: false,
        has_estimates: true,
    },
];

type Groups = Vec<Vec<f64>>;
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

/// Velocities, forces, joint loads, stresslets and some values of the fields.
fn of_flow(flow: &FlowSolution) -> Vec<f64> {
    let some = flow.velocity.iter().step_by(97);
    (flow.bodies.iter())
        .chain(flow.forces.iter())
        .chain(flow.joint_loads.iter())
        .chain(flow.stresslets.iter().flatten())
        .copied()
        .chain(some.flat_map(|u| [u.x, u.y, u.z]))
        .chain(flow.pressure.iter().step_by(31).copied())
        .collect()
}

/// Numbers that are compared relative to the largest of their group: those of the flow, then those
/// of its estimated error.
fn numbers(
    mesh: &TetMesh,
    case: &Case,
    solve: impl FnOnce(&Problem, &Drive) -> Result<Solution, Failure>,
) -> Result<Groups, Failure> {
    let centres = spheres().map(|sphere| sphere.centre);
    let all: Vec<_> = NAMES.into_iter().zip(centres).collect();
    let (bodies, walls, joints) = if case.is_open {
        (&all[1..], [NAMES[0]], vec![])
    } else {
        (&all[..], [Container::TAG], vec![Joint::slide("arm", 0, 1)])
    };
    let centres: Vec<_> = bodies.iter().map(|(_, centre)| *centre).collect();
    let kinds = vec![BodyKind::Rigid; bodies.len()];
    let rates = vec![-1.0; joints.len()];
    let set = Articulation::new(&kinds, joints, Arms::Clamped, &centres)?;
    let mut loads = vec![ExternalLoad::default(); bodies.len()];
    loads[0].force = Vector3::new(0.0, 1.0, 0.5);
    let drive = Drive {
        set: &set,
        constraints: &set.constraints(&set.initial_state(), set.initial_shape(), &rates)?,
        loads: &loads,
    };
    let spheres = spheres();
    let surfaces: Vec<NamedSurface> = (NAMES.iter().zip(&spheres))
        .map(|(name, sphere)| (*name, sphere as &dyn mesh::Surface))
        .collect();
    let mut problem = Problem::new(mesh, bodies, &walls)?.with_surfaces(&surfaces)?;
    if case.has_slip {
        problem = problem.with_surface_flow(&Squirmer);
    }
    let solution = solve(&problem, &drive)?;
    let mut numbers = vec![of_flow(&solution.flow)];
    if case.has_slip {
        numbers.push(vec![solution.powers.slip]);
    }
    if let Some(estimate) = solution.estimate {
        let mut corrected = solution.flow.clone();
        corrected.add(&estimate.change)?;
        numbers[0].extend(of_flow(&corrected));
        numbers.extend([
            of_flow(&estimate.change),
            vec![estimate.uncertainty],
            vec![estimate.relative_uncertainty],
            vec![estimate.powers.slip],
        ]);
        let checks = solution.checks.ok_or("no checks")?;
        numbers.extend([vec![checks.force_by_stress], vec![checks.dissipation]]);
        let indicators = estimate.indicators();
        numbers.extend(indicators.map(|of_cells| of_cells.into_iter().step_by(53).collect()));
    }
    assert_eq!(numbers.len() > 2, case.has_estimates);
    Ok(numbers)
}

/// The first solution.
fn first(mut solved: Vec<petsc::DistributedSolution>) -> Result<Solution, Failure> {
    let only = solved.pop().ok_or("no solution")?;
    Ok(only.solution)
}

/// All cases on the processes of this job; the first one prints the numbers.
fn under_mpi() -> Result<(), Failure> {
    let session = Session::start(&[])?;
    let all = || -> Result<(), Failure> {
        let mesh = two_spheres()?;
        for case in &CASES {
            let numbers = numbers(&mesh, case, |problem, drive| {
                let drives = std::slice::from_ref(drive);
                let options = case.options();
                first(solve(
                    &session,
                    problem,
                    drives,
                    &options,
                    case.has_estimates,
                )?)
            })?;
            if session.rank() == 0 {
                let words = |group: &Vec<f64>| {
                    let words: Vec<String> = group.iter().map(|x| format!("{x:e}")).collect();
                    words.join(" ")
                };
                let groups: Vec<String> = numbers.iter().map(words).collect();
                println!("{}", groups.join(";"));
            }
        }
        let direct_rows = numbers(&mesh, &CASES[0], |problem, drive| {
            let options = Options::default().with_formulation(&DirectRows);
            let drives = std::slice::from_ref(drive);
            first(solve(&session, problem, drives, &options, false)?)
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
fn on_ranks(ranks: usize) -> Result<Vec<Groups>, Failure> {
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
    let group = |group: &str| group.split(' ').map(str::parse).collect::<Result<_, _>>();
    let line = |line: &str| line.split(';').map(group).collect::<Result<_, _>>();
    let all: Vec<Groups> = text.lines().map(line).collect::<Result<_, _>>()?;
    assert_eq!(all.len(), CASES.len());
    Ok(all)
}

/// Refuses groups of which the first differs by more than `tolerance`, or another by more than
/// [`OF_ESTIMATES`].
fn check(case: &Case, from: &str, a: &Groups, b: &Groups, tolerance: f64) {
    assert_eq!(a.len(), b.len());
    let differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| difference(a, b)).collect();
    let words: Vec<String> = differences.iter().map(|d| format!("{d:.0e}")).collect();
    println!("{}: {} from {from}", case.name, words.join(" "));
    for (k, difference) in differences.into_iter().enumerate() {
        let allowed = if k == 0 { tolerance } else { OF_ESTIMATES };
        assert!(
            difference < allowed,
            "{}, group {k}: {difference:e}",
            case.name
        );
    }
}

/// Largest difference relative to the largest number of `a`.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let size = a.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
    // Without a slip its power is zero.
    let size = if size == 0.0 { 1.0 } else { size };
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
            let options = case.options().with_solver(Solver::Block);
            let (mut guesses, space) = (InitialGuesses::new(0), SurplusSpace::new(&mesh)?);
            let space = case.has_estimates.then_some(&space);
            let drives = std::slice::from_ref(drive);
            let solved = problem.solve_all(drives, &options, &mut guesses, space)?;
            Ok(solved.into_iter().next().ok_or("no solution")?)
        })?;
        let from = "the shared-memory solver";
        check(case, from, &shared, numbers_on_one, TO_SHARED);
    }
    for ranks in [2, 4] {
        let on_more = on_ranks(ranks)?;
        for ((case, one), more) in CASES.iter().zip(&on_one).zip(&on_more) {
            check(case, &format!("{ranks} processes"), one, more, OVER_RANKS);
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
