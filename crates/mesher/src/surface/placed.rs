//! Shapes moved and turned.

use mesh::{Surface, SurfaceMesh, Vec3};
use nalgebra::{Isometry3, Point3};

/// A shape in its own coordinates, moved and turned by a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed<S> {
    /// The shape.
    pub shape: S,
    /// Position of the origin of the shape's coordinates, and their rotation.
    pub pose: Isometry3<f64>,
}

impl<S: Surface> Placed<S> {
    fn own(&self, point: Vec3) -> Vec3 {
        self.pose
            .inverse_transform_point(&Point3::from(point))
            .coords
    }

    fn placed(&self, point: Vec3) -> Vec3 {
        self.pose.transform_point(&Point3::from(point)).coords
    }
}

impl<S: Surface> Surface for Placed<S> {
    fn signed_distance(&self, point: Vec3) -> f64 {
        self.shape.signed_distance(self.own(point))
    }

    fn closest_point(&self, point: Vec3) -> Vec3 {
        self.placed(self.shape.closest_point(self.own(point)))
    }

    fn closest_on_sharp_edges(&self, point: Vec3) -> Option<Vec3> {
        let closest = self.shape.closest_on_sharp_edges(self.own(point))?;
        Some(self.placed(closest))
    }

    fn bounding_ball(&self) -> (Vec3, f64) {
        let (centre, radius) = self.shape.bounding_ball();
        (self.placed(centre), radius)
    }

    fn centre(&self) -> Vec3 {
        self.placed(self.shape.centre())
    }

    fn volume(&self) -> f64 {
        self.shape.volume()
    }

    fn is_convex(&self) -> bool {
        self.shape.is_convex()
    }

    fn reach(&self) -> f64 {
        self.shape.reach()
    }

    fn inradius(&self) -> f64 {
        self.shape.inradius()
    }

    fn curvature_size(&self, point: Vec3, factor: f64, growth: f64) -> f64 {
        self.shape.curvature_size(self.own(point), factor, growth)
    }

    fn triangulation(&self) -> Option<SurfaceMesh> {
        let mut mesh = self.shape.triangulation()?;
        mesh.points.iter_mut().for_each(|p| *p = self.placed(*p));
        Some(mesh)
    }

    fn has_fine_triangulation(&self) -> bool {
        self.shape.has_fine_triangulation()
    }
}
