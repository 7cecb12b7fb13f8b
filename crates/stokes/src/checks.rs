//! Independent computations of forces and power.

use nalgebra::Vector3;
use rigid::FlowSolution;
use serde::Serialize;

use crate::StokesError;
use crate::problem::Problem;
use crate::surface_flow::NodalSurfaceFlow;
use crate::viscous_stress::ViscousStress;

/// Relative differences between a solution and independent computations of the same quantities.
///
/// Both vanish with the element size, but more slowly than the errors of the solution: stresses
/// converge at a lower order, and the dissipation is an integral over the fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Checks {
    /// Largest difference between a body's force and the integral of the stress over its surface,
    /// divided by the largest force; with slip or a background flow at least by the dissipation
    /// over the largest velocity.
    pub force_by_stress: f64,
    /// Dissipation in the fluid divided by the power of the bodies, minus one.
    pub dissipation: f64,
}

/// Compares forces with integrals of the stress, and the power of the bodies with the dissipation.
///
/// `stress` is that of the flow if its viscosity varies; its dissipation is the power of the whole
/// stress in the disturbance flow, and differs from the power of the bodies by the residual alone.
///
/// # Errors
/// An inverted cell, which a mesh with a solution does not have.
pub fn checks(
    problem: &Problem,
    flow: &FlowSolution,
    surfaces: Option<&NodalSurfaceFlow>,
    stress: Option<ViscousStress>,
) -> Result<Checks, StokesError> {
    let mesh = problem.mesh;
    let (parts, allowed) = (problem.parts(), problem.symmetry().allowed());
    let (mut largest, mut difference) = (0.0_f64, 0.0_f64);
    for (number, &(tag, centre)) in problem.bodies.iter().enumerate() {
        let by_stress = match &stress {
            Some(stress) => stress.force(tag, &flow.pressure)?,
            None => fem::stress_load(mesh, tag, &flow.velocity, &flow.pressure, centre)?.force,
        };
        // The stress on one half of a body includes the force that the halves exert on each other
        // across the symmetry plane; the force of the whole body has no such component.
        let stress_force = Vector3::from_fn(|axis, _| match allowed[axis] {
            true => parts * by_stress[axis],
            false => 0.0,
        });
        let force = Vector3::from_fn(|axis, _| flow.forces[6 * number + axis]);
        largest = largest.max(force.norm());
        difference = difference.max((stress_force - force).norm());
    }
    let of_surfaces = problem.power_of_surfaces(flow, surfaces, stress)?;
    let power = flow.forces.dot(&flow.bodies) + of_surfaces;
    let dissipation = parts
        * match &stress {
            Some(stress) => stress.power(&flow.pressure, &flow.velocity)?,
            None => fem::dissipation(mesh, &flow.velocity)?,
        };
    if surfaces.is_some() {
        // Bodies without forces may have surfaces with slip.
        let fastest = flow.velocity.iter().map(Vector3::norm).fold(0.0, f64::max);
        largest = largest.max(dissipation / fastest);
    }
    // For bodies at rest there is nothing to compare.
    let relative = |difference: f64, whole: f64| if whole > 0.0 { difference / whole } else { 0.0 };
    Ok(Checks {
        force_by_stress: relative(difference, largest),
        dissipation: relative(dissipation - power, power),
    })
}
