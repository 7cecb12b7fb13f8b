//! Prescribed velocities of walls, and of surfaces relative to their bodies: their terms in the
//! equations of the fluid.

use nalgebra::{DVector, Vector3};
use rayon::prelude::*;

use crate::error::check_finite;
use crate::mesh_part::Ownership;
use crate::{FluidMatrices, FluidNodes, NodeRole, RigidError};

/// Relative net flux below which it is rounding: terms of any sign cancel to 1e-16 of their sizes.
const MAX_NET_FLUX: f64 = 1e-10;

/// Terms that prescribed velocities `s` add to the equations of the fluid.
///
/// `s` is the velocity of the wall nodes, and that of surface nodes relative to the rigid motion of
/// their body. For test functions `v` that vanish on walls and are rigid on bodies, `V + W × r`,
/// the divergence theorem on the surface gives
///
/// ```text
/// ∫ 2 D(u):D(v) = ∫ ∇u:∇v + ∫ (∇·u) (∇·v) + sum_bodies W · ∮ n × u dS
/// ```
///
/// with the normal `n` out of the body. The rigid part of `u` gives the volume term (see
/// [`RigidFluid`](crate::RigidFluid)), `s` gives the torque `∮ n × s dS`. Forces and the terms of
/// walls need no correction.
#[derive(Clone, Debug)]
pub(crate) struct PrescribedMotion {
    /// `K_IS s`: three rows per free node.
    pub momentum: Vec<f64>,
    /// `P^T K_BS s` and the torques `∮ n × s dS`: six rows per body.
    pub loads: DVector<f64>,
    /// `B_S s`: one row per pressure dof.
    pub flux: Vec<f64>,
    /// Velocity of each node where it is prescribed.
    velocity: Vec<(u32, Vector3<f64>)>,
}

impl PrescribedMotion {
    /// The terms of `nodes.wall_velocity` and `nodes.surface_velocity`; none without both.
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
        if nodes.wall_velocity.is_none() && nodes.surface_velocity.is_none() {
            return Ok(None);
        }
        let of_role = |role: &NodeRole| match role {
            NodeRole::Free => None,
            NodeRole::Fixed => nodes.wall_velocity,
            NodeRole::Body(_) => nodes.surface_velocity,
        };
        let values = nodes.roles.iter().map(of_role).enumerate();
        let prescribed: Vec<Option<Vector3<f64>>> = values
            .map(|(node, velocity)| velocity.map(|velocity| velocity[node]))
            .collect();
        let velocity: Vec<(u32, Vector3<f64>)> = (prescribed.iter().enumerate())
            .filter_map(|(node, velocity)| Some((node as u32, (*velocity)?)))
            .collect();
        let components = velocity.iter().flat_map(|(_, velocity)| velocity);
        check_finite("a prescribed velocity of a wall or a surface", components)?;
        check_symmetry(nodes, &prescribed)?;
        let row_sum = |row: usize| -> Vector3<f64> {
            let view = matrices.stiffness.outer_view(row);
            let entries = view.iter().flat_map(|view| view.iter());
            entries
                .filter_map(|(column, &entry)| Some(entry * prescribed[column]?))
                .sum()
        };
        let momentum: Vec<Vector3<f64>> = free_nodes
            .par_iter()
            .map(|&node| row_sum(node as usize))
            .collect();
        let mut loads = DVector::zeros(6 * bodies);
        for (node, role) in nodes.roles.iter().enumerate() {
            if let (NodeRole::Body(body), true) = (role, nodes.part.owns(node)) {
                let (force, first) = (row_sum(node), 6 * *body as usize);
                let mut force_rows = loads.fixed_rows_mut::<3>(first);
                force_rows += force;
                let mut torque_rows = loads.fixed_rows_mut::<3>(first + 3);
                torque_rows += arms[node].cross(&force);
            }
        }
        nodes.part.sum(loads.as_mut_slice());
        for (body, moment) in nodes.surface_moments.iter().enumerate() {
            let mut torque_rows = loads.fixed_rows_mut::<3>(6 * body + 3);
            // n × s, from s n^T
            let m = |i: usize, j: usize| moment[(i, j)] - moment[(j, i)];
            torque_rows += Vector3::new(m(2, 1), m(0, 2), m(1, 0));
        }
        Ok(Some(Self {
            momentum: momentum.iter().flat_map(|m| [m.x, m.y, m.z]).collect(),
            loads,
            flux: fluxes(matrices, nodes, &prescribed)?,
            velocity,
        }))
    }

    /// Adds the prescribed velocities to a field over all nodes, in which walls are at rest.
    pub fn add_velocity(&self, field: &mut [Vector3<f64>]) {
        for &(node, velocity) in &self.velocity {
            field[node as usize] += velocity;
        }
    }
}

/// Refuses velocities that cross a symmetry plane.
fn check_symmetry(
    nodes: &FluidNodes,
    prescribed: &[Option<Vector3<f64>>],
) -> Result<(), RigidError> {
    for &(node, axes) in &nodes.on_symmetry_planes {
        let node = node as usize;
        let Some(velocity) = prescribed[node] else {
            continue;
        };
        if let Some(axis) = (0..3).find(|&axis| axes[axis] && velocity[axis] != 0.0) {
            return Err(RigidError::AsymmetricWallVelocity {
                node,
                normal: velocity[axis],
            });
        }
    }
    Ok(())
}

/// `B_S s` of prescribed velocities `s`; refuses a net flux in enclosed flow.
fn fluxes(
    matrices: &FluidMatrices,
    nodes: &FluidNodes,
    prescribed: &[Option<Vector3<f64>>],
) -> Result<Vec<f64>, RigidError> {
    let mut fluxes = Vec::with_capacity(matrices.divergence.rows());
    let (mut net, mut size) = (0.0, 0.0);
    for (vertex, row) in matrices.divergence.outer_iterator().enumerate() {
        let (mut sum, mut absolute) = (0.0, 0.0);
        for (column, &entry) in row.iter() {
            let Some(velocity) = prescribed[column] else {
                continue;
            };
            let term = Vector3::from(entry).dot(&velocity);
            sum += term;
            absolute += term.abs();
        }
        if nodes.part.owns(vertex) {
            net += sum;
            size += absolute;
        }
        fluxes.push(sum);
    }
    let mut sums = [net, size];
    nodes.part.sum(&mut sums);
    let [net, size]: [f64; 2] = sums;
    if net.abs() > MAX_NET_FLUX * size && is_enclosed(matrices, nodes) {
        return Err(RigidError::NetWallFlux {
            flux: net,
            relative: net.abs() / size,
        });
    }
    Ok(fluxes)
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
    let free = sums.iter().zip(nodes.roles).enumerate();
    let open = free
        .filter(|(node, (_, role))| **role == NodeRole::Free && nodes.part.owns(*node))
        .filter(|(_, ([sum, size], _))| (0..3).any(|d| sum[d].abs() > MAX_NET_FLUX * size[d]));
    let mut open = [open.count() as f64];
    nodes.part.sum(&mut open);
    open == [0.0]
}
