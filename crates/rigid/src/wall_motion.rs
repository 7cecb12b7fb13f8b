//! Walls that move: the terms of their prescribed velocity in the equations of the fluid.

use nalgebra::{DVector, Vector3};
use rayon::prelude::*;

use crate::{FluidMatrices, FluidNodes, NodeRole, RigidError};

/// Relative size below which a sum is rounding: terms of any sign cancel to 1e-16 of their sizes.
const ROUNDING: f64 = 1e-10;

/// Terms that the velocity `u_W` of the wall nodes adds to the equations of the fluid.
///
/// Test functions vanish on walls. Therefore `∫ 2 D(u):D(v)` and three scalar stiffness matrices
/// differ by the volume term of the bodies only (see [`RigidFluid`](crate::RigidFluid)), for every
/// `u_W`.
#[derive(Clone, Debug)]
pub(crate) struct WallMotion {
    /// `K_IW u_W`: three rows per free node.
    pub momentum: Vec<f64>,
    /// `P^T K_BW u_W`: six rows per body.
    pub loads: DVector<f64>,
    /// `B_W u_W`: one row per pressure dof.
    pub flux: Vec<f64>,
    /// Velocity of each wall node.
    velocity: Vec<(u32, Vector3<f64>)>,
}

impl WallMotion {
    /// The terms of `nodes.wall_velocity`; none if all walls are at rest.
    ///
    /// `arms` are the positions of surface nodes relative to the centre of their body.
    /// Cost: one pass over the stiffness, two over the divergence.
    ///
    /// # Errors
    /// A velocity that is not finite, one that crosses a symmetry plane, and in enclosed flow
    /// velocities with a net flux.
    pub fn new(
        matrices: &FluidMatrices,
        nodes: &FluidNodes,
        free_nodes: &[u32],
        arms: &[Vector3<f64>],
        bodies: usize,
    ) -> Result<Option<Self>, RigidError> {
        let Some(prescribed) = nodes.wall_velocity else {
            return Ok(None);
        };
        let is_wall = |node: usize| nodes.roles[node] == NodeRole::Fixed;
        let velocity: Vec<(u32, Vector3<f64>)> = (0..prescribed.len())
            .filter(|&node| is_wall(node))
            .map(|node| (node as u32, prescribed[node]))
            .collect();
        if velocity
            .iter()
            .any(|(_, u)| !u.iter().all(|c| c.is_finite()))
        {
            return Err(RigidError::NotFinite {
                what: "a wall velocity",
            });
        }
        for &(node, axes) in &nodes.on_symmetry_planes {
            let node = node as usize;
            let normal = (0..3).find(|&axis| axes[axis] && prescribed[node][axis] != 0.0);
            if let Some(axis) = normal.filter(|_| is_wall(node)) {
                return Err(RigidError::AsymmetricWallVelocity {
                    node,
                    normal: prescribed[node][axis],
                });
            }
        }
        let row_sum = |row: usize| -> Vector3<f64> {
            let view = matrices.stiffness.outer_view(row);
            let entries = view.iter().flat_map(|view| view.iter());
            entries
                .filter(|&(column, _)| is_wall(column))
                .map(|(column, &entry)| entry * prescribed[column])
                .sum()
        };
        let momentum: Vec<Vector3<f64>> = free_nodes
            .par_iter()
            .map(|&node| row_sum(node as usize))
            .collect();
        let mut loads = DVector::zeros(6 * bodies);
        for (node, role) in nodes.roles.iter().enumerate() {
            if let NodeRole::Body(body) = role {
                let (force, first) = (row_sum(node), 6 * *body as usize);
                let mut force_rows = loads.fixed_rows_mut::<3>(first);
                force_rows += force;
                let mut torque_rows = loads.fixed_rows_mut::<3>(first + 3);
                torque_rows += arms[node].cross(&force);
            }
        }
        let (mut flux, mut size) = (Vec::with_capacity(matrices.divergence.rows()), 0.0);
        for row in matrices.divergence.outer_iterator() {
            let mut sum = 0.0;
            for (column, &entry) in row.iter().filter(|&(column, _)| is_wall(column)) {
                let term = Vector3::from(entry).dot(&prescribed[column]);
                sum += term;
                size += term.abs();
            }
            flux.push(sum);
        }
        let net: f64 = flux.iter().sum();
        if net.abs() > ROUNDING * size && is_enclosed(matrices, nodes) {
            return Err(RigidError::NetWallFlux {
                flux: net,
                relative: net.abs() / size,
            });
        }
        Ok(Some(Self {
            momentum: momentum.iter().flat_map(|m| [m.x, m.y, m.z]).collect(),
            loads,
            flux,
            velocity,
        }))
    }

    /// Writes the velocities of the wall nodes into a field over all nodes.
    pub fn write_velocity(&self, field: &mut [Vector3<f64>]) {
        for &(node, velocity) in &self.velocity {
            field[node as usize] = velocity;
        }
    }
}

/// Whether no free velocity has a net flux, so that the constant pressure is undetermined.
fn is_enclosed(matrices: &FluidMatrices, nodes: &FluidNodes) -> bool {
    let zero = [Vector3::<f64>::zeros(); 2];
    let mut sums = vec![zero; nodes.roles.len()];
    for row in matrices.divergence.outer_iterator() {
        for (column, &entry) in row.iter() {
            let entry = Vector3::from(entry);
            sums[column][0] += entry;
            sums[column][1] += entry.abs();
        }
    }
    for &(node, axes) in &nodes.on_symmetry_planes {
        for axis in (0..3).filter(|&axis| axes[axis]) {
            sums[node as usize][0][axis] = 0.0;
        }
    }
    let free = sums.iter().zip(nodes.roles);
    free.filter(|(_, role)| **role == NodeRole::Free)
        .all(|([sum, size], _)| (0..3).all(|axis| sum[axis].abs() <= ROUNDING * size[axis]))
}
