//! Errors of an instant by the mesh, from one flow more with the same matrix.
//!
//! A velocity $q_k$ answers to its own load: with the flow `z` of a unit load on it, links held, its error by the mesh is
//! $q_{h,k} - q_k = -K(e_z, e)$ (`fem::SurplusSpace`). That is linear in `z`, so one solve with the functional as its load
//! (`fem::ErrorFunctional`) gives the errors of all velocities. Errors common to equal bodies cancel in it as they do in the
//! velocities; the bound $\sqrt{K(e_z, e_z) K(e, e)}$ would be forty times too wide for a three-sphere swimmer.
//!
//! Straight facets cut off what they stand for, which errs the other way and is a functional of the flow too (`fem::Chords`): with
//! them $K$ is $K - G$ throughout.

use fem::{Chords, Surplus, SurplusSpace};
use linalg::{BlockTriangular, KrylovParams, fgmres_columns};
use mesh::TetMesh;
use nalgebra::{DVector, Vector3};
use rigid::{BodyKind, Constrained, Drive, Flow, Mirrors, Twist};

use crate::model::ModelError;

/// Estimated errors of one instant, in units of the flow, computed less exact.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Of each linkage's frame velocity.
    pub frames: Vec<Twist>,
    /// What the linear part of `frames` may err by itself.
    pub spread: f64,
    /// $K(e, e)$, less `G` where facets are straight, over the power of the bodies: the relative error of their forces, computed less exact.
    pub relative_energy: f64,
    /// What the flow lacks on its mesh, and each cell's share in the spread.
    own: Surplus,
    of_frames: Vec<f64>,
    /// Each cell's share in $G(u, u)$.
    of_chords: Vec<(usize, f64)>,
}

impl Estimate {
    /// Each cell's share in $K(e, e)$, and in the spread: what to refine.
    ///
    /// Cost: a pass over the cells.
    /// # Errors
    /// Another mesh than the one that was estimated on.
    pub fn shares(self, space: &SurplusSpace, mesh: &TetMesh) -> Result<[Vec<f64>; 2], ModelError> {
        let mut own = space.indicators(mesh, &self.own, &self.own)?;
        for (cell, share) in self.of_chords {
            own[cell] = own[cell].abs() + share.abs();
        }
        Ok([own, self.of_frames])
    }
}

/// Residual at which the flows of estimates are good enough, relative: against 1e-6 the estimated error of the default stroke's net
/// displacement changes by 0.2 percent, with 3e-3 by one.
const DUAL_RTOL: f64 = 1e-3;

/// A cell's share in an estimate is trusted to half of itself, independently of the others'. A choice, not a bound: estimated speeds of
/// three-sphere swimmers miss by less, but one leg of the default stroke misses by three times its spread.
const CELL_TRUST: f64 = 0.5;

/// What straight walls take is trusted to half of it: their elements are long, and measured effects of them 0.3 to 0.9 of the estimate.
const WALL_TRUST: f64 = 0.5;

/// Flows of the last estimate, where those of the next start; of other lengths they are not used.
pub type Duals = Vec<Vec<f64>>;

/// The parts of a solved instant that errors are estimated from.
pub struct Solved<'a> {
    /// Mesh of the instant.
    pub mesh: &'a TetMesh,
    /// What its cells lack.
    pub space: &'a SurplusSpace,
    /// What its facets cut off; none where they are curved.
    pub chords: &'a Chords<'a>,
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
    preconditioner: &mut BlockTriangular,
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
    fgmres_columns(system, preconditioner, &rights, &mut flows, &parameters)?;
    Ok(())
}

/// Estimates the errors of a solved instant.
///
/// Cost: six passes over the cells, a loose solve for the errors of all velocities and one a linkage for their spread, all at once.
/// # Errors
/// Flows that cannot be solved for.
pub fn estimate(
    solved: &Solved,
    preconditioner: &mut BlockTriangular,
    flows: &mut Duals,
) -> Result<Estimate, ModelError> {
    let Solved {
        mesh,
        space,
        chords,
        drive,
        system,
        flow,
    } = *solved;
    let velocity = flat(&flow.velocity);
    let own = space.surplus(mesh, &velocity, &flow.pressure)?;
    let power = flow.forces.dot(&flow.bodies);
    // Between mirror planes each cell stands for its images too.
    let parts = Mirrors {
        planes: mesh.mirrors(),
    }
    .parts();
    let cut_off = chords.shares(&velocity, &velocity)?;
    let energy = own.energy(&own)? - cut_off.iter().sum::<f64>();
    let relative_energy = match parts * energy / power {
        ratio if ratio.is_finite() => ratio,
        // Nothing moves, nothing errs.
        _ => 0.0,
    };
    let mut functional = space.functional(mesh, &own)?;
    let cut_off_functional = chords.functional(&velocity)?;
    for (own, cut_off) in functional.velocity.iter_mut().zip(cut_off_functional) {
        *own -= cut_off;
    }
    let mut rights = vec![system.right_of_forces(&functional.velocity, &functional.pressure)?];
    for (number, linkage) in drive.set.linkages().iter().enumerate() {
        // Held still exactly: nothing to err.
        if drive.set.fixed()[linkage.root] {
            continue;
        }
        // The spread is that of the velocity in the direction of motion; bodies at rest may drift along x.
        let (linear, _) = frame_rows(drive, number);
        let motion: Vector3<f64> = flow.generalised.fixed_rows::<3>(linear).into();
        let direction = motion.try_normalize(0.0).unwrap_or_else(Vector3::x);
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
    let mut unsure = 0.0_f64;
    for dual in &flows[1..] {
        let (its_velocity, pressure) = system.flow_of_loads(dual)?;
        let its_velocity = flat(&its_velocity);
        let its = space.surplus(mesh, &its_velocity, &pressure)?;
        let mut cells = space.indicators(mesh, &its, &own)?;
        let of_facets = chords.shares(&its_velocity, &velocity)?;
        let mut by_walls = 0.0;
        for ((cell, is_wall), share) in chords.cells().zip(chords.is_wall()).zip(of_facets) {
            cells[cell] = cells[cell].hypot(share);
            by_walls += if is_wall { share } else { 0.0 };
        }
        unsure = (WALL_TRUST * parts * by_walls).hypot(unsure);
        for (sum, cell) in of_frames.iter_mut().zip(cells) {
            // the root of the sum over its images
            *sum = (parts.sqrt() * cell).hypot(*sum);
        }
    }
    let by_cells = of_frames.iter().map(|cell| cell * cell).sum::<f64>().sqrt();
    Ok(Estimate {
        frames,
        spread: (CELL_TRUST * by_cells).hypot(unsure),
        relative_energy,
        own,
        of_frames,
        of_chords: chords.cells().zip(cut_off).collect(),
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

/// Velocities as the forms take them, three components a node.
pub(super) fn flat(velocity: &[Vector3<f64>]) -> Vec<f64> {
    velocity.iter().flat_map(|u| [u.x, u.y, u.z]).collect()
}
