//! Error of straight facets on curved boundaries (geometry error): a functional of the flow, for
//! forces, powers and stresslets.

use mesh::{Facet, Surface, TetMesh, Vec3};
use nalgebra::Matrix3;
use rayon::prelude::*;

use super::varying_viscosity::ViscosityOfRate;
use crate::error::{FemError, check_array, check_vectors};
use crate::geometry::MapAt;
use crate::quadrature::{CellPoint, facet_degree_6};
use crate::quantity::gradient_in_cell;
use crate::surface::{facet_cell_point, facet_nodes, position_and_normal, tagged_facets};
use crate::surface_velocity::SurfaceVelocity;

/// Number of facets per task: enough work to outweigh its start.
const FACETS_PER_TASK: usize = 64;

/// A smooth surface that is approximated by the facets with a tag.
#[derive(Clone, Copy)]
pub struct CurvedBoundary<'a> {
    /// Index into [`TetMesh::tags`].
    pub tag: u16,
    /// The true surface.
    pub surface: &'a dyn Surface,
    /// Whether the fluid is inside the surface.
    pub is_wall: bool,
}

/// A flow with the velocity of the boundary relative to rigid motions.
#[derive(Clone, Copy)]
pub struct BoundaryFlow<'a> {
    /// Velocity of each node.
    pub velocity: &'a [Vec3],
    /// Velocity of the boundary; none if it moves rigidly.
    pub surface_velocity: Option<&'a SurfaceVelocity<'a>>,
}

impl<'a> From<&'a [Vec3]> for BoundaryFlow<'a> {
    fn from(velocity: &'a [Vec3]) -> Self {
        Self {
            velocity,
            surface_velocity: None,
        }
    }
}

impl<'a> From<&'a Vec<Vec3>> for BoundaryFlow<'a> {
    fn from(velocity: &'a Vec<Vec3>) -> Self {
        Self::from(&velocity[..])
    }
}

impl BoundaryFlow<'_> {
    /// Velocities of the nodes of the cell of a facet, relative to that of the boundary.
    pub(super) fn relative(&self, mesh: &TetMesh, facet: &Facet) -> [Vec3; 10] {
        mesh.cells()[facet.cell as usize].map(|node| {
            let (velocity, x) = (self.velocity[node as usize], mesh.points()[node as usize]);
            match self.surface_velocity {
                None => velocity,
                Some(surface_velocity) => velocity - surface_velocity(facet.tag, x),
            }
        })
    }
}

/// Loads on the velocity of each node and the pressure of each vertex.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FacetFunctional {
    /// One load per node.
    pub velocity: Vec<Vec3>,
    /// One volume per vertex, with zero sum; all zero if the boundary moves rigidly.
    pub pressure: Vec<f64>,
}

/// Loads of one facet on its cell.
#[derive(Default)]
struct FacetLoad {
    velocity: [Vec3; 10],
    sources: [f64; 4],
    /// Sum of `|δ|` times the shape functions.
    sizes: [f64; 4],
}

/// Geometry error: effect of the facets of curved boundaries on functionals of the flow.
///
/// The nodes of the facets lie on the true surfaces. If the boundary is moved by `δ` into the
/// fluid, with the same rigid motions prescribed on it, the bilinear form of the power changes by
///
/// ```text
/// G(a, b) = ∮ δ t_a · t_b dS,   t = 2 D(u) n - n (n · 2 D(u) n)
/// ```
///
/// to first order in `δ` (Hadamard's formula; Pironneau 1974 for the Stokes drag). The reason: the
/// velocity relative to the motion of the body has only a normal derivative, and this derivative is
/// the shear traction at viscosity 1. A velocity `s` of the surface relative to the body is
/// subtracted before ([`BoundaryFlow`]); the difference also has the normal derivative `-∇·s`,
/// which is a source of fluid at the facets. Hence `R_ab - R_h,ab = G(a, b)` for resistances, with
/// flows of unit motions of bodies, and `M_h,ab - M_ab = G(a, b)` for mobilities, with flows of
/// unit loads. Facets inside a body are at the distance `δ` below its surface;
/// on a wall around the fluid the facets are inside the fluid domain, and `δ` is negative. For
/// straight facets `δ` is of second order in their size, for curved ones of third order.
///
/// The ratio of the estimate, including the hierarchical surplus, to the true error of straight
/// elements is 0.72 to 0.97 for drag and torque of a sphere, a pair half a radius apart and the
/// forces of a swimmer, with edges of a half to a quarter of a radius. The ratio approaches one as
/// the edges become shorter, because the neglected terms are of the next order in `δ` over the edge
/// length. For a wall whose facets are a third of its radius long, the true effect is about half of
/// the estimate.
pub struct FacetGeometry<'a> {
    pub(super) mesh: &'a TetMesh,
    facets: Vec<(&'a Facet, CurvedBoundary<'a>)>,
    /// Velocity with the background flow, and the viscosity as a function of the shear rate.
    viscosity: Option<(&'a [Vec3], &'a ViscosityOfRate<'a>)>,
}

