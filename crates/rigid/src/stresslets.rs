//! Stresslets of bodies, from the residual of the momentum equation at the nodes of their surfaces.

use linalg::{Csr, Csr3, OMITTED, submatrix};
use nalgebra::{Matrix3, Vector3};

use crate::mesh_part::Ownership;
use crate::{FluidMatrices, FluidNodes, MeshPart, NodeRole, RigidError, SymmetryPlanes};

/// The rows of the momentum equation at the nodes of bodies.
///
/// The stresslet of a body is the symmetric part, without trace, of the first moment of the
/// traction `σ n` of the fluid on the body, with the normal `n` out of the body and positions `x`
/// relative to its centre, without the strain of the surface (Batchelor 1970; Kim & Karrila
/// 1991, chapter 2):
///
/// ```text
/// S = ∮ [(σ n) x^T + x (σ n)^T] / 2 - I (x · σ n) / 3 - μ (u n^T + n u^T) dS
/// ```
///
/// The nodal residuals `r = K u + B^T p` are the forces of a body on the fluid up to the terms by
/// which `∫ ∇u:∇v` differs from `∫ 2 D(u):D(v)`. For test functions `v = G x` on the surface with a
/// symmetric `G` of zero trace, the divergence theorem on the surface gives
///
/// ```text
/// ∫ 2 D(u):D(v) - p ∇·v = ∫ ∇u:∇v - p ∇·v - ∮ u · G n dS
/// ```
///
/// for divergence-free flows, so that `S` is minus the symmetric part, without trace, of
/// `sum_b r_b x_b^T + ∮ u n^T dS`. A rigid motion has no part in the integral. Functions `G x` are
/// in the space of isoparametric elements, so that stresslets converge with order 4, as forces do
/// (`docs/decisions.md`).
#[derive(Clone, Debug)]
pub(crate) struct SurfaceRows {
    /// Node and body of the rows, ascending.
    nodes: Vec<(u32, u32)>,
    /// Stiffness, body nodes x nodes; rows of nodes of other processes are not used.
    stiffness: Csr,
    /// Divergence, pressure dofs x body nodes.
    divergence: Csr3,
    /// `∮ s n^T dS` of each body; empty if all surfaces are rigid.
    surface_moments: Vec<Matrix3<f64>>,
    /// The part of this process if the mesh is divided between processes.
    part: Option<MeshPart>,
    symmetry_planes: SymmetryPlanes,
    bodies: usize,
}

impl SurfaceRows {
    /// The rows of the nodes on bodies. Cost: one pass over the divergence.
    ///
    /// # Errors
    /// Matrices that do not fit the nodes.
    pub fn new(
        matrices: &FluidMatrices,
        nodes: &FluidNodes,
        bodies: usize,
    ) -> Result<Self, RigidError> {
        let on_bodies: Vec<(u32, u32)> = (nodes.roles.iter().enumerate())
            .filter_map(|(node, role)| match role {
                NodeRole::Body(body) => Some((node as u32, *body)),
                _ => None,
            })
            .collect();
        let rows: Vec<u32> = on_bodies.iter().map(|(node, _)| *node).collect();
        let mut number_on_bodies = vec![OMITTED; nodes.roles.len()];
        for (number, node) in (0..).zip(&rows) {
            number_on_bodies[*node as usize] = number;
        }
        let all_nodes: Vec<u32> = (0..nodes.roles.len() as u32).collect();
        let all_pressures: Vec<u32> = (0..matrices.divergence.rows() as u32).collect();
        Ok(Self {
            stiffness: submatrix(&matrices.stiffness, &rows, &all_nodes, all_nodes.len())?,
            divergence: submatrix(
                &matrices.divergence,
                &all_pressures,
                &number_on_bodies,
                rows.len(),
            )?,
            nodes: on_bodies,
            surface_moments: nodes.surface_moments.to_vec(),
            part: nodes.part.clone(),
            symmetry_planes: nodes.symmetry(),
            bodies,
        })
    }

    /// Stresslets of a flow with these velocities of all nodes, with prescribed surface velocities.
    ///
    /// `arms` are the positions of surface nodes relative to the centre of their body, `forces`
    /// drive the flow at all nodes.
    pub fn stresslets(
        &self,
        arms: &[Vector3<f64>],
        velocity: &[Vector3<f64>],
        pressure: &[f64],
        forces: Option<&[Vector3<f64>]>,
    ) -> Vec<Matrix3<f64>> {
        let mut moments = self.moments_of_residuals(arms, velocity, pressure, forces);
        for (moment, of_surface) in moments.iter_mut().zip(&self.surface_moments) {
            *moment += of_surface;
        }
        self.of_moments(moments)
    }

    /// Change of [`SurfaceRows::stresslets`] by a flow that `forces` on the nodes drive, with
    /// surfaces that move rigidly and walls at rest.
    pub fn change(
        &self,
        arms: &[Vector3<f64>],
        velocity: &[Vector3<f64>],
        pressure: &[f64],
        forces: &[Vector3<f64>],
    ) -> Vec<Matrix3<f64>> {
        let moments = self.moments_of_residuals(arms, velocity, pressure, Some(forces));
        self.of_moments(moments)
    }

    /// `sum_b r_b x_b^T` of each body, with the residuals `r = K u + B^T p - f` of its nodes.
    fn moments_of_residuals(
        &self,
        arms: &[Vector3<f64>],
        velocity: &[Vector3<f64>],
        pressure: &[f64],
        forces: Option<&[Vector3<f64>]>,
    ) -> Vec<Matrix3<f64>> {
        let mut residuals = vec![Vector3::zeros(); self.nodes.len()];
        let rows = self.stiffness.outer_iterator().zip(&self.nodes);
        for (residual, (row, (node, _))) in residuals.iter_mut().zip(rows) {
            if self.part.owns(*node as usize) {
                *residual = row.iter().map(|(column, &k)| k * velocity[column]).sum();
                if let Some(forces) = forces {
                    *residual -= forces[*node as usize];
                }
            }
        }
        let rows = self.divergence.outer_iterator().zip(pressure).enumerate();
        for (vertex, (row, pressure)) in rows {
            if self.part.owns(vertex) {
                for (number, b) in row.iter() {
                    residuals[number] += Vector3::from(*b) * *pressure;
                }
            }
        }
        let mut moments = vec![Matrix3::zeros(); self.bodies];
        for (&(node, body), residual) in self.nodes.iter().zip(&residuals) {
            moments[body as usize] += residual * arms[node as usize].transpose();
        }
        let mut numbers: Vec<f64> = moments.iter().flatten().copied().collect();
        self.part.sum(&mut numbers);
        let all = numbers.chunks_exact(9);
        all.map(Matrix3::from_column_slice).collect()
    }

    /// Minus the symmetric part of the moments of whole bodies, without trace.
    fn of_moments(&self, moments: Vec<Matrix3<f64>>) -> Vec<Matrix3<f64>> {
        let stresslet = |moment: Matrix3<f64>| {
            let symmetric = (moment + moment.transpose()) * -0.5;
            let whole = self.symmetry_planes.whole_tensor(&symmetric);
            whole - Matrix3::identity() * (whole.trace() / 3.0)
        };
        moments.into_iter().map(stresslet).collect()
    }
}
