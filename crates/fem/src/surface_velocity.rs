//! Velocities of surfaces relative to rigid motions: nodal values, flux and moment.

use mesh::{TetMesh, Vec3};
use nalgebra::Matrix3;

use crate::error::{FemError, check_vectors};
use crate::quadrature::{FacetPoint, facet_degree_6};
use crate::surface::{facet_nodes, position_and_normal, tagged_facets};

/// Velocity of the boundary part with a tag relative to a rigid motion, at a point on the surface.
///
/// Near the surface, the function has the value of the closest point of the surface, or that of a
/// flow that has this velocity on the surface.
pub type SurfaceVelocity<'a> = dyn Fn(u16, Vec3) -> Vec3 + Sync + 'a;

/// Nodal values of a [`SurfaceVelocity`] on one part of the boundary.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct NodalSurfaceVelocity {
    /// Node and velocity `s_j`, by ascending nodes. Their interpolant `s_h` has exactly the given
    /// flux `∮ s_h · n dS`, with the normal into the fluid.
    pub values: Vec<(u32, Vec3)>,
    /// `∮ s_h n^T dS` with the normal into the fluid; that of the part in the mesh if symmetry
    /// planes cut the surface.
    pub moment: Matrix3<f64>,
}

/// Normal components at nodes on symmetry planes that are rounding, relative to the largest speed
/// of the surface: those of axes that turn within a plane by quaternions are a few 1e-16.
const MAX_NORMAL_ROUNDING: f64 = 1e-9;

/// Interpolates the velocity of the facets with `tag`, with a given flux into the fluid.
///
/// `flux` is that of the part in the mesh: zero for slip, the rate of the volume for a body that
/// grows. The interpolant has another flux by an interpolation error. In a container the flow would
/// have no solution, so the smallest nodal values with the difference are subtracted.
///
/// Where symmetry planes cut the surface, the values are those on the whole surface, if the
/// velocity is symmetric: its normal component on a plane is then zero, and set to zero if it is
/// rounding. Nodes that another part of the boundary shares keep their values, which are those of
/// both parts.
///
/// # Errors
/// No facet has the tag; a velocity that is not finite.
pub fn nodal_surface_velocity(
    mesh: &TetMesh,
    tag: u16,
    velocity: &SurfaceVelocity<'_>,
    flux: f64,
) -> Result<NodalSurfaceVelocity, FemError> {
    let weights = normal_weights(mesh, tag)?;
    let value = |&(node, _): &(u32, Vec3)| velocity(tag, mesh.points()[node as usize]);
    let mut values: Vec<Vec3> = weights.iter().map(value).collect();
    check_vectors("the velocity of a surface", &values, weights.len())?;
    let normals: Vec<Vec3> = weights.iter().map(|(_, normal)| *normal).collect();
    let mut planes = planes_through(mesh, weights.iter().map(|(node, _)| *node as usize));
    let largest = values.iter().map(Vec3::amax).fold(0.0, f64::max);
    for (value, planes) in values.iter_mut().zip(&planes) {
        for axis in (0..3).filter(|&axis| planes[axis]) {
            if value[axis].abs() <= MAX_NORMAL_ROUNDING * largest {
                value[axis] = 0.0;
            }
        }
    }
    let mut is_shared = vec![false; mesh.n_points()];
    let others = mesh.facets().iter().filter(|facet| facet.tag != tag);
    for facet in others.filter(|facet| !mesh.is_symmetry_plane(facet.tag)) {
        facet
            .nodes
            .iter()
            .for_each(|&node| is_shared[node as usize] = true);
    }
    for ((node, _), planes) in weights.iter().zip(&mut planes) {
        if is_shared[*node as usize] {
            // No component is free.
            *planes = [true; 3];
        }
    }
    // The weights have the normal out of the fluid.
    set_flux(&mut values, &normals, &planes, -flux);
    let moment = -(normals.iter().zip(&values))
        .map(|(normal, value)| value * normal.transpose())
        .sum::<Matrix3<f64>>();
    let nodes = weights.iter().map(|(node, _)| *node);
    Ok(NodalSurfaceVelocity {
        values: nodes.zip(values).collect(),
        moment,
    })
}

/// For each of these nodes, the axes to which the symmetry planes through it are normal.
pub(crate) fn planes_through(mesh: &TetMesh, nodes: impl Iterator<Item = usize>) -> Vec<[bool; 3]> {
    let on_planes = mesh.nodes_on_symmetry_planes();
    let place = |node: usize| on_planes.binary_search_by_key(&node, |(node, _)| *node as usize);
    nodes
        .map(|node| place(node).map_or([false; 3], |k| on_planes[k].1))
        .collect()
}