impl<'a> FacetGeometry<'a> {
    /// Collects the facets of the given boundaries.
    ///
    /// # Errors
    /// A boundary without facets, or whose bounding ball is not finite.
    pub fn new(mesh: &'a TetMesh, boundaries: &[CurvedBoundary<'a>]) -> Result<Self, FemError> {
        let mut facets = Vec::new();
        for &boundary in boundaries {
            let (centre, radius) = boundary.surface.bounding_ball();
            check_array("the radius of a curved boundary", &[radius], 1)?;
            check_vectors("the centre of a curved boundary", &[centre], 1)?;
            let tagged = tagged_facets(mesh, boundary.tag)?;
            facets.extend(tagged.into_iter().map(|facet| (facet, boundary)));
        }
        Ok(Self {
            mesh,
            facets,
            viscosity: None,
        })
    }

    /// The same facets in a fluid whose viscosity is that of the flow with this velocity.
    ///
    /// All effects then have the viscosity at the facets as a factor. That of a change of the flow
    /// is up to the index of the law smaller, which uncertainties of these effects include.
    ///
    /// # Errors
    /// A velocity of the wrong length or not finite.
    pub fn with_viscosity(
        mut self,
        velocity: &'a [Vec3],
        law: &'a ViscosityOfRate<'a>,
    ) -> Result<Self, FemError> {
        check_vectors("the velocity", velocity, self.mesh.n_points())?;
        self.viscosity = Some((velocity, law));
        Ok(self)
    }

    /// Viscosity at a point of a facet, where the functions of its cell have these gradients.
    fn viscosity(&self, facet: &Facet, gradients: &[Vec3; 10]) -> f64 {
        self.viscosity.map_or(1.0, |(velocity, law)| {
            let nodes = &self.mesh.cells()[facet.cell as usize];
            let gradient = gradient_in_cell(nodes, velocity, gradients);
            let twice_rate = gradient + gradient.transpose();
            law((0.5 * twice_rate.dot(&twice_rate)).sqrt())[0]
        })
    }

    /// For each facet, whether it is on a wall around the fluid.
    pub fn is_wall(&self) -> impl Iterator<Item = bool> {
        self.facets.iter().map(|(_, boundary)| boundary.is_wall)
    }

    /// The cell of each facet.
    pub fn cells(&self) -> impl Iterator<Item = usize> {
        self.facets.iter().map(|(facet, _)| facet.cell as usize)
    }

    /// The functional `b -> G(a, b)` for the flow `a`, as loads on velocities and pressures.
    ///
    /// Shapes: the velocities of `flow` `n_points`. Cost: one pass over the facets. The same for
    /// any number of threads.
    ///
    /// # Errors
    /// A velocity of the wrong length or not finite; an inverted cell at the surface; a result that
    /// is not finite.
    pub fn functional<'f>(
        &self,
        flow: impl Into<BoundaryFlow<'f>>,
    ) -> Result<FacetFunctional, FemError> {
        let flow = flow.into();
        check_vectors("the velocity", flow.velocity, self.mesh.n_points())?;
        let is_rigid = flow.surface_velocity.is_none();
        let loads = self.map_facets(|facet, boundary| {
            let relative = flow.relative(self.mesh, facet);
            let mut load = FacetLoad::default();
            self.for_each_point(facet, boundary, |at, gradients, normal, weight| {
                let gradient = gradient_of(&relative, gradients);
                let mut derivative = shear(&gradient, normal);
                if !is_rigid {
                    let stretching = normal.dot(&(gradient * normal));
                    derivative += stretching * normal;
                    for (k, l) in at.barycentric.iter().enumerate() {
                        load.sources[k] -= weight * stretching * l;
                        load.sizes[k] += weight.abs() * l;
                    }
                }
                let weight = weight * self.viscosity(facet, gradients);
                for (value, gradient) in load.velocity.iter_mut().zip(gradients) {
                    // The derivative of a rigid surface is tangential, so the traction of the other
                    // flow need not be projected onto the tangential plane.
                    *value += weight
                        * (derivative * gradient.dot(normal) + normal * derivative.dot(gradient));
                }
            })?;
            Ok(load)
        })?;
        let mut functional = FacetFunctional {
            velocity: vec![Vec3::zeros(); self.mesh.n_points()],
            pressure: vec![0.0; self.mesh.n_vertices()],
        };
        let (mut sizes, mut sum) = (vec![0.0; self.mesh.n_vertices()], 0.0);
        for ((facet, _), load) in self.facets.iter().zip(loads) {
            let nodes = &self.mesh.cells()[facet.cell as usize];
            for (&node, value) in nodes.iter().zip(&load.velocity) {
                functional.velocity[node as usize] += value;
            }
            for (k, &vertex) in nodes[..4].iter().enumerate() {
                functional.pressure[vertex as usize] += load.sources[k];
                sizes[vertex as usize] += load.sizes[k];
                sum += load.sources[k];
            }
        }
        let size: f64 = sizes.iter().sum();
        if size > 0.0 {
            // No fluid is created: the sum is an error of higher order.
            let pressures = functional.pressure.iter_mut().zip(sizes);
            pressures.for_each(|(source, own)| *source -= sum * own / size);
        }
        check_vectors(
            "the geometry error",
            &functional.velocity,
            self.mesh.n_points(),
        )?;
        check_array(
            "the geometry error",
            &functional.pressure,
            self.mesh.n_vertices(),
        )?;
        Ok(functional)
    }

    /// Contribution of each facet to `G(a, b)`, for the flows with the velocities `a` and `b`.
    ///
    /// Shapes: `a` and `b` `n_points`. Cost: one pass over the facets. The same for any number of
    /// threads.
    ///
    /// # Errors
    /// Those of [`FacetGeometry::functional`].
    pub fn indicators<'f>(
        &self,
        a: impl Into<BoundaryFlow<'f>>,
        b: impl Into<BoundaryFlow<'f>>,
    ) -> Result<Vec<f64>, FemError> {
        let flows = [a.into(), b.into()];
        for flow in &flows {
            check_vectors("the velocity", flow.velocity, self.mesh.n_points())?;
        }
        let indicators = self.map_facets(|facet, boundary| {
            let relative = flows.map(|flow| flow.relative(self.mesh, facet));
            let mut indicator = 0.0;
            self.for_each_point(facet, boundary, |_, gradients, normal, weight| {
                let [a, b] = relative.map(|u| shear(&gradient_of(&u, gradients), normal));
                indicator += weight * self.viscosity(facet, gradients) * a.dot(&b);
            })?;
            Ok(indicator)
        })?;
        check_array("the geometry error", &indicators, self.facets.len())?;
        Ok(indicators)
    }

    /// Applies `f` to all facets in parallel.
    pub(super) fn map_facets<T: Send>(
        &self,
        f: impl Fn(&Facet, &CurvedBoundary<'_>) -> Result<T, FemError> + Sync,
    ) -> Result<Vec<T>, FemError> {
        let facets = self.facets.par_iter().with_min_len(FACETS_PER_TASK);
        facets.map(|(facet, boundary)| f(facet, boundary)).collect()
    }

    /// Calls `f` at the quadrature points of a facet.
    ///
    /// Its arguments are the point in the cell, the gradients of the shape functions of the cell,
    /// the unit normal out of the fluid, and the quadrature weight times the distance `δ`.
    pub(super) fn for_each_point(
        &self,
        facet: &Facet,
        boundary: &CurvedBoundary<'_>,
        mut f: impl FnMut(&CellPoint, &[Vec3; 10], &Vec3, f64),
    ) -> Result<(), FemError> {
        let cell = facet.cell as usize;
        let (positions, surface) = (self.mesh.cell_points(cell), facet_nodes(self.mesh, facet));
        for point in facet_degree_6() {
            let inside = facet_cell_point(facet, &self.mesh.cells()[cell], point);
            let map = MapAt::new(cell, &positions, &inside)?;
            let (x, normal) = position_and_normal(&surface, point);
            let area = normal.norm();
            let outside = boundary.surface.signed_distance(x);
            let distance = if boundary.is_wall { outside } else { -outside };
            f(
                &inside,
                &map.gradients(&inside),
                &(normal / area),
                distance * area * point.weight,
            );
        }
        Ok(())
    }
}

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
                let [a, b] = [a, b].map(|flow| gradient_in_cell(nodes, flow.velocity, gradients));
                let [d_a, d_b] = relative.map(|flow| gradient_of(&flow, gradients) * normal);
                let values = at.barycentric.iter().zip(nodes);
                let p: f64 = values
                    .map(|(l, &vertex)| l * pressure[vertex as usize])
                    .sum();
                let viscosity = self.viscosity(facet, gradients);
                let [twice_a, twice_b] = [a, b].map(|u| (u + u.transpose()) * viscosity);
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
                    let weight = weight * self.viscosity(facet, gradients);
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

