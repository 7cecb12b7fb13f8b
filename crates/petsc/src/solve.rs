//! One solution of a Stokes problem that is divided between processes.

use std::time::Instant;

use nalgebra::Vector3;
use rigid::{Drive, FlowSolution, Formulation, MeshPart, NodeRole};
use stokes::{Dofs, Problem, Seconds, Solution, SolverReport};

use crate::PetscError;
use crate::assembly::Part;
use crate::handles::{Session, Vector};
use crate::numbering::{Numbering, components};
use crate::partition::Partition;
use crate::pressure_laplacian::pressure_laplacian;
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

/// Solves a problem for one drive.
///
/// Collective: every process calls it with the same problem. The iteration stops when the relative
/// Euclidean residual and the estimated error of [`linalg::SolveReport`] are below `rtol`.
/// Discretisation errors are not estimated.
///
/// # Errors
/// [`PetscError`]. If only some processes fail, the caller must end all of them
/// ([`Session::abort`]).
pub fn solve(
    session: &Session,
    problem: &Problem,
    drive: &Drive,
    formulation: &dyn Formulation,
    method: Method,
    rtol: f64,
) -> Result<DistributedSolution, PetscError> {
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
    let part = MeshPart::new(owned.clone(), session.sum_over_parts());
    let system = problem.assemble_part(&submesh, part, drive, formulation)?;
    if !linalg::LinearOperator::is_symmetric(&system.system) {
        return Err(PetscError::NotSymmetric {
            formulation: formulation.name(),
        });
    }
    let border = system.system.border_range().len();
    let processes = [session.rank(), session.ranks()];
    let numbering = Numbering::new(mesh, components, &partition, border, processes)?;
    let part = Part {
        system: &system,
        submesh: &submesh,
        numbering: &numbering,
        owned: &owned,
    };
    let mut blocks = part.blocks(session)?;
    if method == Method::Block {
        blocks.pressure_laplacian = pressure_laplacian(session, problem, &part, &partition)?;
    }
    let assembly = clock.elapsed().as_secs_f64();
    let clock = Instant::now();
    let order = partition.nodes_by_vertex();
    let is_own = |node: &&u32| partition.owner(**node) == session.rank();
    let free_vertices: Vec<u32> = (order.iter().filter(is_own).copied())
        .filter(|&node| (node as usize) < mesh.n_vertices() && numbering.components(node) != 0)
        .collect();
    let solver = Solver::new(session, blocks, method, &numbering, &free_vertices)?;
    let setup = clock.elapsed().as_secs_f64();
    let clock = Instant::now();
    let solved = solver.solve(rtol)?;
    let solving = clock.elapsed().as_secs_f64();
    let fields = solved.fields.each_ref().map(Vec::as_slice);
    let local = system.flow(&part.solution(session, fields)?, drive.set)?;
    let flow = of_all_nodes(session, problem, &partition, &order, &part, local)?;
    Ok(DistributedSolution {
        levels: solved.levels,
        own_dofs: solved.fields.iter().map(Vec::len).sum(),
        solution: Solution {
            slip_power: problem.power_of_slip(&flow)?,
            estimate: None,
            checks: None,
            dofs: Dofs {
                velocity: 3 * free_nodes,
                pressure: mesh.n_vertices(),
                total: 3 * free_nodes + border + mesh.n_vertices(),
            },
            solver: SolverReport {
                formulation: formulation.name().to_owned(),
                solver: match method {
                    Method::Block => "petsc block",
                    Method::Direct => "petsc direct",
                }
                .to_owned(),
                iterations: solved.iterations,
                true_relative_residual: solved.true_relative_residual,
            },
            algebraic_error: solved.error_estimate,
            seconds: Seconds {
                assembly,
                setup,
                solve: solving,
                total: assembly + setup + solving,
                ..Seconds::default()
            },
            flow,
        },
    })
}

/// The flow with velocities and pressures of all nodes, from those of each process.
fn of_all_nodes(
    session: &Session,
    problem: &Problem,
    partition: &Partition,
    order: &[u32],
    part: &Part,
    mut flow: FlowSolution,
) -> Result<FlowSolution, PetscError> {
    let mesh = problem.mesh();
    let own_nodes = order
        .iter()
        .filter(|&&node| partition.owner(node) == session.rank());
    let (mut velocities, mut pressures) = (Vec::new(), Vec::new());
    for number in own_nodes.filter_map(|&node| part.submesh.number(node)) {
        velocities.extend(flow.velocity[number as usize].iter());
        pressures.extend(flow.pressure.get(number as usize));
    }
    let velocities = Vector::from_slice(session, &velocities)?.of_all()?;
    let pressures = Vector::from_slice(session, &pressures)?.of_all()?;
    let mut by_owner: Vec<u32> = order.to_vec();
    by_owner.sort_by_key(|&node| partition.owner(node));
    flow.velocity = vec![Vector3::zeros(); mesh.n_points()];
    for (&node, value) in by_owner.iter().zip(velocities.chunks_exact(3)) {
        flow.velocity[node as usize] = Vector3::from_column_slice(value);
    }
    let vertices = (by_owner.iter()).filter(|&&node| (node as usize) < mesh.n_vertices());
    flow.pressure = vec![0.0; mesh.n_vertices()];
    for (&vertex, value) in vertices.zip(pressures) {
        flow.pressure[vertex as usize] = value;
    }
    let mean =
        stokes::fem::mean_pressure(mesh, &flow.pressure).map_err(stokes::StokesError::from)?;
    flow.pressure.iter_mut().for_each(|p| *p -= mean);
    Ok(flow)
}
