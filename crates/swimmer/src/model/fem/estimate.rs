//! Errors of an instant by the mesh, from one flow more with the same matrix.
//!
//! A velocity $q_k$ answers to its own load: with the flow `z` of a unit load on it, links held, its error by the mesh is
//! $q_{h,k} - q_k = -K(e_z, e)$ (`fem::SurplusSpace`). That is linear in `z`, so one solve with the functional as its load
//! (`fem::ErrorFunctional`) gives the errors of all velocities. Errors common to equal bodies cancel in it as they do in the
//! velocities; the bound $\sqrt{K(e_z, e_z) K(e, e)}$ would be forty times too wide for a three-sphere swimmer.

use fem::{Surplus, SurplusSpace};
use linalg::{BlockTriangular, KrylovParams, fgmres_columns};
use mesh::TetMesh;
use nalgebra::{DVector, Vector3};
use rigid::{BodyKind, Constrained, Drive, Flow, Twist};

use crate::model::ModelError;

/// Estimated errors of one instant, in units of the flow, computed less exact.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Of each linkage's frame velocity.
    pub frames: Vec<Twist>,
    /// What the linear part of `frames` may err by itself.
    pub spread: f64,
    /// $K(e, e)$ over the power of the bodies: the relative error of their forces, computed less exact.
    pub relative_energy: f64,
    /// What the flow lacks on its mesh, and each cell's share in the spread.
    own: Surplus,
    of_frames: Vec<f64>,
}

impl Estimate {
    /// Each cell's share in $K(e, e)$, and in the spread: what to refine.
    ///
    /// Cost: a pass over the cells.
    /// # Errors
    /// Another mesh than the one that was estimated on.
    pub fn shares(self, space: &SurplusSpace, mesh: &TetMesh) -> Result<[Vec<f64>; 2], ModelError> {
        let own = space.indicators(mesh, &self.own, &self.own)?;
        Ok([own, self.of_frames])
    }
}

/// Residual at which the flows of estimates are good enough, relative: against 1e-6 the estimated error of the default stroke's net
/// displacement changes by 0.2 percent, with 3e-3 by one.
const DUAL_RTOL: f64 = 1e-3;

/// A cell's share in an estimate is trusted to half of itself, independently of the others'. A choice, not a bound: estimated speeds of
/// three-sphere swimmers miss by less, but one leg of the default stroke misses by three times its spread.
const CELL_TRUST: f64 = 0.5;

/// Flows of the last estimate, where those of the next start; of other lengths they are not used.
pub type Duals = Vec<Vec<f64>>;

/// The parts of a solved instant that errors are estimated from.
pub struct Solved<'a> {
    /// Mesh of the instant.
    pub mesh: &'a TetMesh,
    /// What its cells lack.
    pub space: &'a SurplusSpace,
    /// What drove it.
    pub drive: &'a Drive<'a>,
    /// Its system.
    pub system: &'a Constrained,
    /// The flow of the solution.
    pub flow: &'a Flow,
}

/// Solves for the flows of an estimate, each from that of the instant before.
fn solve_duals(
    system: &Constrained,
    mut preconditioner: BlockTriangular,
    rights: &[Vec<f64>],
    flows: &mut Duals,
) -> Result<(), ModelError> {
    flows.resize(rights.len(), Vec::new());
    for (flow, right) in flows.iter_mut().zip(rights) {
        if flow.len() != right.len() {
            *flow = vec![0.0; right.len()];
        }
    }
    let parameters = KrylovParams {
        rel_tol: DUAL_RTOL,
        ..KrylovParams::default()
    };
    let rights: Vec<&[f64]> = rights.iter().map(Vec::as_slice).collect();
    let mut flows: Vec<_> = flows.iter_mut().map(Vec::as_mut_slice).collect();
    let system = &system.system;
    fgmres_columns(
        system,
        &mut preconditioner,
        &rights,
        &mut flows,
        &parameters,
    )?;
    Ok(())
}

/// Estimates the errors of a solved instant.
///
/// Cost: six passes over the cells, a loose solve for the errors of all velocities and one a linkage for their spread, all at once.
/// # Errors
/// Flows that cannot be solved for.
pub fn estimate<'a>(
    solved: &Solved<'a>,
    preconditioner: BlockTriangular<'a>,
    flows: &mut Duals,
) -> Result<Estimate, ModelError> {
    let Solved {
        mesh,
        space,
        drive,
        system,
        flow,
    } = *solved;
    let own = surplus(space, mesh, &flow.velocity, &flow.pressure)?;
    let power = flow.forces.dot(&flow.bodies);
    let relative_energy = match own.energy(&own)? / power {
        ratio if ratio.is_finite() => ratio,
        // Nothing moves, nothing errs.
        _ => 0.0,
    };
    let functional = space.functional(mesh, &own)?;
    let mut rights = vec![system.right_of_forces(&functional.velocity, &functional.pressure)?];
    for (number, linkage) in drive.set.linkages().iter().enumerate() {
        // Held still exactly: nothing to err.
        if drive.set.fixed()[linkage.root] {
            continue;
        }
        // The spread is that of the velocity in the direction of motion; bodies at rest may drift along x.
        let (linear, _) = frame_rows(drive, number);
        let velocity: Vector3<f64> = flow.generalised.fixed_rows::<3>(linear).into();
        let direction = velocity.try_normalize(0.0).unwrap_or_else(Vector3::x);
        let mut load = DVector::zeros(drive.set.velocity_layout().len());
        load.fixed_rows_mut::<3>(linear).copy_from(&direction);
        rights.push(system.right_of_loads(&load)?);
    }
    solve_duals(system, preconditioner, &rights, flows)?;
    let errors = -system.generalised_of_loads(&flows[0])?;

    let mut frames = Vec::new();
    for number in 0..drive.set.linkages().len() {
        let (linear, angular) = frame_rows(drive, number);
        let twist = |first: Option<usize>| {
            first.map_or_else(Vector3::zeros, |row| errors.fixed_rows::<3>(row).into())
        };
        frames.push(Twist {
            linear: twist(Some(linear)),
            angular: twist(angular),
        });
    }
    let mut of_frames = vec![0.0; mesh.n_cells()];
    for dual in &flows[1..] {
        let (velocity, pressure) = system.flow_of_loads(dual)?;
        let its = surplus(space, mesh, &velocity, &pressure)?;
        let cells = space.indicators(mesh, &its, &own)?;
        for (sum, cell) in of_frames.iter_mut().zip(cells) {
            *sum = cell.hypot(*sum);
        }
    }
    Ok(Estimate {
        frames,
        spread: CELL_TRUST * of_frames.iter().map(|cell| cell * cell).sum::<f64>().sqrt(),
        relative_energy,
        own,
        of_frames,
    })
}

/// Where the generalised velocities of a linkage's frame begin: linear ones, and angular ones if it turns.
fn frame_rows(drive: &Drive, number: usize) -> (usize, Option<usize>) {
    let linkage = &drive.set.linkages()[number];
    let layout = drive.set.velocity_layout();
    let linear = layout.body(linkage.root);
    let angular = layout.frame(number).or_else(|| {
        // A body alone is its own frame; arms in the laboratory's directions do not turn.
        let alone = linkage.bodies.len() == 1;
        (alone && drive.set.kinds()[linkage.root] == BodyKind::Rigid).then_some(linear + 3)
    });
    (linear, angular)
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
