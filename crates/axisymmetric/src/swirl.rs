//! The linear system of pure swirl by one order of elements: bodies that turn about the axis.
//!
//! The velocity around the axis has no divergence and no pressure: $\int \nabla u \cdot \nabla v + u v / r^2 = 0$ with `u = omega r` on bodies, zero on
//! walls and on the axis, which is the form of the velocity away from the axis.

use std::f64::consts::PI;

use nalgebra::DMatrix;

use crate::AxisymmetricError;
use crate::element::Lagrange;
use crate::meridian::{Side, Spheroid};
use crate::mesh::MeridianMesh;
use crate::shape::node_places;
use crate::space::Space;
use crate::stokes::element_matrices;
use crate::system::{Dof, Element, System, without_gaps};

/// Swirl by velocities of degree `order`.
///
/// # Errors
/// [`AxisymmetricError::InvertedTriangle`] where an element is inverted.
pub(crate) fn swirl(mesh: &MeridianMesh, order: usize) -> Result<System, AxisymmetricError> {
    let (velocity, pressure) = (Lagrange::new(order)?, Lagrange::new(order - 1)?);
    let space = Space::new(mesh, &velocity);
    let entities = space.entities(mesh, &velocity);
    let mut group = Vec::new();
    let dofs: Vec<Dof> = space
        .sides(mesh, &velocity)
        .into_iter()
        .zip(entities)
        .map(|(side, entity)| match side {
            Some(Side::Body(body)) => Dof::Body(body),
            Some(Side::Wall | Side::Axis) => Dof::Held,
            None => {
                group.push(entity);
                Dof::Unknown(group.len() as u32 - 1)
            }
        })
        .collect();
    let elements = element_matrices(mesh, &velocity, &pressure)?
        .into_iter()
        .enumerate()
        .map(|(t, matrices)| {
            let dofs: Vec<Dof> = space.nodes[t].iter().map(|&i| dofs[i as usize]).collect();
            let places = node_places(mesh, t, &velocity);
            // a body's degree of freedom is its angular velocity
            let factors: Vec<f64> = (dofs.iter().zip(&places))
                .map(|(dof, place)| match dof {
                    Dof::Body(_) => place.y,
                    Dof::Unknown(_) | Dof::Held => 1.0,
                })
                .collect();
            let n = dofs.len();
            Element {
                matrix: DMatrix::from_fn(n, n, |i, j| {
                    factors[i] * matrices.radial[(i, j)] * factors[j]
                }),
                dofs,
            }
        })
        .collect();
    Ok(System {
        elements,
        unknowns: group.len(),
        shift: vec![0.0; group.len()],
        group: without_gaps(group),
    })
}

/// What the torque of a turning body in the form of full gradients lacks of that of symmetric ones: twice its volume, from
/// $2 \int D(u) : D(v) = \int \nabla u : \nabla v + 2 \sum_i |B_i|\, \omega_i \cdot \Omega_i$ for velocities rigid on bodies and without divergence.
pub(crate) fn missing_torque(body: &Spheroid) -> f64 {
    2.0 * (4.0 / 3.0) * PI * body.axial * body.equatorial * body.equatorial
}
