//! Independent paths to forces and power.

use mesh::TetMesh;
use nalgebra::Vector3;
use rigid::{FlowSolution, SymmetryPlanes};

use super::estimate::flat;
use super::solve::Boundary;
use crate::model::{Checks, ModelError};

/// Compares consistent forces with integrals of the stress, and the power of the bodies with the dissipation.
///
/// # Errors
/// None on a mesh that was solved on.
pub fn checks(
    mesh: &TetMesh,
    boundary: &Boundary,
    flow: &FlowSolution,
) -> Result<Checks, ModelError> {
    let mirrors = SymmetryPlanes {
        planes: mesh.symmetry_planes(),
    };
    let (parts, allowed) = (mirrors.parts(), mirrors.allowed());
    let velocity = flat(&flow.velocity);
    let (mut largest, mut difference) = (0.0_f64, 0.0_f64);
    for (number, (name, &centre)) in boundary.bodies.iter().zip(&boundary.centres).enumerate() {
        let stress = fem::stress_load(mesh, mesh.tag(name)?, &velocity, &flow.pressure, centre)?;
        // Across mirror planes the parts of a body push against each other.
        let stress_force = Vector3::from_fn(|axis, _| match allowed[axis] {
            true => parts * stress.force[axis],
            false => 0.0,
        });
        let force = Vector3::from_fn(|axis, _| flow.forces[6 * number + axis]);
        largest = largest.max(force.norm());
        difference = difference.max((stress_force - force).norm());
    }
    let power = flow.forces.dot(&flow.bodies);
    let relative = |difference: f64, whole: f64| {
        // What does not move has nothing to compare.
        if whole > 0.0 { difference / whole } else { 0.0 }
    };
    let dissipation = parts * fem::dissipation(mesh, &velocity)?;
    Ok(Checks {
        force_by_stress: relative(difference, largest),
        dissipation: relative(dissipation - power, power),
    })
}
