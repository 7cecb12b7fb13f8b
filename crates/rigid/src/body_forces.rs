//! Rigid surfaces in the fluid: velocities of all nodes, and the forces of bodies on the fluid.

use std::ops::AddAssign;

use linalg::Csr;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::mesh_part::Ownership;
use crate::prescribed_motion::PrescribedMotion;
use crate::stresslets::SurfaceRows;
use crate::{MeshPart, NodeRole, RigidError, SurfaceBody, SymmetryPlanes};

/// Largest distance of a body from the centre of its surface, over the size of the body.
///
/// It changes velocities by about this fraction, less than any mesh resolves. Positions in meshes
/// differ by rounding, 1e-12 body sizes at a distance of ten thousand.
const MAX_MISPLACEMENT: f64 = 1e-6;

/// The couplings between free nodes and rigid surfaces, and the map from dofs to nodal values.
///
/// Columns and rows of bodies are `(U, ω)` and `(F, T)`, six per body.
#[derive(Clone, Debug)]
pub(crate) struct Surfaces {
    /// `K_IB P`: three rows per free node.
    pub border: Csr,
    /// `(K^T)_IB P`, by which forces are computed, if the stiffness is not symmetric.
    pub border_left: Option<Csr>,
    /// `P^T K_BB P` with the volume term.
    pub corner: DMatrix<f64>,
    /// Factor of the divergence in all blocks: the pressures of the system times it are those of
    /// the flow. 1 without inertia.
    pub pressure_scale: f64,
    /// `B_B P`: one row per pressure dof.
    pub rigid_divergence: Csr,
    /// Node number of each free node, in the order of the dofs.
    pub free_nodes: Vec<u32>,
    /// Free nodes on symmetry planes, by their index among the free nodes, with the components
    /// that are zero there.
    pub constrained: Vec<(u32, [bool; 3])>,
    /// The symmetry planes of the mesh.
    pub symmetry_planes: SymmetryPlanes,
    /// Terms of the prescribed velocities of walls and surfaces; none if all of them are zero.
    pub prescribed: Option<PrescribedMotion>,
    /// Role of each node.
    pub roles: Vec<NodeRole>,
    /// The part of this process if the mesh is divided between processes.
    pub part: Option<MeshPart>,
    /// Reference point and volume of each body.
    pub bodies: Vec<SurfaceBody>,
    /// Position of each surface node relative to the centre of its body; zero for other nodes.
    pub arms: Vec<Vector3<f64>>,
    /// Momentum equation at the surface nodes.
    pub rows: SurfaceRows,
}

impl Surfaces {
    /// Refuses a fluid in which some velocity is undetermined.
    ///
    /// A Krylov method would not detect it: the right-hand side of a force-free swimmer is
    /// compatible.
    ///
    /// # Errors
    /// [`RigidError::NoWall`], [`RigidError::NoSurface`].
    pub fn check_determined(&self) -> Result<(), RigidError> {
        let bodies = (0..self.bodies()).map(|body| NodeRole::Body(body as u32));
        let mut counts: Vec<f64> = [NodeRole::Fixed]
            .into_iter()
            .chain(bodies)
            .map(|role| f64::from(u8::from(self.roles.contains(&role))))
            .collect();
        self.part.sum(&mut counts);
        // NaN, from a sum that failed, counts as none.
        let is_bare = |count: &f64| count.is_nan() || *count == 0.0;
        if is_bare(&counts[0]) {
            return Err(RigidError::NoWall);
        }
        match counts[1..].iter().position(is_bare) {
            Some(body) => Err(RigidError::NoSurface { body }),
            None => Ok(()),
        }
    }

    /// Refuses surfaces that are not where the bodies are.
    ///
    /// # Errors
    /// [`RigidError::Misplaced`] names the first such body.
    pub fn check_positions(&self, positions: &[Vector3<f64>]) -> Result<(), RigidError> {
        let parts = self.symmetry_planes.parts();
        for (body, (surface, position)) in self.bodies.iter().zip(positions).enumerate() {
            let distance = (surface.centre - position).norm();
            let size = (parts * surface.volume).cbrt();
            if distance.is_nan() || distance > MAX_MISPLACEMENT * size {
                return Err(RigidError::Misplaced { body, distance });
            }
        }
        Ok(())
    }

    /// Number of rigid bodies with a surface.
    pub fn bodies(&self) -> usize {
        self.bodies.len()
    }

    /// Number of nodes of the mesh.
    pub fn nodes(&self) -> usize {
        self.roles.len()
    }

    /// Zeroes the velocity components that symmetry planes prescribe, three rows per free node.
    pub fn zero_constrained(&self, velocity: &mut [f64]) {
        for (node, planes) in &self.constrained {
            for axis in (0..3).filter(|&axis| planes[axis]) {
                velocity[3 * *node as usize + axis] = 0.0;
            }
        }
    }

    /// Forces and torques `(F, T)` on the bodies from forces on all nodes.
    pub fn loads_of_forces(&self, forces: &[Vector3<f64>]) -> DVector<f64> {
        let mut loads = DVector::zeros(6 * self.bodies());
        let nodes = self.roles.iter().zip(&self.arms).enumerate();
        for ((node, (role, arm)), force) in nodes.zip(forces) {
            if let NodeRole::Body(body) = role
                && self.part.owns(node)
            {
                let first = 6 * *body as usize;
                let mut own = loads.fixed_rows_mut::<6>(first);
                own.fixed_rows_mut::<3>(0).add_assign(force);
                own.fixed_rows_mut::<3>(3).add_assign(&arm.cross(force));
            }
        }
        self.part.sum(loads.as_mut_slice());
        loads
    }

