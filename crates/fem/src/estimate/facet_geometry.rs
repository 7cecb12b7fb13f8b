//! What straight facets cut off round bodies, as a functional of the flow.

use mesh::{Facet, TetMesh, Vec3};
use nalgebra::Matrix3;
use rayon::prelude::*;

use crate::FemError;
use crate::check::check_array;
use crate::geometry::MapAt;
use crate::load::{facet_cell_point, velocity_gradient};
use crate::quadrature::facet_degree_6;
use crate::surface::{facet_nodes, position_and_normal, tagged_facets};

/// A sphere that the facets with a tag stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvedBoundary {
    /// Index into [`TetMesh::tags`].
    pub tag: u16,
    /// Centre of the sphere.
    pub centre: Vec3,
    /// Its radius.
    pub radius: f64,
    /// Whether the fluid is inside the sphere.
    pub is_wall: bool,
}

/// The facets of a mesh whose vertices lie on spheres: what functionals of the flow err by because facets are chords.
///
/// A boundary that is moved by $\delta$ into the fluid, with the same rigid motions on it, changes the bilinear form of the powers by
///
/// $G(a, b) = \oint \delta\, t_a \cdot t_b\, dS, \quad t = 2 D(u) n - n (n \cdot 2 D(u) n)$,
///
/// to first order in $\delta$ (Hadamard's formula; Pironneau 1974 for the Stokes drag): the velocity against the body's own motion has only a
/// normal derivative, and that is the shear traction at viscosity 1. So $R_{ab} - R_{h,ab} = G(a, b)$ for unit motions of bodies and
/// $M_{h,ab} - M_{ab} = G(a, b)$ for flows of unit loads. FacetGeometry inside a sphere lack the height $\delta = R - |x - c|$, of second
/// order in their length; on a wall around the fluid they take as much from it, and $\delta$ is negative.
///
/// Estimate over true error of straight elements, the surplus of the mesh included: 0.72 to 0.97 for drag and torque of a sphere, a pair half a
/// radius apart and a swimmer's forces with edges of a half to a quarter of a radius, the nearer to one the finer; what is left out is of the next
/// order in heights over edges. What a wall takes whose facets are a third of its radius long is about half of the estimate.
pub struct FacetGeometry<'a> {
    mesh: &'a TetMesh,
    facets: Vec<(&'a Facet, CurvedBoundary)>,
}

impl<'a> FacetGeometry<'a> {
    /// The facets of these parts.
    ///
    /// # Errors
    /// A part without facets.
    pub fn new(mesh: &'a TetMesh, parts: &[CurvedBoundary]) -> Result<Self, FemError> {
        let mut facets = Vec::new();
        for &part in parts {
            facets.extend(
                tagged_facets(mesh, part.tag)?
                    .into_iter()
                    .map(|f| (f, part)),
            );
        }
        Ok(Self { mesh, facets })
    }

    /// Whether each facet is of a wall around the fluid.
    pub fn is_wall(&self) -> impl Iterator<Item = bool> {
        self.facets.iter().map(|(_, part)| part.is_wall)
    }

    /// The cell of each facet.
    pub fn cells(&self) -> impl Iterator<Item = usize> {
        self.facets.iter().map(|(facet, _)| facet.cell as usize)
    }

    /// The functional $b \mapsto G(a, b)$ of the velocity, as a load at the nodes.
    ///
    /// Shapes: `velocity` and the result `3 n_points`. Cost: a pass over the facets. The same for any number of threads.
    /// # Errors
    /// A velocity of the wrong length or not finite; an inverted cell at the surface.
    pub fn functional(&self, velocity: &[f64]) -> Result<Vec<f64>, FemError> {
        check_array("the velocity", velocity, 3 * self.mesh.n_points())?;
        let own = self.of_facets(|facet, part| {
            let nodes = &self.mesh.cells()[facet.cell as usize];
            let mut load = [Vec3::zeros(); 10];
            self.at_points(facet, part, |gradients, normal, weight| {
                let shear = shear(&velocity_gradient(nodes, velocity, gradients), normal);
                for (own, gradient) in load.iter_mut().zip(gradients) {
                    // The shear is tangential, so the other flow's need not be made so.
                    *own += weight * (shear * gradient.dot(normal) + normal * shear.dot(gradient));
                }
            })?;
            Ok(load)
        })?;
        let mut functional = vec![0.0; velocity.len()];
        for ((facet, _), load) in self.facets.iter().zip(own) {
            for (&node, part) in self.mesh.cells()[facet.cell as usize].iter().zip(&load) {
                for axis in 0..3 {
                    functional[3 * node as usize + axis] += part[axis];
                }
            }
        }
        Ok(functional)
    }

