//! The linear system of pure swirl for one element order: bodies that rotate about the axis.
//!
//! The azimuthal velocity `u` is divergence-free and causes no pressure:
//! `∫ ∇u·∇v + u v / r^2 = 0` with `u = ω r` on bodies and zero on walls and on the axis. The
//! bilinear form is that of the radial velocity in flow without swirl.

use std::f64::consts::PI;

use nalgebra::DMatrix;

use crate::AxisymmetricError;
use crate::curve::BoundaryPart;
use crate::element::Lagrange;
use crate::geometry_map::node_positions;
use crate::mesh::MeridianMesh;
use crate::space::Space;
use crate::spheroid::AxialSpheroid;
use crate::stokes::element_matrices;
use crate::system::{Dof, Element, System, condensed, numbered_consecutively};

/// Assembles the azimuthal flow around rotating bodies with velocities of degree `order`.
///
/// # Errors
/// [`AxisymmetricError::InvertedTriangle`], [`AxisymmetricError::SingularElement`].
pub(crate) fn swirl(mesh: &MeridianMesh, order: usize) -> Result<System, AxisymmetricError> {
    let (velocity, pressure) = (Lagrange::new(order)?, Lagrange::new(order - 1)?);
    let space = Space::new(mesh, &velocity);
    let entities = space.entities(mesh, &velocity);
    let mut group = Vec::new();
    let dofs: Vec<Dof> = space
        .parts(mesh, &velocity)
        .into_iter()
        .zip(entities)
        .map(|(part, entity)| match part {
            Some(BoundaryPart::Body(body)) => Dof::Body(body),
            Some(BoundaryPart::Wall | BoundaryPart::Axis) => Dof::Constrained,
            Some(BoundaryPart::Open | BoundaryPart::Interface(_)) | None => {
                group.push(entity);
                Dof::Free(group.len() as u32 - 1)
            }
        })
        .collect();
    let shared = velocity.n_shared_nodes();
    let inner: Vec<usize> = (shared..velocity.len()).collect();
    let elements = element_matrices(mesh, &velocity, &pressure)?
        .into_iter()
        .enumerate()
        .map(|(t, matrices)| {
            let nodes = &space.nodes[t][..shared];
            let dofs: Vec<Dof> = nodes.iter().map(|&i| dofs[i as usize]).collect();
            let positions = node_positions(mesh, t, &velocity);
            // a body's degree of freedom is its angular velocity
            let factors: Vec<f64> = (dofs.iter().zip(&positions))
                .map(|(dof, position)| match dof {
                    Dof::Body(_) => position.y,
                    Dof::Free(_) | Dof::Constrained => 1.0,
                })
                .collect();
            let matrix = condensed(&matrices.radial, &inner)
                .ok_or(AxisymmetricError::SingularElement { triangle: t })?;
            Ok(Element {
                matrix: DMatrix::from_fn(shared, shared, |i, j| {
                    factors[i] * matrix[(i, j)] * factors[j]
                }),
                dofs,
            })
        })
        .collect::<Result<_, AxisymmetricError>>()?;
    let on_boundary = |nodes: Vec<u32>| nodes.iter().map(|&i| dofs[i as usize]).collect();
    let traces = space.traces(mesh, &velocity).into_iter();
    Ok(System {
        elements,
        traces: traces
            .map(|(part, nodes)| (part, on_boundary(nodes)))
            .collect(),
        n_dofs: group.len(),
        shift: vec![0.0; group.len()],
        group: numbered_consecutively(group),
    })
}

/// Torque per angular velocity that the form `∫ ∇u:∇v` omits: twice the volume of the body.
///
/// For divergence-free velocities that are rigid on the bodies `B_i`, with angular velocities
/// `ω_i` (of `u`) and `Ω_i` (of `v`), `2 ∫ D(u):D(v) = ∫ ∇u:∇v + 2 sum_i |B_i| ω_i·Ω_i`.
pub(crate) fn omitted_torque(body: &AxialSpheroid) -> f64 {
    2.0 * (4.0 / 3.0) * PI * body.axial * body.equatorial * body.equatorial
}
