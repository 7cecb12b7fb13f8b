//! Forces and torques that bodies exert on the fluid, from the residual and from the stress.

use mesh::{TetMesh, Vec3};
use nalgebra::Matrix3;

use crate::error::{FemError, check_array, check_vectors};
use crate::geometry::MapAt;
use crate::quadrature::facet_degree_6;
use crate::quantity::gradient_in_cell;
use crate::sum::sum_over;
use crate::surface::{
    facet_cell_point, facet_nodes, position_and_normal, surface_measures, tagged_facets,
};

/// Force and torque that a body exerts on the fluid, at viscosity 1.
///
/// The force of a body that moves through fluid at rest has the direction of its velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct LoadOnFluid {
    /// Force.
    pub force: Vec3,
    /// Torque about the given centre.
    pub torque: Vec3,
}

impl LoadOnFluid {
    /// Refuses a load that is not finite, as for a centre that is not.
    fn checked(self) -> Result<Self, FemError> {
        check_vectors("force and torque", &[self.force, self.torque], 2)?;
        Ok(self)
    }
}

/// Force and torque of a body from the residual of the momentum equation (consistent load).
///
/// ```text
/// F = sum_b r_b,   T = sum_b (x_b - centre) × r_b + 2 |B_h| ω
/// ```
///
/// The sums run over the nodes of the facets with `tag`. The errors of `F` and `T` are energy
/// products of discretisation errors, and therefore of fourth order on curved cells. The last term
/// of the torque is the difference between the grad-grad form and the stress; `ω` is the angular
/// velocity of the body and `|B_h|` its discrete volume. The velocity must be rigid on the body and
/// zero or rigid on the rest of the boundary. The surface is closed, so up to rounding the force
/// does not depend on the mean of the pressure.
///
/// Shapes: `residual` `n_points`, from [`momentum_residual`](crate::momentum_residual).
///
/// # Errors
/// Those of [`surface_measures`]; a residual of the wrong length or not finite; a result that is
/// not finite, as for a centre that is not.
pub fn consistent_load(
    mesh: &TetMesh,
    tag: u16,
    residual: &[Vec3],
    centre: Vec3,
    angular_velocity: Vec3,
) -> Result<LoadOnFluid, FemError> {
    check_vectors("the residual", residual, mesh.n_points())?;
    let volume = surface_measures(mesh, tag)?.volume;
    let mut load = LoadOnFluid {
        force: Vec3::zeros(),
        torque: 2.0 * volume * angular_velocity,
    };
    for node in mesh.nodes_on(tag) {
        let node = node as usize;
        let r = &residual[node];
        load.force += r;
        load.torque += (mesh.points()[node] - centre).cross(r);
    }
    load.checked()
}

/// Force and torque of a body from the stress on its surface.
///
/// ```text
/// F = ∮ σ n dS,   T = ∮ (x - centre) × σ n dS,   σ = -p I + ∇u + ∇u^T
/// ```
///
/// The integrals run over the facets with `tag`; `n` points out of the fluid. This check of
/// [`consistent_load`] does not use the matrices and holds for every boundary condition, but its
/// order is lower (1.3 to 2 measured).
///
/// Shapes: `velocity` `n_points`, `pressure` `n_vertices`.
///
/// # Errors
/// No facet has the tag; arrays of the wrong length or not finite; an inverted cell at the surface;
/// a result that is not finite, as for a centre that is not.
pub fn stress_load(
    mesh: &TetMesh,
    tag: u16,
    velocity: &[Vec3],
    pressure: &[f64],
    centre: Vec3,
) -> Result<LoadOnFluid, FemError> {
    check_vectors("the velocity", velocity, mesh.n_points())?;
    check_array("the pressure", pressure, mesh.n_vertices())?;
    let facets = tagged_facets(mesh, tag)?;
    let [fx, fy, fz, tx, ty, tz] = sum_over(facets.len(), |k| {
        let facet = facets[k];
        let (mut force, mut torque) = (Vec3::zeros(), Vec3::zeros());
        let cell = facet.cell as usize;
        let nodes = &mesh.cells()[cell];
        let (positions, surface) = (mesh.cell_points(cell), facet_nodes(mesh, facet));
        for point in facet_degree_6() {
            let at = facet_cell_point(facet, nodes, point);
            let map = MapAt::new(cell, &positions, &at)?;
            let mut stress = gradient_in_cell(nodes, velocity, &map.gradients(&at));
            stress += stress.transpose();
            let p: f64 = (0..4)
                .map(|q| at.barycentric[q] * pressure[nodes[q] as usize])
                .sum();
            stress -= Matrix3::from_diagonal_element(p);
            let (x, normal) = position_and_normal(&surface, point);
            let traction = stress * normal * point.weight;
            force += traction;
            torque += (x - centre).cross(&traction);
        }
        Ok([force.x, force.y, force.z, torque.x, torque.y, torque.z])
    })?;
    let load = LoadOnFluid {
        force: Vec3::new(fx, fy, fz),
        torque: Vec3::new(tx, ty, tz),
    };
    load.checked()
}
