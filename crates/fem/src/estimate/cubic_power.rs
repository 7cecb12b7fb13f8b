//! Power of a flow in cubic velocities and quadratic pressures.

use mesh::{TET_EDGES, Vec3};

use super::bubbles::rule;
use super::cubic::CubicExtension;
use super::facet_geometry::gradient_of;
use crate::FemError;
use crate::check::{check_array, check_length, check_vectors};
use crate::geometry::MapAt;
use crate::load::velocity_gradient;
use crate::sum::sum_over;

/// A flow of quadratic velocities and linear pressures with dofs of a [`CubicExtension`].
#[derive(Clone, Copy)]
pub struct CubicFlow<'a> {
    /// Velocity of each node.
    pub velocity: &'a [Vec3],
    /// Pressure of each vertex.
    pub pressure: &'a [f64],
    /// Dofs of the extension.
    pub extension: &'a [f64],
}

impl CubicExtension<'_> {
    /// Power of the forces of a flow in the motion `test` of the boundary, at viscosity 1.
    ///
    /// ```text
    /// P = ∫ 2 D(u):D(v) - ∫ p ∇·v
    /// ```
    ///
    /// As [`power`](crate::power) for functions of the next degree; the pressures of `test` are not
    /// used. Cost: one pass over the cells at the boundary.
    ///
    /// # Errors
    /// Arrays of the wrong length or not finite; [`FemError::InvertedCell`].
    pub fn power(&self, flow: CubicFlow<'_>, test: CubicFlow<'_>) -> Result<f64, FemError> {
        let mesh = self.mesh();
        for field in [&flow, &test] {
            check_vectors("the velocity", field.velocity, mesh.n_points())?;
            check_length("the extension", field.extension.len(), self.len())?;
        }
        check_array("the pressure", flow.pressure, mesh.n_vertices())?;
        let extensions = [flow, test].map(|field| self.completed(field.extension));
        let [mut power] = sum_over(mesh.cells().len(), |cell| {
            if self.part().is_some_and(|part| !part.owns_cell(cell)) {
                return Ok([0.0]);
            }
            let nodes = &mesh.cells()[cell];
            let bubbles = extensions.each_ref().map(|extension| {
                let [x, y, z] = self.bubbles_of(cell, extension);
                std::array::from_fn(|k| Vec3::new(x[k], y[k], z[k]))
            });
            let is_at_rest = |node: &u32| test.velocity[*node as usize] == Vec3::zeros();
            if nodes.iter().all(is_at_rest) && bubbles[1] == [Vec3::zeros(); 10] {
                return Ok([0.0]);
            }
            let positions = mesh.cell_points(cell);
            let edges = self.edges_of(cell, &extensions[0]);
            let mut sum = 0.0;
            for point in rule() {
                let map = MapAt::new(cell, &positions, point.at)?;
                let gradients = map.gradients(point.at);
                let [u, v] = [(flow, &bubbles[0]), (test, &bubbles[1])].map(|(field, bubbles)| {
                    let of_bubbles = gradient_of(bubbles, &point.gradients);
                    velocity_gradient(nodes, field.velocity, &gradients) + map.gradient(&of_bubbles)
                });
                let l = &point.at.barycentric;
                let linear = l.iter().zip(nodes);
                let linear = linear.map(|(l, &vertex)| l * flow.pressure[vertex as usize]);
                let quadratic = edges.iter().zip(TET_EDGES);
                let quadratic = quadratic.map(|(value, [a, b])| value * l[a] * l[b]);
                let p: f64 = linear.chain(quadratic).sum();
                sum += map.measure * ((u + u.transpose()).dot(&v) - p * v.trace());
            }
            Ok([sum])
        })?;
        if let Some(part) = self.part() {
            part.sum(std::slice::from_mut(&mut power));
        }
        check_array("the power", &[power], 1)?;
        Ok(power)
    }
}
