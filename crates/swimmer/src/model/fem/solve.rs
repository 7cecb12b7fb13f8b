//! One instant on one mesh: assembly, constraints, solve.

use std::time::Instant;

use fem::{Chords, RoundPart, SurplusSpace, TaylorHood};
use linalg::{
    BlockDiagonal, BlockTriangular, KrylovParams, SaddleLdlt, Schwarz, SchwarzParams, SolveReport,
    WarmStart, fgmres, fgmres_columns, minres,
};
use mesh::{Sphere, TetMesh};
use nalgebra::Vector3;
use rigid::{
    Arms, Articulation, BodyKind, Constrained, DirectRows, Drive, Eliminated, Flow, FluidMatrices,
    Formulation, GrandResistance, Independent, Lagrange, Load, NodeRole, RigidFluid, SurfaceBody,
};

use super::checks;
use super::estimate::{self, Duals, Estimate, Solved};
use crate::model::{Checks, Dofs, ModelError, Seconds, SolverInfo};
use crate::scene::{FemOptions, FormulationKind, SolverKind};

/// Iterations of additive Schwarz grow with the number of subdomains, and no hierarchy bounds them.
const SCHWARZ_ITERATIONS: usize = 1000;

/// A restart loses what the basis knew: 60 vectors stall where 150 converge, at 12 bytes an unknown and vector.
const SCHWARZ_RESTART: usize = 150;

/// Right-hand sides of a pass over the matrices when there are many: each takes about 24 vectors of memory.
const AT_ONCE: usize = 3;

/// Which parts of a mesh's boundary are what.
pub struct Boundary<'a> {
    /// Tags of the rigid bodies.
    pub bodies: Vec<&'a str>,
    /// Centre of each body.
    pub centres: Vec<Vector3<f64>>,
    /// Tags of no-slip walls.
    pub walls: Vec<&'a str>,
    /// The spheres that straight facets stand for, with their tags.
    pub chords: Vec<(&'a str, Sphere)>,
    /// For each cell how easily pressure drives fluid through the gap it lies in, where gaps are narrow.
    pub permeability: Option<Vec<f64>>,
}

impl Boundary<'_> {
    /// The facets of a mesh that cut off spheres.
    fn chords<'m>(&self, mesh: &'m TetMesh) -> Result<Chords<'m>, ModelError> {
        let part = |(name, sphere): &(&str, Sphere)| -> Result<_, ModelError> {
            Ok(RoundPart {
                tag: mesh.tag(name)?,
                centre: sphere.centre,
                radius: sphere.radius,
                is_wall: self.walls.contains(name),
            })
        };
        let parts: Vec<_> = self.chords.iter().map(part).collect::<Result<_, _>>()?;
        Ok(Chords::new(mesh, &parts)?)
    }
}

/// A solved instant, in units of the flow.
pub struct SolvedFlow {
    /// Velocities, forces, pressure.
    pub flow: Flow,
    /// Estimated errors, if wanted.
    pub estimate: Option<Estimate>,
    /// Other ways to the same numbers, if estimates were wanted.
    pub checks: Option<Checks>,
    /// Numbers of unknowns.
    pub dofs: Dofs,
    /// How it was solved.
    pub solver: SolverInfo,
    /// Estimated relative error of the velocities by the solver.
    pub relative_error: f64,
    /// Assembly, set-up and solve.
    pub seconds: Seconds,
}

/// Solves the flow around rigid bodies that move as `drive` says, and estimates its errors if given the cubic functions of the mesh and flows to start from.
///
/// # Errors
/// Whatever keeps the system from being built or solved.
pub fn solve(
    space: &TaylorHood,
    mesh: &TetMesh,
    boundary: &Boundary,
    drive: &Drive,
    options: &FemOptions,
    warm: &mut WarmStart,
    estimates: Option<(&SurplusSpace, &mut Duals)>,
) -> Result<SolvedFlow, ModelError> {
    let clock = Instant::now();
    let formulation: &dyn Formulation = match options.formulation {
        FormulationKind::PTilde => &Eliminated,
        FormulationKind::Lagrange => &Lagrange,
        FormulationKind::DirectRow => &DirectRows,
    };
    let system = assemble(space, mesh, boundary, drive, formulation)?;
    let assembly = clock.elapsed().as_secs_f64();
    let mut preconditioner = None;
    let (solution, report, mut seconds) =
        solve_system(&system, options, warm, &mut preconditioner)?;
    warm.remember(&solution);
    let solver = SolverInfo {
        formulation: options.formulation.word().to_owned(),
        solver: options.solver.word().to_owned(),
        iterations: report.iterations,
        true_relative_residual: report.true_rel_residual,
    };
    seconds.assembly = assembly;
    let mut flow = system.flow(&solution, drive.set)?;
    let mean = fem::mean_pressure(mesh, &flow.pressure)?;
    flow.pressure.iter_mut().for_each(|p| *p -= mean);
    seconds.total = clock.elapsed().as_secs_f64();
    let before = clock.elapsed().as_secs_f64();
    let (mut estimate, mut checks) = (None, None);
    if let Some((surplus, duals)) = estimates {
        let solved = Solved {
            mesh,
            space: surplus,
            chords: &boundary.chords(mesh)?,
            drive,
            system: &system,
            flow: &flow,
        };
        let preconditioner = match preconditioner {
            Some(preconditioner) => preconditioner,
            // Whatever solver was asked for: flows of estimates need few digits, and this one is the fastest to them.
            None => system.preconditioner()?,
        };
        estimate = Some(estimate::estimate(&solved, preconditioner, duals)?);
        checks = Some(checks::checks(mesh, boundary, &flow)?);
        seconds.estimate = clock.elapsed().as_secs_f64() - before;
    }
    let dofs = Dofs {
        velocity: system.system.velocity_range().len(),
        pressure: system.system.pressure_range().len(),
        total: solution.len(),
    };
    Ok(SolvedFlow {
        flow,
        estimate,
        checks,
        dofs,
        solver,
        relative_error: report.error_estimate(),
        seconds,
    })
}

