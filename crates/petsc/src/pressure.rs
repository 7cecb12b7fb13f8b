//! Schur complement of the pressure: rows without free nodes, Laplacian in gaps and channels.

use stokes::Problem;
use stokes::fem::TaylorHood;

use crate::PetscError;
use crate::assembly::{Part, entries};
use crate::handles::{Krylov, Matrix, Rows, Session, Vector};
use crate::partition::Partition;

/// Multiple of the mass matrix that is added to the Laplacian, as in `linalg`: constants are its
/// null vectors.
const SHIFT: f64 = 1e-3;

/// Residual of the torsion function, and bound on its iterations, as in `stokes`.
const TORSION_RTOL: f64 = 1e-2;
const MAX_TORSION_ITERATIONS: usize = 100;

/// The rows of this process, or `None` where neither gaps nor channels make a Laplacian matter.
///
/// Collective. The torsion function is solved on all processes, and known to each of them; the
/// permeabilities of the cells follow from it without messages.
///
/// # Errors
/// Those of PETSc; a torsion function that does not converge.
pub fn pressure_laplacian<'s>(
    session: &'s Session,
    problem: &Problem,
    part: &Part,
    partition: &Partition,
) -> Result<Option<Matrix<'s>>, PetscError> {
    let torsion = match problem.is_closed() {
        true => Some(torsion(session, problem, part)?),
        false => None,
    };
    let Some(permeability) = problem.permeability(torsion.as_deref()) else {
        return Ok(None);
    };
    let cells = problem.mesh().cells().iter().zip(&permeability);
    let of_part: Vec<f64> = cells
        .filter(|(cell, _)| partition.assembles(session.rank(), cell))
        .map(|(_, k)| *k)
        .collect();
    let mesh = &part.submesh.mesh;
    let stiffness = TaylorHood::new(mesh)
        .and_then(|space| space.weighted_vertex_stiffness(mesh, &of_part))
        .map_err(stokes::StokesError::from)?;
    let mass = part.system.system.pressure_mass();
    let mut rows = Rows::default();
    for (row, _) in part.own_vertices() {
        let shift = entries(mass, row).map(|(column, value)| (column, SHIFT * value));
        let mut sums = std::collections::BTreeMap::new();
        for (column, value) in entries(&stiffness, row).chain(shift) {
            *sums.entry(column).or_insert(0.0) += value;
        }
        for (column, value) in sums {
            rows.push(part.numbering.pressure(part.submesh.nodes[column]), value);
        }
        rows.end_row()?;
    }
    Matrix::from_rows(session, &rows, part.numbering.own_pressure().len()).map(Some)
}

/// The torsion function at all vertices of the mesh: `-Δ psi = 1`, zero at walls and bodies.
fn torsion(session: &Session, problem: &Problem, part: &Part) -> Result<Vec<f64>, PetscError> {
    let vertices = part.submesh.mesh.n_vertices();
    let mut free: Vec<u32> = (part.system.free_nodes().iter().copied())
        .filter(|&node| (node as usize) < vertices)
        .collect();
    free.sort_unstable();
    let (mut rows, mut load) = (Rows::default(), Vec::new());
    for (vertex, node) in part.own_vertices() {
        match free.binary_search(&(vertex as u32)) {
            Ok(row) => {
                for (column, value) in entries(&part.system.vertex_stiffness, row) {
                    let other = part.submesh.nodes[free[column] as usize];
                    rows.push(part.numbering.pressure(other), value);
                }
                let mass = entries(part.system.system.pressure_mass(), vertex);
                load.push(mass.map(|(_, value)| value).sum());
            }
            Err(_) => {
                rows.push(part.numbering.pressure(node), 1.0);
                load.push(0.0);
            }
        }
        rows.end_row()?;
    }
    let matrix = Matrix::from_rows(session, &rows, part.numbering.own_pressure().len())?;
    let solver = Krylov::new(session)?;
    solver.set_type(c"cg")?;
    solver.set_prefix(c"torsion_")?;
    solver.set_operators(&matrix, &matrix)?;
    solver.preconditioner()?.set_algebraic_multigrid()?;
    solver.set_tolerance(TORSION_RTOL, MAX_TORSION_ITERATIONS)?;
    solver.read_options()?;
    let load = Vector::from_slice(session, &load)?;
    let mut solution = Vector::new(session, part.numbering.own_pressure().len())?;
    solver.solve(&load, &mut solution)?;
    let reason = solver.reason()?;
    if reason < 0 {
        let mut residual = Vector::new(session, part.numbering.own_pressure().len())?;
        matrix.apply(&solution, &mut residual)?;
        residual.subtract_from(&load)?;
        return Err(PetscError::NotConverged {
            role: "torsion function".to_owned(),
            iterations: solver.iterations()?,
            reason,
            true_relative_residual: residual.norm()? / load.norm()?,
        });
    }
    let all = solution.of_all()?;
    let vertices = 0..problem.mesh().n_vertices() as u32;
    let number = |vertex| part.numbering.pressure(vertex) as usize;
    Ok(vertices
        .map(|vertex| all[number(vertex)].max(0.0))
        .collect())
}

/// Multiple of the mass matrix in the Schur complement of a weak row, as in `linalg`.
const WEAK_ROW_FACTOR: f64 = 4.0;

/// A square matrix without nonzeros.
pub fn no_entries<'s>(session: &'s Session, size: usize) -> Result<Matrix<'s>, PetscError> {
    let mut rows = Rows::default();
    for _ in 0..size {
        rows.end_row()?;
    }
    Matrix::from_rows(session, &rows, size)
}

/// Unit vector of the constant pressure in the scaled system.
pub fn null_vector<'s>(
    session: &'s Session,
    [motion, pressure]: &[Vec<f64>; 2],
) -> Result<Vector<'s>, PetscError> {
    let mut constant = vec![0.0; motion.len()];
    constant.extend(pressure.iter().map(|factor| factor.recip()));
    let norm = Vector::from_slice(session, &constant)?.norm()?;
    constant.iter_mut().for_each(|value| *value /= norm);
    Vector::from_slice(session, &constant)
}

/// Diagonal `-W` that is added to the inverse of the negative mass matrix at edges and corners.
///
/// `W = max(0, 1 / (4 s) - 1 / m)` with `s = (B D^-1 B^T)_qq` and the diagonal `m` of the mass
/// matrix, as in `linalg`. In the scaled system `m` is one and `s` is the squared norm of a row of
/// `B`. The sign is that of the Schur complement.
pub fn weak_rows(divergence: &Matrix) -> Result<Vec<f64>, PetscError> {
    let mut weak = Vec::new();
    divergence.for_each_row(|_, values| {
        let schur: f64 = values.iter().map(|value| value * value).sum();
        let excess = (WEAK_ROW_FACTOR * schur).recip() - 1.0;
        // A row without free velocities has no Schur complement to approximate.
        let is_weak = excess > 0.0 && excess.is_finite();
        weak.push(if is_weak { -excess } else { 0.0 });
    })?;
    Ok(weak)
}
