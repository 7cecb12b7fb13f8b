//! Geometry error of straight facets in the power of surface velocities and in stresslets.

use nalgebra::Matrix3;

use super::facet_geometry::{BoundaryFlow, FacetGeometry, gradient_of};
use crate::FemError;
use crate::check::{check_array, check_vectors};
use crate::load::velocity_gradient;

impl FacetGeometry<'_> {
    /// Change of [`power`](crate::power) if the facets are moved to the true surfaces, for a given
    /// flow between them.
    ///
    /// To first order in the distance `δ` from the facets to the surfaces, with the velocities
    /// `a_0` and `b_0` of the boundary, which are constant along its normals, and the pressure `p`
    /// of `a`
    ///
    /// ```text
    /// ∮ δ [d_a · 2 D(b) n + d_b · (2 D(a) - p) n - 2 D(a):D(b) + p ∇·b] dS,
    /// d_a = ∂(a - a_0)/∂n,   d_b = ∂(b - b_0)/∂n
    /// ```
    ///
    /// The first two terms are the effect of the velocities that the flow and the test function
    /// have on the facets, the others that of the layer between facets and surfaces. Further
    /// changes come from the flow that [`FacetGeometry::functional`] drives.
    ///
    /// Shapes: the velocities `n_points`, `pressure` `n_vertices`. Cost: one pass over the facets.
    ///
    /// # Errors
    /// Those of [`FacetGeometry::functional`].
    pub fn power(
        &self,
        (a, pressure): (BoundaryFlow<'_>, &[f64]),
        b: BoundaryFlow<'_>,
    ) -> Result<f64, FemError> {
        for flow in [&a, &b] {
            check_vectors("the velocity", flow.velocity, self.mesh.n_points())?;
        }
        check_array("the pressure", pressure, self.mesh.n_vertices())?;
        let powers = self.map_facets(|facet, boundary| {
            let relative = [a, b].map(|flow| flow.relative(self.mesh, facet));
            let nodes = &self.mesh.cells()[facet.cell as usize];
            let mut power = 0.0;
            self.for_each_point(facet, boundary, |at, gradients, normal, weight| {
                let [a, b] = [a, b].map(|flow| velocity_gradient(nodes, flow.velocity, gradients));
                let [d_a, d_b] = relative.map(|flow| gradient_of(&flow, gradients) * normal);
                let values = at.barycentric.iter().zip(nodes);
                let p: f64 = values
                    .map(|(l, &vertex)| l * pressure[vertex as usize])
                    .sum();
                let [twice_a, twice_b] = [a + a.transpose(), b + b.transpose()];
                power += weight
                    * (d_a.dot(&(twice_b * normal)) + d_b.dot(&(twice_a * normal - p * normal))
                        - twice_a.dot(&b)
                        + p * b.trace());
            })?;
            Ok(power)
        })?;
        check_array("the geometry error of the power", &powers, powers.len())?;
        Ok(powers.iter().sum())
    }

    /// Change of the stresslet of a body if its facets are moved to the true surface, for a given
    /// flow between them: `∮ δ 2 D(u - u_0) dS` over the facets with `tag`, without trace.
    ///
    /// The velocity `u_0` of the boundary changes the term `∮ u n^T dS` of the stresslet by
    /// `∮ δ ∇u_0 dS`; the rest is that of [`FacetGeometry::power`] with the test function `G x`, of
    /// which all but `-∮ δ 2 D(u):G dS` is in the moments of the loads of
    /// [`FacetGeometry::functional`] or cancels.
    ///
    /// Shapes: the velocity of `flow` `n_points`. Cost: one pass over the facets.
    ///
    /// # Errors
    /// Those of [`FacetGeometry::functional`].
    pub fn stresslet(&self, tag: u16, flow: BoundaryFlow<'_>) -> Result<Matrix3<f64>, FemError> {
        check_vectors("the velocity", flow.velocity, self.mesh.n_points())?;
        let strains = self.map_facets(|facet, boundary| {
            let mut sum = Matrix3::zeros();
            if facet.tag == tag {
                let relative = flow.relative(self.mesh, facet);
                self.for_each_point(facet, boundary, |_, gradients, _, weight| {
                    let gradient = gradient_of(&relative, gradients);
                    sum += weight * (gradient + gradient.transpose());
                })?;
            }
            Ok(sum)
        })?;
        let sum: Matrix3<f64> = strains.iter().sum();
        check_array("the geometry error of a stresslet", sum.as_slice(), 9)?;
        Ok(sum - Matrix3::identity() * (sum.trace() / 3.0))
    }
}
