//! Solutions of a Stokes problem that is divided between processes.

use std::time::Instant;

use rigid::{Drive, FlowSolution, Imposed, MeshPart, NodeRole};
use stokes::fem::{SurplusPart, SurplusSpace};
use stokes::{
    Checks, Dofs, Engine, Estimate, Gather, Options, PartEquations, Problem, Seconds, Solution,
    SolverReport, StokesError,
};

use crate::PetscError;
use crate::assembly::Part;
use crate::divided::{DividedMatrix, DividedPreconditioner};
use crate::gather::{Fields, engine_error};
use crate::handles::{Session, release_memory};
use crate::numbering::{Numbering, components};
use crate::partition::Partition;
use crate::pressure::pressure_laplacian;
use crate::shared::{self, LateExchange, Shared};
use crate::solver::{Method, Solver};

/// A solution, the same on every process.
#[non_exhaustive]
pub struct DistributedSolution {
    /// Velocities and pressure at all nodes, forces and solver figures, as from one machine.
    pub solution: Solution,
    /// Number of multigrid levels; zero for the direct solver.
    pub levels: usize,
    /// Degrees of freedom that this process owns.
    pub own_dofs: usize,
}

/// Solves a problem for drives that differ only in the rates of the joints.
///
/// Collective: every process calls it with the same problem. All drives share one matrix and one
/// preconditioner, whose time is counted for the first solution. Of the solvers there are
/// [`stokes::Solver::Block`] and, by MUMPS, [`stokes::Solver::Direct`]; `options.rtol` bounds the
/// relative Euclidean residual and the estimated error of [`linalg::SolveReport`].
///
/// # Errors
/// [`PetscError`]. If only some processes fail, the caller must end all of them
/// ([`Session::abort`]).
pub fn solve(
    session: &Session,
    problem: &Problem,
    drives: &[Drive],
    options: &Options,
    with_estimates: bool,
) -> Result<Vec<DistributedSolution>, PetscError> {
    let Some((drive, others)) = drives.split_first() else {
        return Ok(Vec::new());
    };
    let method = Method::new(options.solver)?;
    let clock = Instant::now();
    let mesh = problem.mesh();
    let roles = problem.roles();
    let free_nodes = roles.iter().filter(|role| **role == NodeRole::Free).count();
    let components = components(&roles, &mesh.nodes_on_symmetry_planes());
    let counts: Vec<u8> = components.iter().map(|c| c.count_ones() as u8).collect();
    let partition = Partition::new(mesh, &counts, session.ranks())?;
    let submesh = mesh.submesh(|cell| partition.assembles(session.rank(), &mesh.cells()[cell]))?;
    let owned: Vec<bool> = (submesh.nodes.iter())
        .map(|&node| partition.owner(node) == session.rank())
        .collect();
    let exchange = LateExchange::default();
    let part = MeshPart::new(owned.clone(), session.sum_over_parts())
        .with_ghosts(session.rank() == 0, exchange.function());
    let system = problem.assemble_part(&submesh, part, drive, options.formulation)?;
    if !linalg::LinearOperator::is_symmetric(&system.system) {
        return Err(PetscError::NotSymmetric {
            formulation: options.formulation.name(),
        });
    }
    release_memory();
    let others: Vec<Imposed> = (others.iter())
        .map(|drive| system.imposed(drive))
        .collect::<Result<_, _>>()?;
    let space = match with_estimates {
        true => Some(SurplusSpace::new(&submesh.mesh).map_err(StokesError::from)?),
        false => None,
    };
    let shared = Shared::new(&partition, &submesh, space.as_ref(), session.rank());
    exchange.set(shared.of_system(session, &submesh, &system)?);
    let border = system.system.border_range().len();
    let processes = [session.rank(), session.ranks()];
    let numbering = Numbering::new(mesh, components, &partition, border, processes)?;
    let part = Part {
        system: &system,
        submesh: &submesh,
        numbering: &numbering,
        owned: &owned,
    };
    let entries = part.own_entries();
    let mut blocks = part.blocks(session)?;
    if method == Method::Block {
        blocks.pressure_laplacian = pressure_laplacian(session, problem, &part, &partition)?;
    }
    // PETSc has copies.
    let system = system.without_matrices()?;
    release_memory();
    let assembly = clock.elapsed().as_secs_f64();
    let clock = Instant::now();
    let order = partition.nodes_by_vertex();
    let is_own = |node: &&u32| partition.owner(**node) == session.rank();
    let free_vertices: Vec<u32> = (order.iter().filter(is_own).copied())
        .filter(|&node| (node as usize) < mesh.n_vertices() && numbering.components(node) != 0)
        .collect();
    drop(order);
    let sizes = blocks.sizes.concat();
    let solver = Solver::new(session, blocks, method, &numbering, &free_vertices)?;
    let setup = clock.elapsed().as_secs_f64();

    let fields = Fields::new(mesh, &partition, &submesh, session.rank());
    let (mut flows, mut solved_drives) = (Vec::new(), Vec::new());
    let imposed = std::iter::once(None).chain(others.iter().map(Some));
    for imposed in imposed {
        let clock = Instant::now();
        let rhs = imposed.map_or(&system.rhs, |imposed| &imposed.rhs);
        let solved = solver.solve(&entries.of(rhs), options.rtol)?;
        let mut solution = vec![0.0; entries.len()];
        entries.write(&solved.solution, &mut solution);
        let flow = match imposed {
            None => system.flow(&solution, drive.set)?,
            Some(imposed) => system.flow_at(&solution, imposed, drive.set)?,
        };
        flows.push(of_all_nodes(problem, &fields, flow)?);
        solved_drives.push((solved, clock.elapsed().as_secs_f64()));
    }
    let clock = Instant::now();
    let mut estimates: Vec<Option<(Estimate, Checks)>> = flows.iter().map(|_| None).collect();
    if let Some(space) = space {
        solver.free_basis()?;
        let exchange = LateExchange::default();
        exchange.set(shared.of_extension(session, &submesh, &space)?);
        let surplus_part = surplus_part(session, &partition, &submesh, &space, &exchange);
        let space = space.with_part(surplus_part).map_err(StokesError::from)?;
        let equations = PartEquations {
            submesh: &submesh,
            space: &space,
            system: &system,
            operator: &DividedMatrix::new(session, &solver, &entries, &sizes)?,
            gather: &fields,
        };
        let mut preconditioner = DividedPreconditioner {
            solver: &solver,
            entries: &entries,
        };
        let rtol = options.estimate_rtol;
        let estimated =
            problem.estimate_part(drive, &flows, equations, &mut preconditioner, rtol)?;
        estimates = estimated.into_iter().map(Some).collect();
    }
    let estimate = clock.elapsed().as_secs_f64() / drives.len() as f64;

    let own_dofs = sizes.len();
    let shared_seconds = std::iter::once([assembly, setup]).chain(std::iter::repeat([0.0; 2]));
    let all = flows
        .into_iter()
        .zip(solved_drives)
        .zip(estimates)
        .zip(shared_seconds);
    all.map(
        |(((flow, (solved, solve)), estimate_of_flow), [assembly, setup])| {
            let (estimate_of_flow, checks) = estimate_of_flow.unzip();
            Ok(DistributedSolution {
                levels: solved.levels,
                own_dofs,
                solution: Solution {
                    slip_power: problem.power_of_slip(&flow)?,
                    estimate: estimate_of_flow,
                    checks,
                    dofs: Dofs {
                        velocity: 3 * free_nodes,
                        pressure: mesh.n_vertices(),
                        total: 3 * free_nodes + border + mesh.n_vertices(),
                    },
                    solver: SolverReport {
                        formulation: options.formulation.name().to_owned(),
                        solver: format!("petsc {}", options.solver.name()),
                        iterations: solved.iterations,
                        true_relative_residual: solved.true_relative_residual,
                    },
                    algebraic_error: solved.error_estimate,
                    seconds: Seconds {
                        assembly,
                        setup,
                        solve,
                        estimate,
                        total: assembly + setup + solve + estimate,
                        ..Seconds::default()
                    },
                    flow,
                },
            })
        },
    )
    .collect()
}

