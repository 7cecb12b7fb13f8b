//! Stokes flow without rigid bodies: prescribed velocity on the whole boundary.

use fem::{
    DirichletCondition, StokesMatrices, TaylorHood, continuity_residual, load_vector,
    mean_pressure, momentum_residual,
};
use linalg::{
    BlockTriangular, Bordered, Csr, KrylovParams, Multigrid, MultigridParams, NullVectors,
    SaddleSystem, SolveReport, fgmres,
};
use mesh::TetMesh;
use nalgebra::Vector3;

use crate::StokesError;

/// Largest relative net flux that is taken for an interpolation error.
///
/// Interpolation on curved facets leaves a net flux of third order in their size.
const MAX_NET_FLUX: f64 = 1e-2;

/// Vector field as a function of position.
pub type VectorField<'a> = &'a (dyn Fn(Vector3<f64>) -> Vector3<f64> + Sync);

/// Velocity and pressure of a Stokes flow.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Flow {
    /// Velocity at the nodes of the mesh.
    pub velocity: Vec<Vector3<f64>>,
    /// Pressure at the vertices of the mesh, with zero mean over the fluid.
    pub pressure: Vec<f64>,
    /// How the linear system was solved.
    pub report: SolveReport,
}

/// Solves `-Δu + ∇p = f`, `∇·u = 0` with prescribed velocity `u` on the whole boundary.
///
/// `force` is the body force per volume, zero if there is none; the viscosity is 1. The velocity is
/// interpolated at the nodes of the boundary facets, which include symmetry planes. A small net
/// flux of the interpolated velocity is balanced by uniform sources in the fluid. `rtol` is the
/// true relative residual at which the solver stops.
///
/// For flow around rigid bodies, and for several solutions on one mesh, see
/// [`Problem`](crate::Problem).
///
/// ```
/// use mesh::{LinearTets, TetMesh};
/// use nalgebra::Vector3;
///
/// // Poiseuille flow between the planes z = 0 and z = 1, driven by a force of 8 along x.
/// let mesh = TetMesh::straight(LinearTets::cube(2))?;
/// let exact = |x: Vector3<f64>| Vector3::new(4.0 * x.z * (1.0 - x.z), 0.0, 0.0);
/// let flow = stokes::solve_stokes(&mesh, &exact, Some(&|_| Vector3::new(8.0, 0.0, 0.0)), 1e-10)?;
/// for (x, u) in mesh.points().iter().zip(&flow.velocity) {
///     assert!((u - exact(*x)).norm() < 1e-8);
/// }
/// assert!(flow.pressure.iter().all(|p| p.abs() < 1e-7));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Inverted cells, a velocity or force that is not finite, [`StokesError::NetFlux`] for a velocity
/// with a net flux through the boundary, [`StokesError::Linalg`] without convergence.
pub fn solve_stokes(
    mesh: &TetMesh,
    velocity: VectorField,
    force: Option<VectorField>,
    rtol: f64,
) -> Result<Flow, StokesError> {
    let StokesMatrices {
        stiffness,
        divergence,
        pressure_mass,
        ..
    } = TaylorHood::new(mesh)?.matrices(mesh)?;
    let condition = DirichletCondition::on_boundary(mesh);
    let mut u: Vec<Vector3<f64>> = mesh.points().iter().map(|&x| velocity(x)).collect();
    condition.lift(&mut u)?;
    let load = match force {
        Some(force) => load_vector(mesh, force)?,
        None => vec![Vector3::zeros(); mesh.n_points()],
    };
    // [K B^T; B 0] [u; p] = [f; 0], and the lift of the boundary values on the right-hand side.
    let image = momentum_residual(&stiffness, &divergence, &u, &vec![0.0; mesh.n_vertices()])?;
    let mut rhs = condition.rhs(&load, &image)?;
    let sources = continuity_residual(&divergence, &u)?;
    check_net_flux(&sources)?;
    rhs.extend(sources.iter().map(|source| -source));

    let system = SaddleSystem::new(
        Bordered::scalar(condition.restrict_matrix(&stiffness, 1)?)?,
        condition.restrict_divergence(&divergence)?,
        // No rigid bodies: the border has no columns.
        Csr::zero((mesh.n_vertices(), 0)),
        None,
        pressure_mass,
    )?;
    let multigrid = Multigrid::new(system.velocity_block(), &MultigridParams::default())?;
    let mut preconditioner = BlockTriangular::new(&system, multigrid)?;
    let constant_pressure = NullVectors::constant_on(rhs.len(), system.pressure_range())?;
    let parameters = KrylovParams::default()
        .with_rel_tol(rtol)
        .with_null_vectors(constant_pressure);
    let mut solution = vec![0.0; rhs.len()];
    let report = fgmres(
        &system,
        &mut preconditioner,
        &rhs,
        &mut solution,
        &parameters,
    )?;

    let mut pressure = solution.split_off(3 * condition.n_free());
    condition.expand(&solution, &mut u)?;
    let mean = mean_pressure(mesh, &pressure)?;
    pressure.iter_mut().for_each(|p| *p -= mean);
    Ok(Flow {
        velocity: u,
        pressure,
        report,
    })
}

/// Refuses boundary velocities whose net flux exceeds an interpolation error.
///
/// `sources` is `B u_D`, whose entries sum to minus the flux out of the domain.
fn check_net_flux(sources: &[f64]) -> Result<(), StokesError> {
    let flux = -sources.iter().sum::<f64>();
    let size: f64 = sources.iter().map(|source| source.abs()).sum();
    if flux.abs() > MAX_NET_FLUX * size {
        return Err(StokesError::NetFlux {
            flux,
            relative: flux.abs() / size,
        });
    }
    Ok(())
}
