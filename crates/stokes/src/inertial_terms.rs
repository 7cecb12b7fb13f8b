//! Terms of inertia in the momentum equation, with their matrices and forces.

use fem::{PointValues, StokesMatrices, TaylorHood};
use mesh::TetMesh;
use nalgebra::Vector3;
use rheology::ViscosityLaw;
use rigid::Inertia;

use crate::StokesError;

/// Terms of inertia in the momentum equation, with known velocities, at viscosity 1 or by a law.
///
/// ```text
/// κ u + ρ ((c · ∇) u + (∇·d) u / 2) - Δu + ∇p = g,   ∇·u = 0
/// ```
///
/// For a step in time, `κ = ρ c_0 / Δt` with the coefficient `c_0` of the new velocity in its
/// derivative, and `g = -ρ (c_1 u_1 + c_2 u_2) / Δt` has the earlier velocities, as nodal values on
/// the new mesh. For a steady flow both are zero. With a law the stress is `2 η(g) D(u)` in place
/// of `∇u`. Masses of bodies enter by the drive:
/// [`body_damping`](rigid::Constraints::body_damping) and loads.
#[derive(Clone, Copy, Debug, Default)]
pub struct InertialTerms<'a> {
    /// Density of the fluid `ρ`.
    pub density: f64,
    /// Coefficient `κ` of the velocity.
    pub coefficient: f64,
    /// Force per volume `g` at each node.
    pub force: Option<&'a [Vector3<f64>]>,
    /// Integrated forces `∫ N_i g` at each node, in addition to `force`.
    pub load: Option<&'a [Vector3<f64>]>,
    /// Velocity `c` relative to the mesh at each node; without it the equation is linear.
    pub convecting: Option<&'a [Vector3<f64>]>,
    /// Velocity `d` of the fluid at each node, in addition to a convecting velocity: convection is
    /// then `ρ ((c · ∇) u + (∇·d) u / 2)`.
    ///
    /// It is `c` plus the velocity of the mesh, or `c` alone where the mesh moves uniformly. This
    /// is the skew-symmetric form (Temam 1968): the divergence that a discrete flow has then
    /// neither produces energy nor makes a diagonal entry of the matrix negative.
    pub divergence_of: Option<&'a [Vector3<f64>]>,
    /// Viscosity law in place of viscosity 1.
    pub law: Option<&'a dyn ViscosityLaw>,
    /// A velocity near that of the flow, at which the equations of a law are linearised first; at
    /// rest without one.
    pub near: Option<&'a [Vector3<f64>]>,
    /// Velocity of the walls, one per node, of which those on walls are used; none if at rest.
    pub wall_velocity: Option<&'a [Vector3<f64>]>,
}

/// Diffusion of the pressures along the convecting velocity `c`, over `|c| h` with the length `h`
/// of the cell along it.
///
/// FGMRES iterations to 1e-8 for a fixed sphere in a ball of ten radii, 1751 nodes, with parts of
/// 0, 0.1, 0.2, 0.25, 0.3, 0.4 and 0.5: 40, 28, 25, 25, 26, 29 and 32 at a Reynolds number of 10,
/// and 129, 63, 47, 42, 41, 46 and 44 at 50.
const STREAMLINE_PART: f64 = 0.3;

impl InertialTerms<'_> {
    /// The matrices of inertia of a space, whose matrices of viscosity 1 are given, and the forces
    /// `∫ N_i g` on the nodes.
    pub(crate) fn assemble(
        &self,
        space: &TaylorHood,
        mesh: &TetMesh,
        matrices: &StokesMatrices,
    ) -> Result<(Inertia, Vec<Vector3<f64>>), StokesError> {
        let mass = space.velocity_mass(mesh)?;
        let mut forces = match self.load {
            Some(load) => load.to_vec(),
            None => vec![Vector3::zeros(); mesh.n_points()],
        };
        if let Some(field) = self.force {
            for (force, row) in forces.iter_mut().zip(mass.outer_iterator()) {
                *force += row
                    .iter()
                    .map(|(column, m)| *m * field[column])
                    .sum::<Vector3<f64>>();
            }
        }
        let (vertex_mass, laplacian) = (&matrices.pressure_mass, &matrices.vertex_stiffness);
        let inertia = Inertia::new(
            self.coefficient,
            mass,
            vertex_mass.clone(),
            laplacian.clone(),
        );
        let Some(c) = self.convecting else {
            return Ok((inertia, forces));
        };
        // N_i, c and ∇N_j are of degree 2, 2 and 1
        let convection = space.assemble(mesh, 5, |point, matrix: &mut [[f64; 10]; 10]| {
            let c = self.density * point.value(c);
            let half = self.density * self.half_divergence(point);
            point.add(matrix, |v, u| {
                v.value * (c.dot(&u.gradient) + half * u.value)
            });
        })?;
        let of_pressure = space.assemble(mesh, 4, |point, matrix: &mut [[f64; 4]; 4]| {
            let c = self.density * point.value(c);
            point.add(matrix, |q, p| q.value * c.dot(&p.gradient));
        })?;
        let diffusion = space.assemble(mesh, 4, |point, matrix: &mut [[f64; 4]; 4]| {
            let c = self.density * point.value(c);
            // `2 |c| / h` with the length `h` of the cell along `c` (Tezduyar, Adv. Appl. Mech. 28,
            // 1991)
            let rates = point
                .linear_gradients()
                .map(|gradient| c.dot(&gradient).abs());
            let rate: f64 = rates.iter().sum();
            if rate > 0.0 {
                let time = 2.0 * STREAMLINE_PART / rate;
                point.add(matrix, |q, p| {
                    time * c.dot(&q.gradient) * c.dot(&p.gradient)
                });
            }
        })?;
        let of_pressure = [of_pressure, diffusion];
        Ok((inertia.with_convection(convection, of_pressure), forces))
    }

    /// Whether the equations are those of Stokes flow.
    pub(crate) fn are_zero(&self) -> bool {
        let forces = self.force.is_some() || self.load.is_some() || self.convecting.is_some();
        self.coefficient == 0.0 && !forces
    }

    /// `∇·d / 2`; zero without this part.
    pub(crate) fn half_divergence(&self, point: &PointValues) -> f64 {
        (self.divergence_of).map_or(0.0, |d| 0.5 * point.gradient(d).trace())
    }

    /// Refuses fields of another length than the nodes.
    pub(crate) fn check(&self, nodes: usize) -> Result<(), StokesError> {
        let fields = [self.force, self.load, self.convecting, self.divergence_of];
        for field in fields.into_iter().chain([self.wall_velocity, self.near]) {
            let found = field.map_or(nodes, <[_]>::len);
            if found != nodes {
                return Err(rigid::RigidError::Length {
                    what: "nodal values of the terms of inertia",
                    expected: nodes,
                    found,
                }
                .into());
            }
        }
        Ok(())
    }
}