/// Solves on all processes of the [`Session`] that the calling thread has started.
///
/// Every process makes the same calls with the same problems; answers are the same on all, so that
/// programs take the same decisions everywhere.
#[derive(Clone, Copy, Debug, Default)]
pub struct PetscEngine;

impl Engine for PetscEngine {
    fn solve_all(
        &self,
        problem: &Problem,
        drives: &[Drive],
        options: &Options,
        surplus: Option<&SurplusSpace>,
    ) -> Result<Vec<Solution>, StokesError> {
        let of_session = |session: &Session| {
            // Each process has the surplus space of its own part of the mesh.
            let solved = solve(session, problem, drives, options, surplus.is_some())?;
            Ok(solved.into_iter().map(|solved| solved.solution).collect())
        };
        Session::with_current(of_session).map_err(engine_error)
    }
}

/// The cells and bubbles of this process.
fn surplus_part(
    session: &Session,
    partition: &Partition,
    submesh: &mesh::Submesh,
    space: &SurplusSpace,
    exchange: &LateExchange,
) -> SurplusPart {
    let is_own =
        |vertices: &[u32]| shared::owner_of(partition, submesh, vertices) == session.rank();
    let cells = submesh.mesh.cells();
    let vertices = submesh.mesh.n_vertices();
    let edges = submesh.nodes[vertices..].iter();
    let mut bubbles: Vec<bool> = edges
        .map(|&node| partition.owner(node) == session.rank())
        .collect();
    bubbles.resize(space.n_bubbles(), false);
    for (number, cell) in cells.iter().enumerate() {
        for (face, bubble) in shared::faces(cell).iter().zip(space.face_bubbles(number)) {
            bubbles[bubble as usize] = is_own(face);
        }
    }
    SurplusPart::new(
        cells.iter().map(|cell| is_own(&cell[..4])).collect(),
        bubbles,
        session.sum_over_parts(),
        exchange.function(),
    )
}

/// The flow with velocities and pressures of all nodes, from those of each process.
fn of_all_nodes(
    problem: &Problem,
    fields: &Fields,
    mut flow: FlowSolution,
) -> Result<FlowSolution, PetscError> {
    flow.velocity = fields.nodes(&flow.velocity)?;
    flow.pressure = fields.vertices(&flow.pressure)?;
    let mean =
        stokes::fem::mean_pressure(problem.mesh(), &flow.pressure).map_err(StokesError::from)?;
    flow.pressure.iter_mut().for_each(|p| *p -= mean);
    Ok(flow)
}