/// Subtracts the smallest values for which `sum_j w_j · s_j` becomes the given flux.
///
/// `planes` are the normals of the symmetry planes on which the nodes lie. The values are the
/// smallest ones on the whole surface, where a node on a plane has the tangential part of its
/// weight twice, once from each side, and no normal one. Nodes on all three planes keep their
/// values.
pub(crate) fn set_flux(values: &mut [Vec3], weights: &[Vec3], planes: &[[bool; 3]], given: f64) {
    let of_whole = |(weight, planes): (&Vec3, &[bool; 3])| {
        let mut whole = *weight;
        for axis in (0..3).filter(|&axis| planes[axis]) {
            whole *= 2.0;
            whole[axis] = 0.0;
        }
        whole
    };
    let wholes: Vec<Vec3> = weights.iter().zip(planes).map(of_whole).collect();
    let sum = |vectors: &[Vec3]| -> f64 {
        let pairs = vectors.iter().zip(weights);
        pairs.map(|(vector, weight)| vector.dot(weight)).sum()
    };
    let (excess, size) = (sum(values) - given, sum(&wholes));
    if size > 0.0 {
        let factor = excess / size;
        (values.iter_mut().zip(&wholes)).for_each(|(value, whole)| *value -= factor * whole);
    }
}

/// `∮ N_j n dS` of the nodes on the facets with `tag`, with the normal out of the fluid.
///
/// Exact for quadratic facets: the integrand has degree 4.
fn normal_weights(mesh: &TetMesh, tag: u16) -> Result<Vec<(u32, Vec3)>, FemError> {
    let mut terms: Vec<(u32, Vec3)> = Vec::new();
    for facet in tagged_facets(mesh, tag)? {
        let nodes = facet_nodes(mesh, facet);
        let mut weights = [Vec3::zeros(); 6];
        for point in facet_degree_6() {
            let (_, normal) = position_and_normal(&nodes, point);
            for (weight, shape) in weights.iter_mut().zip(facet_shape_functions(point)) {
                *weight += normal * (point.weight * shape);
            }
        }
        terms.extend(facet.nodes.into_iter().zip(weights));
    }
    // A stable sort, so that the order of the sums is fixed.
    terms.sort_by_key(|(node, _)| *node);
    let groups = terms.chunk_by(|a, b| a.0 == b.0);
    Ok(groups
        .map(|group| (group[0].0, group.iter().map(|(_, weight)| weight).sum()))
        .collect())
}

/// The quadratic shape functions of a facet: vertices, then midside nodes of the edges 01, 12, 20.
pub(crate) fn facet_shape_functions(point: &FacetPoint) -> [f64; 6] {
    let l = point.barycentric;
    let vertex = |i: usize| l[i] * (2.0 * l[i] - 1.0);
    let midside = |i: usize| 4.0 * l[i] * l[(i + 1) % 3];
    [
        vertex(0),
        vertex(1),
        vertex(2),
        midside(0),
        midside(1),
        midside(2),
    ]
}

#[cfg(test)]
mod tests {
    use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};

    use super::*;

    /// `∮ (G x) n^T dS = |B| G`, for the discrete body and a linear velocity `G x`.
    #[test]
    fn linear_velocities_have_their_gradient_as_moment_and_no_flux() {
        let sphere = Sphere::new(Vec3::zeros(), 1.0);
        let ball = Container::Ball(Sphere {
            radius: 3.0,
            ..sphere
        });
        let body = MeshedBody::new("sphere", &sphere, 0.7);
        let tets = generate(&[body], &ball, &GenerateParams::default()).unwrap();
        let mesh = TetMesh::curved(tets.mesh, &[("sphere", &sphere)]).unwrap();
        let tag = mesh.tag("sphere").unwrap();
        let shear = |_: u16, x: Vec3| Vec3::new(2.0 * x.y, 0.0, x.x);
        let nodal = nodal_surface_velocity(&mesh, tag, &shear, 0.0).unwrap();
        let volume = crate::surface_measures(&mesh, tag).unwrap().volume;
        let gradient = Matrix3::new(0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0);
        assert!((nodal.moment - volume * gradient).norm() < 1e-12);
        for (node, value) in &nodal.values {
            let x = mesh.points()[*node as usize];
            assert!((value - shear(tag, x)).norm() < 1e-13);
        }
        // The flux of a source is that of the discrete body, 3 |B|, unless another one is given.
        let weights = normal_weights(&mesh, tag).unwrap();
        for given in [0.0, 3.0 * volume, 7.0] {
            let source = nodal_surface_velocity(&mesh, tag, &|_, x| x, given).unwrap();
            let flux: f64 = -(source.values.iter().zip(&weights))
                .map(|((_, value), (_, weight))| value.dot(weight))
                .sum::<f64>();
            assert!((flux - given).abs() < 1e-12);
            if given == 3.0 * volume {
                assert!((source.moment - volume * Matrix3::identity()).norm() < 1e-12);
            }
        }
    }
}
