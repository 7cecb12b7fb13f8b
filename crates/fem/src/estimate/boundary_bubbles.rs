//! Velocities of surfaces in cubic bubbles: what quadratic facets miss of them.

use mesh::{Facet, TetMesh, Vec3};

use super::cubic::CubicExtension;
use crate::error::{FemError, check_length};
use crate::quadrature::{FacetPoint, facet_degree_6};
use crate::surface::{facet_nodes, position_and_normal, tagged_facets};
use crate::surface_velocity::{SurfaceVelocity, facet_shape_functions, planes_through, set_flux};

/// A bubble on the boundary, in the order of the bubbles of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Place {
    /// Midside node of an edge.
    Edge(u32),
    /// Vertices of a face, ascending.
    Face([u32; 3]),
}

/// A bubble on the boundary: its place, its coefficient, and `∮ φ n dS`.
type Term = (Place, Vec3, Vec3);

/// Bubbles of a velocity of a surface: what quadratic facets miss of it.
///
/// Quadratic facets already interpolate nodal velocities. The bubbles of edges interpolate the odd
/// part of what is missed at the quarter points of each edge; the bubble of a facet makes its mean
/// exact, so that what is still missed has an effect of higher order on forces. The flux of the
/// bubbles is removed, as that of the nodal values, on the whole surface if symmetry planes cut it.
#[derive(Clone, Debug)]
pub struct BoundaryBubbles {
    /// Ascending by place.
    values: Vec<(Place, Vec3)>,
}

impl BoundaryBubbles {
    /// The bubbles of the facets with `tag` for a velocity of the surface.
    ///
    /// `nodal` has one velocity per node of the mesh.
    ///
    /// # Errors
    /// Nodal velocities of the wrong length; no facet has the tag.
    pub fn new(
        mesh: &TetMesh,
        tag: u16,
        velocity: &SurfaceVelocity<'_>,
        nodal: &[Vec3],
    ) -> Result<Self, FemError> {
        check_length("the nodal velocities", nodal.len(), mesh.n_points())?;
        let mut terms: Vec<Term> = Vec::new();
        for facet in tagged_facets(mesh, tag)? {
            let missed = |barycentric: [f64; 3]| {
                let point = FacetPoint {
                    barycentric,
                    weight: 0.0,
                };
                let shapes = facet_shape_functions(&point);
                let nodes = facet_nodes(mesh, facet);
                let x: Vec3 = nodes.iter().zip(shapes).map(|(x, n)| x * n).sum();
                let known = facet.nodes.iter().zip(shapes);
                let known: Vec3 = known.map(|(&node, n)| nodal[node as usize] * n).sum();
                velocity(tag, x) - known
            };
            terms.extend(of_facet(facet, mesh, missed));
        }
        terms.sort_by_key(|(place, ..)| *place);
        // Both facets of an edge give its bubble the same coefficient.
        let groups: Vec<Term> = (terms.chunk_by(|a, b| a.0 == b.0))
            .map(|group| {
                let weight = group.iter().map(|(.., weight)| weight).sum();
                (group[0].0, group[0].1, weight)
            })
            .collect();
        let weights: Vec<Vec3> = groups.iter().map(|(.., weight)| *weight).collect();
        let mut values: Vec<Vec3> = groups.iter().map(|(_, value, _)| *value).collect();
        // An edge is on the planes of its midside node, a facet on none.
        let nodes = groups.iter().map(|(place, ..)| match place {
            Place::Edge(node) => *node as usize,
            Place::Face(_) => usize::MAX,
        });
        let planes = planes_through(mesh, nodes);
        set_flux(&mut values, &weights, &planes, 0.0);
        let places = groups.iter().map(|(place, ..)| *place);
        Ok(Self {
            values: places.zip(values).collect(),
        })
    }

    fn value(&self, place: Place) -> Option<Vec3> {
        let found = self
            .values
            .binary_search_by_key(&place, |(place, _)| *place);
        found.ok().map(|k| self.values[k].1)
    }
}

impl CubicExtension<'_> {
    /// Writes the bubbles of the facets with `tag` into dofs.
    ///
    /// `number` is the number of a node of this mesh in the mesh of the `bubbles`, of which this
    /// mesh may be a part with nodes in the same order.
    ///
    /// # Errors
    /// Dofs of the wrong length.
    pub fn interpolate(
        &self,
        tag: u16,
        bubbles: &BoundaryBubbles,
        number: impl Fn(u32) -> u32,
        dofs: &mut [f64],
    ) -> Result<(), FemError> {
        let mesh = self.mesh();
        check_length("the extension", dofs.len(), self.len())?;
        for facet in mesh.facets().iter().filter(|facet| facet.tag == tag) {
            let first = mesh.n_vertices();
            let edges = facet.nodes[3..].iter().map(|&node| {
                let bubble = node as usize - first;
                (bubble, Place::Edge(number(node)))
            });
            let face = (self.face_bubble(facet), face(facet, &number));
            for (bubble, place) in edges.chain([face]) {
                if let Some(value) = bubbles.value(place) {
                    dofs[3 * bubble..3 * bubble + 3].copy_from_slice(value.as_slice());
                }
            }
        }
        Ok(())
    }
}

/// The place of the face bubble of a facet.
fn face(facet: &Facet, number: impl Fn(u32) -> u32) -> Place {
    let mut vertices = [0, 1, 2].map(|k| number(facet.nodes[k]));
    vertices.sort_unstable();
    Place::Face(vertices)
}

/// The three edge bubbles and the face bubble of a facet.
fn of_facet(facet: &Facet, mesh: &TetMesh, missed: impl Fn([f64; 3]) -> Vec3) -> [Term; 4] {
    let nodes = facet_nodes(mesh, facet);
    let orientation = |edge: usize| {
        let [a, b] = [facet.nodes[edge], facet.nodes[(edge + 1) % 3]];
        if a > b { -1.0 } else { 1.0 }
    };
    // The bubble of an edge is ± 3/32 at its quarter points.
    let of_edges: [Vec3; 3] = std::array::from_fn(|k| {
        let at = |fraction: f64| {
            let mut barycentric = [0.0; 3];
            (barycentric[k], barycentric[(k + 1) % 3]) = (fraction, 1.0 - fraction);
            missed(barycentric)
        };
        (at(0.75) - at(0.25)) * (orientation(k) * 16.0 / 3.0)
    });
    let mut weights = [Vec3::zeros(); 4];
    let (mut integral, mut of_bubble) = (Vec3::zeros(), 0.0);
    for point in facet_degree_6() {
        let (_, normal) = position_and_normal(&nodes, point);
        let l = point.barycentric;
        let area = point.weight * normal.norm();
        integral += area * missed(l);
        for (edge, weight) in weights[..3].iter_mut().enumerate() {
            let (a, b) = (l[edge], l[(edge + 1) % 3]);
            let bubble = orientation(edge) * a * b * (a - b);
            *weight += normal * (point.weight * bubble);
            integral -= of_edges[edge] * (area * bubble);
        }
        let bubble = l[0] * l[1] * l[2];
        weights[3] += normal * (point.weight * bubble);
        of_bubble += area * bubble;
    }
    std::array::from_fn(|k| match facet.nodes.get(3 + k) {
        Some(&node) => (Place::Edge(node), of_edges[k], weights[k]),
        None => (face(facet, |node| node), integral / of_bubble, weights[3]),
    })
}