    /// Contribution of each facet to $G(a, b)$.
    ///
    /// Shapes: `a` and `b` `3 n_points`. Cost: a pass over the facets. The same for any number of threads.
    /// # Errors
    /// As [`FacetGeometry::functional`].
    pub fn indicators(&self, a: &[f64], b: &[f64]) -> Result<Vec<f64>, FemError> {
        for velocity in [a, b] {
            check_array("the velocity", velocity, 3 * self.mesh.n_points())?;
        }
        self.of_facets(|facet, part| {
            let nodes = &self.mesh.cells()[facet.cell as usize];
            let mut indicator = 0.0;
            self.at_points(facet, part, |gradients, normal, weight| {
                let [a, b] = [a, b].map(|u| shear(&velocity_gradient(nodes, u, gradients), normal));
                indicator += weight * a.dot(&b);
            })?;
            Ok(indicator)
        })
    }

    fn of_facets<T: Send>(
        &self,
        of: impl Fn(&Facet, &CurvedBoundary) -> Result<T, FemError> + Sync,
    ) -> Result<Vec<T>, FemError> {
        let facets = self.facets.par_iter().with_min_len(64);
        facets.map(|(facet, part)| of(facet, part)).collect()
    }

    /// Calls `at` with the shape gradients of the cell, the unit normal out of the fluid, and the weight times the height $\delta$, at the
    /// quadrature points of a facet.
    fn at_points(
        &self,
        facet: &Facet,
        part: &CurvedBoundary,
        mut at: impl FnMut(&[Vec3; 10], &Vec3, f64),
    ) -> Result<(), FemError> {
        let cell = facet.cell as usize;
        let (positions, surface) = (self.mesh.cell_points(cell), facet_nodes(self.mesh, facet));
        for point in facet_degree_6() {
            let inside = facet_cell_point(facet, &self.mesh.cells()[cell], point);
            let map = MapAt::new(cell, &positions, &inside)?;
            let (x, normal) = position_and_normal(&surface, point);
            let area = normal.norm();
            let out = x - part.centre;
            let height = match part.is_wall {
                true => out.norm() - part.radius,
                false => part.radius - out.norm(),
            };
            at(
                &map.gradients(&inside),
                &(normal / area),
                height * area * point.weight,
            );
        }
        Ok(())
    }
}

/// The tangential part of $2 D n$.
fn shear(gradient: &Matrix3<f64>, normal: &Vec3) -> Vec3 {
    let traction = gradient * normal + gradient.tr_mul(normal);
    traction - normal * normal.dot(&traction)
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::LinearTets;

    /// One cube as the fluid in a ball around it: all heights are known.
    fn cube() -> TetMesh {
        TetMesh::straight(LinearTets::cube(2)).unwrap()
    }

    #[test]
    fn rigid_motions_shear_nothing_and_shear_flow_shears_by_its_rate() {
        let mesh = cube();
        let part = CurvedBoundary {
            tag: mesh.tag("z1").unwrap(),
            centre: Vec3::new(0.5, 0.5, 0.5),
            radius: 1.0,
            is_wall: true,
        };
        let geometry = FacetGeometry::new(&mesh, &[part]).unwrap();
        let flow = |f: fn(&Vec3) -> Vec3| -> Vec<f64> {
            let values = mesh.points().iter().map(f);
            values.flat_map(|u| [u.x, u.y, u.z]).collect()
        };
        let rigid = flow(|x| Vec3::new(1.0, 2.0, 3.0) + Vec3::new(0.3, -0.2, 0.1).cross(x));
        let sheared = flow(|x| Vec3::new(2.0 * x.z, 0.0, 0.0));
        let stretched = flow(|x| Vec3::new(x.x, x.y, -2.0 * x.z));
        let sum = |a: &[f64], b: &[f64]| geometry.indicators(a, b).unwrap().iter().sum::<f64>();
        assert!(sum(&rigid, &sheared).abs() < 1e-14);
        assert!(sum(&stretched, &sheared).abs() < 1e-14);
        // The wall is outside: minus the mean of 1 - |x - c| over the side, times the square of the rate.
        let height = 1.0 - mean_distance();
        assert!((sum(&sheared, &sheared) + 4.0 * height).abs() < 1e-4);
        // The functional is the same form.
        let load = geometry.functional(&sheared).unwrap();
        for other in [&rigid, &sheared, &stretched] {
            let dot: f64 = load.iter().zip(other).map(|(a, b)| a * b).sum();
            assert!((dot - sum(&sheared, other)).abs() < 1e-13);
        }
    }

    /// Mean of $\sqrt{x^2 + y^2 + 1/4}$ over the square of side one about the origin, by midpoints.
    fn mean_distance() -> f64 {
        let n = 200;
        let at = |k: usize| (k as f64 + 0.5) / n as f64 - 0.5;
        let sum: f64 = (0..n * n)
            .map(|k| (at(k / n).powi(2) + at(k % n).powi(2) + 0.25).sqrt())
            .sum();
        sum / (n * n) as f64
    }
}
