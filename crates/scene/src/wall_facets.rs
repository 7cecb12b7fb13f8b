//! The walls of a mesh: their facets, and the distance of a body from them.

use std::sync::Arc;

use mesh::{BoundingBox, BoxTree, TetMesh};
use nalgebra::{Isometry3, Vector3};

use crate::hull_distance::distance_from_triangle;
use crate::shape::Shape;

/// The facets of the walls of a mesh; clones share them.
#[derive(Clone)]
pub struct WallFacets(Arc<Facets>);

struct Facets {
    triangles: Vec<[Vector3<f64>; 3]>,
    tree: BoxTree,
}

impl WallFacets {
    /// The facets of some parts of the boundary of a mesh; `None` if it lacks one of them.
    ///
    /// Facets of curved parts are four triangles each.
    pub(crate) fn new(mesh: &TetMesh, walls: &[String]) -> Option<Self> {
        let mut triangles = Vec::new();
        for wall in walls {
            let (surface, _) = mesh.boundary_part(wall).ok()?;
            let corners = |triangle: &[u32; 3]| triangle.map(|k| surface.points[k as usize]);
            triangles.extend(surface.triangles.iter().map(corners));
        }
        let boxes = triangles.iter().map(BoundingBox::around).enumerate();
        let tree = BoxTree::new(boxes);
        Some(Self(Arc::new(Facets { triangles, tree })))
    }

    /// Smallest distance between a facet and the convex hull of a body, negative where they
    /// overlap; infinite without facets.
    pub(crate) fn clearance(&self, shape: &Shape, pose: &Isometry3<f64>) -> f64 {
        let (centre, radius) = (pose.translation.vector, shape.bounding_radius());
        let at_least = |around: &BoundingBox| around.distance(&centre) - radius;
        let distance = |number: usize, _: f64| {
            let triangle = self.0.triangles.get(number)?;
            Some((
                distance_from_triangle(shape, &pose.rotation, &centre, triangle),
                (),
            ))
        };
        let nearest = self.0.tree.best(f64::INFINITY, at_least, distance);
        nearest.map_or(f64::INFINITY, |(_, distance, ())| distance)
    }
}

impl std::fmt::Debug for WallFacets {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} facets", self.0.triangles.len())
    }
}

impl PartialEq for WallFacets {
    fn eq(&self, other: &Self) -> bool {
        self.0.triangles == other.0.triangles
    }
}
