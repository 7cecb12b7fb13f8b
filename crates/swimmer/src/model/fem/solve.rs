//! Instants on one mesh: assembly, constraints, solve.

use std::iter::{once, repeat};
use std::time::Instant;

use fem::{CurvedBoundary, FacetGeometry, StokesMatrices, SurplusSpace, TaylorHood};
use linalg::{
    BlockDiagonal, BlockTriangular, KrylovParams, LinalgError, SaddleLdlt, SaddleSystem, Schwarz,
    SchwarzParams, SolveReport, WarmStart, fgmres, fgmres_columns, minres,
};
use mesh::{Sphere, TetMesh};
use nalgebra::Vector3;
use rigid::{
    Arms, Articulation, BodyKind, Constrained, DirectRows, Drive, Eliminated, ExternalLoad,
    FlowSolution, FluidMatrices, Formulation, GrandResistance, Imposed, Independent, Lagrange,
    NodeRole, RigidFluid, SurfaceBody,
};

use super::checks;
use super::estimate::{self, AdjointSolutions, Estimate, Solved};
use crate::model::{Checks, Dofs, ModelError, Seconds, SolverInfo};
use scene::{FemOptions, FormulationKind, SolverKind};

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
    fn facet_geometry<'m>(&self, mesh: &'m TetMesh) -> Result<FacetGeometry<'m>, ModelError> {
        let part = |(name, sphere): &(&str, Sphere)| -> Result<_, ModelError> {
            Ok(CurvedBoundary {
                tag: mesh.tag(name)?,
                centre: sphere.centre,
                radius: sphere.radius,
                is_wall: self.walls.contains(name),
            })
        };
        let parts: Vec<_> = self.chords.iter().map(part).collect::<Result<_, _>>()?;
        Ok(FacetGeometry::new(mesh, &parts)?)
    }
}