/// Assembles the system of one instant.
///
/// # Errors
/// Tags that the mesh does not have, degenerate cells, constraints that contradict each other.
pub fn assemble(
    space: &TaylorHood,
    mesh: &TetMesh,
    boundary: &Boundary,
    drive: &Drive,
    formulation: &dyn Formulation,
) -> Result<Constrained, ModelError> {
    let mut roles = vec![NodeRole::Free; mesh.n_points()];
    for tag in &boundary.walls {
        mesh.nodes_on(mesh.tag(tag)?)
            .iter()
            .for_each(|&node| roles[node as usize] = NodeRole::Fixed);
    }
    let mut bodies = Vec::with_capacity(boundary.bodies.len());
    for (number, (name, &centre)) in boundary.bodies.iter().zip(&boundary.centres).enumerate() {
        let tag = mesh.tag(name)?;
        mesh.nodes_on(tag)
            .iter()
            .for_each(|&node| roles[node as usize] = NodeRole::Body(number as u32));
        bodies.push(SurfaceBody {
            centre,
            volume: fem::surface_measures(mesh, tag)?.volume,
        });
    }
    let fluid = RigidFluid::new(
        FluidMatrices {
            stiffness: space.stiffness(mesh)?,
            divergence: space.divergence(mesh)?,
            pressure_mass: space.pressure_mass(mesh)?,
            interpolation: space.vertex_interpolation(mesh)?,
            vertex_stiffness: space.vertex_stiffness(mesh)?,
            points: mesh.points(),
            roles: &roles,
            on_planes: mesh.nodes_on_mirrors(),
        },
        &bodies,
    )?;
    let mut system = formulation.constrain(fluid, drive)?;
    if let Some(permeability) = &boundary.permeability {
        system.gap_stiffness = Some(space.weighted_vertex_stiffness(mesh, permeability)?);
    }
    Ok(system)
}

/// The grand resistance of the bodies: 6n solves with one preconditioner, some at a time.
///
/// # Errors
/// Whatever keeps the system from being built or solved.
pub fn resistance(
    space: &TaylorHood,
    mesh: &TetMesh,
    boundary: &Boundary,
    rtol: f64,
) -> Result<GrandResistance, ModelError> {
    let bodies = boundary.centres.len();
    let set = Articulation::new(
        &vec![BodyKind::Rigid; bodies],
        Vec::new(),
        Arms::Clamped,
        &boundary.centres,
    )?;
    let drive = Drive {
        set: &set,
        constraints: &set.constraints(&set.initial_state(), &[], &[])?,
        loads: &vec![Load::default(); bodies],
    };
    let system = assemble(space, mesh, boundary, &drive, &Independent)?;
    let mut preconditioner = system.preconditioner()?;
    let parameters = KrylovParams {
        rel_tol: rtol,
        ..KrylovParams::default()
    };
    GrandResistance::of(&system, AT_ONCE, |rights, solutions| {
        let system = &system.system;
        fgmres_columns(system, &mut preconditioner, rights, solutions, &parameters)?;
        Ok(())
    })
}

/// Solves an assembled system with the solver asked for; leaves the block solver's preconditioner to others.
fn solve_system<'s>(
    system: &'s Constrained,
    options: &FemOptions,
    warm: &WarmStart,
    kept: &mut Option<BlockTriangular<'s>>,
) -> Result<(Vec<f64>, SolveReport, Seconds), ModelError> {
    let mut seconds = Seconds::default();
    let mut solution = vec![0.0; system.right.len()];
    let parameters = KrylovParams {
        rel_tol: options.rtol,
        ..KrylovParams::default()
    };
    let start = Instant::now();
    if options.solver != SolverKind::Direct {
        warm.guess(&system.system, &system.right, &mut solution)?;
    }
    let clock = Instant::now();
    let report = match options.solver {
        SolverKind::Block => {
            let preconditioner = kept.insert(system.preconditioner()?);
            seconds.setup = clock.elapsed().as_secs_f64();
            fgmres(
                &system.system,
                preconditioner,
                &system.right,
                &mut solution,
                &parameters,
            )?
        }
        SolverKind::Direct => {
            let mut factor = SaddleLdlt::factor(&system.system, &Default::default())?;
            seconds.setup = clock.elapsed().as_secs_f64();
            factor.solve(&system.right, &mut solution)?
        }
        SolverKind::Schwarz => {
            let parameters_of_cut = SchwarzParams {
                subdomains: options.subdomains as usize,
                overlap: options.overlap as usize,
                ..SchwarzParams::default()
            };
            let mut preconditioner = Schwarz::new(&system.system, &parameters_of_cut)?;
            seconds.setup = clock.elapsed().as_secs_f64();
            fgmres(
                &system.system,
                &mut preconditioner,
                &system.right,
                &mut solution,
                &KrylovParams {
                    max_iterations: SCHWARZ_ITERATIONS,
                    restart: SCHWARZ_RESTART,
                    ..parameters
                },
            )?
        }
        SolverKind::Minres => {
            let mut preconditioner =
                BlockDiagonal::with_transfer(&system.system, &system.transfer)?;
            seconds.setup = clock.elapsed().as_secs_f64();
            minres(
                &system.system,
                &mut preconditioner,
                &system.right,
                &mut solution,
                &parameters,
            )?
        }
    };
    seconds.solve = start.elapsed().as_secs_f64() - seconds.setup;
    Ok((solution, report, seconds))
}