/// Velocity gradient `∂u_c/∂x_k` from the velocities of the nodes of a cell.
pub(super) fn gradient_of(velocities: &[Vec3; 10], gradients: &[Vec3; 10]) -> Matrix3<f64> {
    let terms = velocities.iter().zip(gradients);
    terms.map(|(u, gradient)| u * gradient.transpose()).sum()
}

/// Tangential part of `2 D n`.
fn shear(gradient: &Matrix3<f64>, normal: &Vec3) -> Vec3 {
    let traction = gradient * normal + gradient.tr_mul(normal);
    traction - normal * normal.dot(&traction)
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::LinearTets;
    use mesher::Sphere;

    /// Unit cube whose boundary stands for a ball around it, so that all distances are known.
    fn cube() -> TetMesh {
        TetMesh::straight(LinearTets::cube(2)).unwrap()
    }

    #[test]
    fn shear_is_zero_for_rigid_motion_and_the_rate_for_shear_flow() {
        let mesh = cube();
        let tag = mesh.tag("z1").unwrap();
        let surface = &Sphere::new(Vec3::new(0.5, 0.5, 0.5), 1.0);
        let ball = CurvedBoundary {
            tag,
            surface,
            is_wall: true,
        };
        let geometry = FacetGeometry::new(&mesh, &[ball]).unwrap();
        let flow = |f: fn(&Vec3) -> Vec3| -> Vec<Vec3> { mesh.points().iter().map(f).collect() };
        let rigid = flow(|x| Vec3::new(1.0, 2.0, 3.0) + Vec3::new(0.3, -0.2, 0.1).cross(x));
        let sheared = flow(|x| Vec3::new(2.0 * x.z, 0.0, 0.0));
        let stretched = flow(|x| Vec3::new(x.x, x.y, -2.0 * x.z));
        let sum = |a: &[Vec3], b: &[Vec3]| geometry.indicators(a, b).unwrap().iter().sum::<f64>();
        assert!(sum(&rigid, &sheared).abs() < 1e-14);
        assert!(sum(&stretched, &sheared).abs() < 1e-14);
        // The wall is outside, so G is minus the mean of 1 - |x - c| over the side times the square
        // of the shear rate.
        let distance = 1.0 - mean_distance();
        assert!((sum(&sheared, &sheared) + 4.0 * distance).abs() < 1e-4);
        // The functional is the same bilinear form.
        let load = geometry.functional(&sheared).unwrap();
        for other in [&rigid, &sheared, &stretched] {
            let dot: f64 = load.velocity.iter().zip(other).map(|(a, b)| a.dot(b)).sum();
            assert!((dot - sum(&sheared, other)).abs() < 1e-13);
        }
    }

    /// Mean of `√(x^2 + y^2 + 1/4)` over the unit square about the origin, by the midpoint rule.
    fn mean_distance() -> f64 {
        let n = 200;
        let at = |k: usize| (k as f64 + 0.5) / n as f64 - 0.5;
        let sum: f64 = (0..n * n)
            .map(|k| (at(k / n).powi(2) + at(k % n).powi(2) + 0.25).sqrt())
            .sum();
        sum / (n * n) as f64
    }
}