/// A solved instant, in units of the flow.
pub struct SolvedFlow {
    /// Velocities, forces, pressure.
    pub flow: FlowSolution,
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

/// Solves the flow around rigid bodies for each of `drives`, which differ in the rates of links only, and estimates errors if given the cubic functions
/// of the mesh and flows to start from.
///
/// One matrix and one preconditioner serve all drives; the first answer has the seconds that they took.
///
/// # Errors
/// Whatever keeps the system from being built or solved.
pub fn solve(
    space: &TaylorHood,
    mesh: &TetMesh,
    boundary: &Boundary,
    drives: &[Drive],
    options: &FemOptions,
    warm: &mut WarmStart,
    estimates: Option<(&SurplusSpace, &mut AdjointSolutions)>,
) -> Result<Vec<SolvedFlow>, ModelError> {
    let Some((drive, others)) = drives.split_first() else {
        return Ok(Vec::new());
    };
    let clock = Instant::now();
    let formulation: &dyn Formulation = match options.formulation {
        FormulationKind::PTilde => &Eliminated,
        FormulationKind::Lagrange => &Lagrange,
        FormulationKind::DirectRow => &DirectRows,
    };
    let system = assemble(space, mesh, boundary, drive, formulation)?;
    let others: Vec<Imposed> = others
        .iter()
        .map(|drive| system.imposed(drive))
        .collect::<Result<_, _>>()?;
    let assembly = clock.elapsed().as_secs_f64();
    let rights: Vec<&[f64]> = once(&system.rhs)
        .chain(others.iter().map(|other| &other.rhs))
        .map(Vec::as_slice)
        .collect();
    let mut preconditioner = None;
    let Solutions {
        columns,
        setup,
        solve,
    } = solve_system(&system, &rights, options, warm, &mut preconditioner)?;
    let dofs = Dofs {
        velocity: system.system.velocity_range().len(),
        pressure: system.system.pressure_range().len(),
        total: system.rhs.len(),
    };
    let (mut flows, mut reports) = (Vec::new(), Vec::new());
    let imposed = once(None).chain(others.iter().map(Some));
    for ((solution, report), imposed) in columns.into_iter().zip(imposed) {
        warm.remember(&solution);
        let mut flow = match imposed {
            None => system.flow(&solution, drive.set)?,
            Some(other) => system.flow_at(&solution, other, drive.set)?,
        };
        let mean = fem::mean_pressure(mesh, &flow.pressure)?;
        flow.pressure.iter_mut().for_each(|p| *p -= mean);
        flows.push(flow);
        reports.push(report);
    }
    let mut estimating = 0.0;
    let mut judged: Vec<(Option<Estimate>, Option<Checks>)> = vec![(None, None); flows.len()];
    if let Some((surplus, adjoint_solutions)) = estimates {
        let clock = Instant::now();
        let solved = Solved {
            mesh,
            space: surplus,
            facet_geometry: &boundary.facet_geometry(mesh)?,
            drive,
            system: &system,
        };
        let mut preconditioner = match preconditioner {
            Some(preconditioner) => preconditioner,
            // Whatever solver was asked for: flows of estimates need few digits, and this one is the fastest to them.
            None => system.preconditioner()?,
        };
        let estimates =
            estimate::estimates(&solved, &flows, &mut preconditioner, adjoint_solutions)?;
        for ((judged, estimate), flow) in judged.iter_mut().zip(estimates).zip(&flows) {
            *judged = (Some(estimate), Some(checks::checks(mesh, boundary, flow)?));
        }
        estimating = clock.elapsed().as_secs_f64();
    }
    let count = drives.len() as f64;
    let mut own = Seconds {
        solve: solve / count,
        estimate: estimating / count,
        ..Seconds::default()
    };
    own.total = own.solve + own.estimate;
    // what was done once stands with the first
    let shared = Seconds {
        assembly,
        setup,
        total: assembly + setup,
        ..Seconds::default()
    };
    let seconds = once(shared).chain(repeat(Seconds::default()));
    Ok((flows.into_iter().zip(reports).zip(judged).zip(seconds))
        .map(|(((flow, report), (estimate, checks)), mut seconds)| {
            seconds += own;
            SolvedFlow {
                flow,
                estimate,
                checks,
                dofs,
                solver: SolverInfo {
                    formulation: options.formulation.word().to_owned(),
                    solver: options.solver.word().to_owned(),
                    iterations: report.iterations,
                    true_relative_residual: report.true_rel_residual,
                },
                relative_error: report.error_estimate(),
                seconds,
            }
        })
        .collect())
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
    let StokesMatrices {
        stiffness,
        divergence,
        pressure_mass,
        interpolation,
        vertex_stiffness,
    } = space.matrices(mesh)?;
    let fluid = RigidFluid::new(
        FluidMatrices {
            stiffness,
            divergence,
            pressure_mass,
            interpolation,
            vertex_stiffness,
            points: mesh.points(),
            roles: &roles,
            on_symmetry_planes: mesh.nodes_on_symmetry_planes(),
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
        loads: &vec![ExternalLoad::default(); bodies],
    };
    let system = assemble(space, mesh, boundary, &drive, &Independent)?;
    let mut preconditioner = system.preconditioner()?;
    let parameters = KrylovParams::default().with_rel_tol(rtol);
    GrandResistance::of(&system, AT_ONCE, |rights, solutions| {
        let system = &system.system;
        fgmres_columns(system, &mut preconditioner, rights, solutions, &parameters)?;
        Ok(())
    })
}

/// Solves for right-hand sides in equal groups of at most [`AT_ONCE`].
pub(super) fn in_groups(
    system: &SaddleSystem,
    preconditioner: &mut BlockTriangular,
    rights: &[&[f64]],
    solutions: &mut [&mut [f64]],
    parameters: &KrylovParams,
) -> Result<Vec<SolveReport>, LinalgError> {
    let groups = rights.len().div_ceil(AT_ONCE).max(1);
    let size = rights.len().div_ceil(groups).max(1);
    let mut reports = Vec::with_capacity(rights.len());
    for (rights, solutions) in rights.chunks(size).zip(solutions.chunks_mut(size)) {
        let group = fgmres_columns(system, preconditioner, rights, solutions, parameters)?;
        reports.extend(group);
    }
    Ok(reports)
}

/// Solutions of one system.
struct Solutions {
    /// One a right-hand side, with how it went.
    columns: Vec<(Vec<f64>, SolveReport)>,
    /// Seconds of setting up the solver.
    setup: f64,
    /// Seconds of all solves.
    solve: f64,
}

/// Solves an assembled system for several right-hand sides with the solver asked for; leaves the block solver's preconditioner to others.
fn solve_system(
    assembled: &Constrained,
    rights: &[&[f64]],
    options: &FemOptions,
    warm: &WarmStart,
    kept: &mut Option<BlockTriangular>,
) -> Result<Solutions, ModelError> {
    let system = &assembled.system;
    let mut solutions = vec![vec![0.0; assembled.rhs.len()]; rights.len()];
    let parameters = KrylovParams::default().with_rel_tol(options.rtol);
    let start = Instant::now();
    let mut columns: Vec<&mut [f64]> = solutions.iter_mut().map(Vec::as_mut_slice).collect();
    if options.solver != SolverKind::Direct {
        warm.guess_columns(system, rights, &mut columns)?;
    }
    let mut reports = Vec::with_capacity(rights.len());
    let clock = Instant::now();
    let setup;
    match options.solver {
        SolverKind::Block => {
            let preconditioner = kept.insert(assembled.preconditioner()?);
            setup = clock.elapsed().as_secs_f64();
            let in_passes = in_groups(system, preconditioner, rights, &mut columns, &parameters)?;
            reports.extend(in_passes);
        }
        SolverKind::Direct => {
            let mut factor = SaddleLdlt::factor(system, &Default::default())?;
            setup = clock.elapsed().as_secs_f64();
            for (right, solution) in rights.iter().zip(&mut columns) {
                reports.push(factor.solve(right, solution)?);
            }
        }
        SolverKind::Schwarz => {
            let parameters_of_cut = SchwarzParams::default()
                .with_subdomains(options.subdomains as usize)
                .with_overlap(options.overlap as usize);
            let mut preconditioner = Schwarz::new(system, &parameters_of_cut)?;
            setup = clock.elapsed().as_secs_f64();
            let parameters = parameters
                .with_max_iterations(SCHWARZ_ITERATIONS)
                .with_restart(SCHWARZ_RESTART);
            // one by one: each basis is long
            for (right, solution) in rights.iter().zip(&mut columns) {
                reports.push(fgmres(
                    system,
                    &mut preconditioner,
                    right,
                    solution,
                    &parameters,
                )?);
            }
        }
        SolverKind::Minres => {
            let mut preconditioner =
                BlockDiagonal::with_prolongation(system, &assembled.prolongation)?;
            setup = clock.elapsed().as_secs_f64();
            for (right, solution) in rights.iter().zip(&mut columns) {
                reports.push(minres(
                    system,
                    &mut preconditioner,
                    right,
                    solution,
                    &parameters,
                )?);
            }
        }
    }
    Ok(Solutions {
        columns: solutions.into_iter().zip(reports).collect(),
        setup,
        solve: start.elapsed().as_secs_f64() - setup,
    })
}
