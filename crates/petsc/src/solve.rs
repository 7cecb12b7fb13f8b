//! Solutions of a Stokes problem that is divided between processes.

use std::iter::once;
use std::time::Instant;

use rigid::{Constrained, Drive, FlowSolution, Imposed, MeshPart, NodeRole};
use stokes::fem::{SurplusPart, SurplusSpace, mean_pressure};
use stokes::{
    Checks, Dofs, Engine, Estimate, Gather, Options, PartEquations, Problem, Seconds, Solution,
    SolvedBatch, SolverReport, StokesError,
};

use crate::PetscError;
use crate::assembly::{OwnEntries, Part};
use crate::divided::{DividedMatrix, DividedPreconditioner};
use crate::gather::{Fields, engine_error};
use crate::handles::{Session, release_memory};
use crate::numbering::{Numbering, components};
use crate::partition::Partition;
use crate::pressure::pressure_laplacian;
use crate::shared::{self, LateExchange, Shared};
use crate::solver::{Method, Solved, Solver};

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
    let free_vertices = own_free_vertices(session, problem, &partition, &numbering);
    let sizes = blocks.sizes.concat();
    let solver = Solver::new(session, blocks, method, &numbering, &free_vertices)?;
    let setup = clock.elapsed().as_secs_f64();

    let divided = Divided {
        session,
        problem,
        partition: &partition,
        submesh: &submesh,
        shared: &shared,
        system: &system,
        solver: &solver,
        entries: &entries,
        sizes: &sizes,
        fields: &Fields::new(mesh, &partition, &submesh, session.rank()),
    };
    let clock = Instant::now();
    let (mut flows, mut reports, mut levels) = (Vec::new(), Vec::new(), 0);
    for imposed in once(None).chain(others.iter().map(Some)) {
        let (flow, solved) = divided.flow(imposed, drive, options.rtol)?;
        flows.push(flow);
        let name = format!("petsc {}", options.solver.name());
        let (iterations, residual) = (solved.iterations, solved.true_relative_residual);
        let report = SolverReport::new(options.formulation, name, iterations, residual);
        reports.push((report, solved.error_estimate));
        levels = solved.levels;
    }
    let solve = clock.elapsed().as_secs_f64();
    let clock = Instant::now();
    let estimates = match space {
        Some(space) => divided.estimates(space, drive, &flows, options.estimate_rtol)?,
        None => Vec::new(),
    };
    let batch = SolvedBatch {
        flows,
        reports,
        estimates,
        dofs: Dofs {
            velocity: 3 * free_nodes,
            pressure: mesh.n_vertices(),
            total: 3 * free_nodes + border + mesh.n_vertices(),
        },
        seconds: Seconds {
            assembly,
            setup,
            solve,
            estimate: clock.elapsed().as_secs_f64(),
            ..Seconds::default()
        },
    };
    let distributed = |solution| DistributedSolution {
        solution,
        levels,
        own_dofs: sizes.len(),
    };
    let solutions = problem.solutions(batch)?;
    Ok(solutions.into_iter().map(distributed).collect())
}

/// The free vertices of this process, in the order of their dofs.
fn own_free_vertices(
    session: &Session,
    problem: &Problem,
    partition: &Partition,
    numbering: &Numbering,
) -> Vec<u32> {
    let is_own = |node: &u32| partition.owner(*node) == session.rank();
    let vertices = problem.mesh().n_vertices();
    (partition.nodes_by_vertex().iter().copied())
        .filter(is_own)
        .filter(|&node| (node as usize) < vertices && numbering.components(node) != 0)
        .collect()
}

/// A system that is divided between the processes, with its solver.
struct Divided<'a, 's> {
    session: &'s Session,
    problem: &'a Problem<'a>,
    partition: &'a Partition,
    submesh: &'a mesh::Submesh,
    shared: &'a Shared,
    system: &'a Constrained,
    solver: &'a Solver<'s>,
    entries: &'a OwnEntries,
    sizes: &'a [f64],
    fields: &'a Fields<'a>,
}

impl Divided<'_, '_> {
    /// The flow at all nodes for the drive of the system, or at other rates, its pressure with zero
    /// mean.
    fn flow(
        &self,
        imposed: Option<&Imposed>,
        drive: &Drive,
        rtol: f64,
    ) -> Result<(FlowSolution, Solved), PetscError> {
        let rhs = imposed.map_or(&self.system.rhs, |imposed| &imposed.rhs);
        let solved = self.solver.solve(&self.entries.of(rhs), rtol)?;
        let mut solution = vec![0.0; self.entries.len()];
        self.entries.write(&solved.solution, &mut solution);
        let mut flow = match imposed {
            None => self.system.flow(&solution, drive.set)?,
            Some(imposed) => self.system.flow_at(&solution, imposed, drive.set)?,
        };
        flow.velocity = self.fields.nodes(&flow.velocity)?;
        flow.pressure = self.fields.vertices(&flow.pressure)?;
        let mean = mean_pressure(self.problem.mesh(), &flow.pressure).map_err(StokesError::from)?;
        flow.pressure.iter_mut().for_each(|p| *p -= mean);
        Ok((flow, solved))
    }

    /// Estimated errors of flows, by the surplus space of the part of this process.
    fn estimates(
        &self,
        space: SurplusSpace,
        drive: &Drive,
        flows: &[FlowSolution],
        rtol: Option<f64>,
    ) -> Result<Vec<(Estimate, Checks)>, PetscError> {
        let Self {
            session,
            submesh,
            solver,
            entries,
            ..
        } = *self;
        solver.free_basis()?;
        let exchange = LateExchange::default();
        exchange.set(self.shared.of_extension(session, submesh, &space)?);
        let part = surplus_part(session, self.partition, submesh, &space, &exchange);
        let space = space.with_part(part).map_err(StokesError::from)?;
        let equations = PartEquations {
            submesh,
            space: &space,
            system: self.system,
            operator: &DividedMatrix::new(session, solver, entries, self.sizes)?,
            gather: self.fields,
        };
        let mut preconditioner = DividedPreconditioner { solver, entries };
        Ok((self.problem).estimate_part(drive, flows, equations, &mut preconditioner, rtol)?)
    }
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
