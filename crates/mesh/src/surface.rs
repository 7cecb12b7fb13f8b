//! True surfaces, as the mesh generator sees them, and their triangles.

use crate::Vec3;

/// A closed surface around which, or inside which, a mesh can be generated.
///
/// Also used to move boundary nodes onto the true surface. Distances are negative inside the shape
/// and positive outside it, for bodies and containers alike.
/// [`check_surface`](crate::check_surface) tests whether the functions of an implementation agree.
pub trait Surface: Sync {
    /// Signed distance from `point` to the surface, negative inside the shape.
    fn signed_distance(&self, point: Vec3) -> f64;

    /// Whether the ball of this radius about `centre` is inside the shape.
    fn contains_ball(&self, centre: Vec3, radius: f64) -> bool {
        -self.signed_distance(centre) >= radius
    }

    /// Point of the surface closest to `point`.
    fn closest_point(&self, point: Vec3) -> Vec3;

    /// Outward unit normal at the point of the surface closest to `point`.
    ///
    /// By default the gradient of the signed distance, from differences of fourth order over a
    /// thousandth of the reach: its error is about 1e-12.
    fn normal(&self, point: Vec3) -> Vec3 {
        let (foot, h) = (self.closest_point(point), 1e-3 * self.reach());
        let difference = |axis: usize, step: f64| {
            let mut arm = Vec3::zeros();
            arm[axis] = step;
            self.signed_distance(foot + arm) - self.signed_distance(foot - arm)
        };
        let gradient = |axis| 8.0 * difference(axis, h) - difference(axis, 2.0 * h);
        Vec3::new(gradient(0), gradient(1), gradient(2)).normalize()
    }

    /// Closest point to `point` on the sharp edges; `None`, the default, if there are none.
    fn closest_on_sharp_edges(&self, _point: Vec3) -> Option<Vec3> {
        None
    }

    /// Centre and radius of a ball that contains the shape.
    fn bounding_ball(&self) -> (Vec3, f64);

    /// The point that moves with the shape; inside it if the shape is convex.
    fn centre(&self) -> Vec3 {
        self.bounding_ball().0
    }

    /// Volume enclosed by the surface.
    fn volume(&self) -> f64;

    /// Whether the shape is convex. Other shapes need a [`triangulation`](Self::triangulation).
    fn is_convex(&self) -> bool;

    /// Radius of the largest balls that fit to both sides of every point of the surface (reach),
    /// except near sharp edges.
    ///
    /// At most the smallest radius of curvature, and half the width of the narrowest neck of the
    /// shape or of the space around it (Federer 1959). It bounds the length of edges that can
    /// follow the surface.
    fn reach(&self) -> f64;

    /// Radius of the largest ball inside the shape.
    fn inradius(&self) -> f64 {
        self.reach()
    }

    /// Largest edge length at `point` for edges of `factor` radii of curvature on the surface.
    ///
    /// The minimum of `factor ρ(y) + growth |x - y|` over the points `y` of the surface, with the
    /// smaller radius of curvature `ρ(y)`, or a lower bound. The default stands for a surface with
    /// the radius [`reach`](Self::reach) everywhere.
    fn curvature_size(&self, point: Vec3, factor: f64, growth: f64) -> f64 {
        factor * self.reach() + growth * self.signed_distance(point).max(0.0)
    }

    /// A coarse triangulation with vertices on the surface, which is refined.
    ///
    /// Required unless the shape is convex. `None`, the default, stands for a convex shape whose
    /// coarse vertices have evenly distributed normals; it must not be slender.
    fn triangulation(&self) -> Option<SurfaceMesh> {
        None
    }

    /// Whether the triangulation may be finer than a mesh needs, so that it is made coarser too.
    fn has_fine_triangulation(&self) -> bool {
        false
    }
}

/// A closed triangulated surface; triangles are counterclockwise as seen from outside the shape.
#[derive(Clone, Debug, Default)]
pub struct SurfaceMesh {
    /// Vertices.
    pub points: Vec<Vec3>,
    /// Vertex numbers of the triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Sharp edges, which are kept when the triangulation is refined; empty for smooth shapes.
    pub sharp_edges: Vec<[u32; 2]>,
    /// Vertices at which sharp edges end, meet or turn; they stay where they are.
    pub corners: Vec<u32>,
}