    /// Velocities of all nodes, prescribed velocities zero, from those of free nodes (interleaved)
    /// and bodies.
    pub fn all_velocities(&self, free: &[f64], bodies: &DVector<f64>) -> Vec<Vector3<f64>> {
        let mut velocity: Vec<Vector3<f64>> = self
            .roles
            .iter()
            .zip(&self.arms)
            .map(|(role, arm)| match role {
                NodeRole::Body(body) => {
                    let first = 6 * *body as usize;
                    let angular = bodies.fixed_rows::<3>(first + 3).into_owned();
                    bodies.fixed_rows::<3>(first) + angular.cross(arm)
                }
                _ => Vector3::zeros(),
            })
            .collect();
        for (&node, value) in self.free_nodes.iter().zip(free.chunks_exact(3)) {
            velocity[node as usize] = Vector3::from_column_slice(value);
        }
        velocity
    }

    /// Velocities of all nodes, with the prescribed velocities of walls and surfaces.
    ///
    /// Arguments as in [`all_velocities`](Self::all_velocities).
    pub fn with_prescribed(&self, free: &[f64], bodies: &DVector<f64>) -> Vec<Vector3<f64>> {
        let mut velocity = self.all_velocities(free, bodies);
        if let Some(prescribed) = &self.prescribed {
            prescribed.add_velocity(&mut velocity);
        }
        velocity
    }

    /// Consistent forces and torques `(F, T)` that the bodies exert on the fluid, six per body.
    ///
    /// The residual of the momentum equation tested with rigid motions,
    /// `F = (K_IB P)^T u_I + M U + (B_B P)^T p` and the terms of prescribed velocities, `M` the
    /// corner, minus `on_nodes`, the forces on the nodes that drive the flow (none if empty).
    /// Fourth order on curved quadratic surfaces, because it is the energy of the flow. Where
    /// symmetry planes cut bodies, these are the forces on the whole bodies.
    pub fn forces(
        &self,
        free: &[f64],
        bodies: &DVector<f64>,
        pressure: &[f64],
        on_nodes: &[Vector3<f64>],
    ) -> DVector<f64> {
        let mut forces = self.residuals(free, bodies, pressure);
        if let Some(prescribed) = &self.prescribed {
            forces += &prescribed.loads;
        }
        if !on_nodes.is_empty() {
            forces -= self.loads_of_forces(on_nodes);
        }
        self.symmetry_planes.whole(forces)
    }

    /// Stresslets of the bodies, from the velocities of all nodes, the pressure and the forces on
    /// the nodes that drive the flow, none if empty.
    pub fn stresslets(
        &self,
        velocity: &[Vector3<f64>],
        pressure: &[f64],
        on_nodes: &[Vector3<f64>],
    ) -> Vec<Matrix3<f64>> {
        let forces = (!on_nodes.is_empty()).then_some(on_nodes);
        (self.rows).stresslets(&self.arms, velocity, pressure, forces)
    }

    /// Change of [`Surfaces::stresslets`] by a flow that `forces` on the nodes drive.
    pub fn change_of_stresslets(
        &self,
        velocity: &[Vector3<f64>],
        pressure: &[f64],
        forces: &[Vector3<f64>],
    ) -> Vec<Matrix3<f64>> {
        self.rows.change(&self.arms, velocity, pressure, forces)
    }

    /// Change of [`Surfaces::forces`] by a flow that `forces` on the nodes drive, walls at rest.
    pub fn change_of_forces(
        &self,
        free: &[f64],
        bodies: &DVector<f64>,
        pressure: &[f64],
        forces: &[Vector3<f64>],
    ) -> DVector<f64> {
        let residuals = self.residuals(free, bodies, pressure) - self.loads_of_forces(forces);
        self.symmetry_planes.whole(residuals)
    }

    /// Residual of the momentum equation tested with rigid motions, walls at rest.
    fn residuals(&self, free: &[f64], bodies: &DVector<f64>, pressure: &[f64]) -> DVector<f64> {
        let add_fluid = |residuals: &mut DVector<f64>| {
            let rows = self.border_left.as_ref().unwrap_or(&self.border);
            add_transposed(rows, free, residuals);
            add_transposed(&self.rigid_divergence, pressure, residuals);
        };
        let mut residuals = &self.corner * bodies;
        if self.part.is_none() {
            add_fluid(&mut residuals);
        } else {
            let mut of_fluid = DVector::zeros(residuals.len());
            add_fluid(&mut of_fluid);
            self.part.sum(of_fluid.as_mut_slice());
            residuals += of_fluid;
        }
        residuals
    }
}

/// `y += A^T x` for a matrix with few columns; serial, so that the order of the sum is fixed.
fn add_transposed(matrix: &Csr, x: &[f64], y: &mut DVector<f64>) {
    for (row, &value) in matrix.outer_iterator().zip(x) {
        for (column, &entry) in row.iter() {
            y[column] += entry * value;
        }
    }
}
