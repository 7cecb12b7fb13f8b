//! Errors of an instant by mesh and solver, from dual flows with the same matrix.
//!
//! A velocity $q_k$ answers to its own load: with the flow `z` of a unit load on it, links held, its error by the mesh is
//! $q_{h,k} - q_k = -K(e_z, e)$ (`fem::SurplusSpace`), and by the solver the product of `z` and the residual. Errors common
//! to equal bodies cancel in this sum as they do in the velocity; the bound $\sqrt{K(e_z, e_z) K(e, e)}$ would be forty times too
//! wide for a three-sphere swimmer.

use fem::{Surplus, SurplusSpace};
use linalg::{KrylovParams, LinearOperator, fgmres};
use mesh::TetMesh;
use nalgebra::{DVector, Vector3};
use rigid::{BodyKind, Constrained, Drive, Flow, Twist};

use crate::model::ModelError;

/// Estimated errors of one instant, in units of the flow.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Errors of each linkage's frame velocity, where there are few enough of them.
    pub frames: Option<FrameErrors>,
    /// $K(e, e)$ over the power of the bodies: the relative error of their forces.
    pub relative_energy: f64,
}

/// Errors of frame velocities, computed less exact.
#[derive(Clone, Debug, Default)]
pub struct FrameErrors {
    /// By the mesh.
    pub mesh: Vec<Twist>,
    /// What the linear part of `mesh` may err by itself.
    pub spread: f64,
    /// By the solver.
    pub algebraic: Vec<Twist>,
}

/// Residual at which dual flows are good enough, relative: against 1e-6 the estimated error of the default stroke's net displacement
/// changes by 0.2 percent, with 3e-3 by one. Started from those of the instant before they take one to five iterations each, from zero eight.
const DUAL_RTOL: f64 = 1e-3;

/// Six dual flows a linkage are worth their time for so many linkages.
const MOST_LINKAGES: usize = 4;

/// A cell's share in an estimate is trusted to half of itself, independently of the others'. A choice, not a bound: estimated speeds of
/// three-sphere swimmers miss by less, but one leg of the default stroke misses by three times its spread.
const CELL_TRUST: f64 = 0.5;

/// Dual solutions of the last instant on a mesh of the same cells: where the next ones start.
#[derive(Clone, Debug, Default)]
pub struct Duals(Vec<Vec<f64>>);

impl Duals {
    /// The solution of this number to start from, zero if there is none.
    fn start(&mut self, number: usize, unknowns: usize) -> &mut [f64] {
        if self.0.len() <= number {
            self.0.resize(number + 1, Vec::new());
        }
        let dual = &mut self.0[number];
        if dual.len() != unknowns {
            *dual = vec![0.0; unknowns];
        }
        dual
    }
}

/// The parts of a solved instant that errors are estimated from.
pub struct Solved<'a> {
    /// Mesh of the instant.
    pub mesh: &'a TetMesh,
    /// What drove it.
    pub drive: &'a Drive<'a>,
    /// Its system.
    pub system: &'a Constrained,
    /// The solution of the system.
    pub solution: &'a [f64],
    /// The flow of the solution.
    pub flow: &'a Flow,
}

/// Estimates the errors of a solved instant.
///
/// Cost: six dual flows a linkage and a pass over the cells for each. Of a stroke of the default scene, where half of the solves are
/// estimated, it takes half the time (measured on a busy machine).
/// # Errors
/// Dual flows that cannot be solved for.
pub fn estimate(solved: &Solved, duals: &mut Duals) -> Result<Estimate, ModelError> {
    let Solved {
        mesh,
        drive,
        system,
        solution,
        flow,
    } = *solved;
    let space = SurplusSpace::new(mesh)?;
    let own = surplus(&space, mesh, &flow.velocity, &flow.pressure)?;
    let power = flow.forces.dot(&flow.bodies);
    let relative_energy = match own.energy(&own)? / power {
        ratio if ratio.is_finite() => ratio.abs(),
        // Nothing moves, nothing errs.
        _ => 0.0,
    };
    if drive.set.linkages().len() > MOST_LINKAGES {
        return Ok(Estimate {
            frames: None,
            relative_energy,
        });
    }
    let mut residual = vec![0.0; solution.len()];
    system.system.apply(solution, &mut residual);
    residual
        .iter_mut()
        .zip(&system.right)
        .for_each(|(r, b)| *r = b - *r);

    // Whatever solver was asked for: duals need few digits, and this one is the fastest to them.
    let mut preconditioner = system.preconditioner()?;
    let parameters = KrylovParams {
        rel_tol: DUAL_RTOL,
        ..KrylovParams::default()
    };
    let velocities = drive.set.velocity_layout().len();
    let mut errors = FrameErrors::default();
    let mut squares = 0.0;
    let mut number = 0;
    for linkage in 0..drive.set.linkages().len() {
        let (mut by_mesh, mut by_solver) = (Twist::default(), Twist::default());
        for (row, component) in frame_rows(drive, linkage) {
            let mut load = DVector::zeros(velocities);
            load[row] = 1.0;
            let right = system.right_of_loads(&load)?;
            let dual = duals.start(number, right.len());
            number += 1;
            fgmres(
                &system.system,
                &mut preconditioner,
                &right,
                dual,
                &parameters,
            )?;
            let dual = &*dual;
            let (velocity, pressure) = system.flow_of_loads(dual)?;
            let its = surplus(&space, mesh, &velocity, &pressure)?;
            *entry(&mut by_mesh, component) = -its.energy(&own)?;
            *entry(&mut by_solver, component) = if system.system.is_symmetric() {
                -dot(dual, &residual)
            } else {
                // The dual of such a system is another one: a bound by norms.
                dot(dual, dual).sqrt() * dot(&residual, &residual).sqrt()
            };
            if component < 3 {
                let cells = space.indicators(mesh, &its, &own)?;
                squares += dot(&cells, &cells);
            }
        }
        errors.mesh.push(by_mesh);
        errors.algebraic.push(by_solver);
    }
    errors.spread = CELL_TRUST * squares.sqrt();
    Ok(Estimate {
        frames: Some(errors),
        relative_energy,
    })
}

/// The generalised velocities of a linkage's frame, each with its component of the twist.
fn frame_rows(drive: &Drive, number: usize) -> impl Iterator<Item = (usize, usize)> {
    let linkage = &drive.set.linkages()[number];
    let layout = drive.set.velocity_layout();
    let linear = layout.body(linkage.root);
    let angular = layout.frame(number).or_else(|| {
        // A body alone is its own frame; arms in the laboratory's directions do not turn.
        let alone = linkage.bodies.len() == 1;
        (alone && drive.set.kinds()[linkage.root] == BodyKind::Rigid).then_some(linear + 3)
    });
    (0..3).map(move |axis| (linear + axis, axis)).chain(
        angular
            .into_iter()
            .flat_map(|first| (0..3).map(move |axis| (first + axis, 3 + axis))),
    )
}

fn entry(twist: &mut Twist, component: usize) -> &mut f64 {
    match component {
        0..3 => &mut twist.linear[component],
        _ => &mut twist.angular[component - 3],
    }
}

fn surplus(
    space: &SurplusSpace,
    mesh: &TetMesh,
    velocity: &[Vector3<f64>],
    pressure: &[f64],
) -> Result<Surplus, ModelError> {
    let velocity: Vec<f64> = velocity.iter().flat_map(|u| [u.x, u.y, u.z]).collect();
    Ok(space.surplus(mesh, &velocity, pressure)?)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
