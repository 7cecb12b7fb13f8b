//! Closed surfaces of flat triangles: closest points and signed distances.

use mesh::{BoundingBox, BoxTree, Surface, SurfaceMesh, Vec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// Number of samples of the distance along each edge of a cube around the surface.
const SAMPLES: usize = 24;

/// A closed surface of flat triangles, with a tree of bounding boxes.
///
/// Triangles are counterclockwise as seen from outside. Several separate surfaces, and surfaces
/// that touch themselves in edges or vertices, are allowed. The sign of a distance follows from the
/// normal at the closest point, at edges and vertices the mean weighted by angles (Bærentzen &
/// Aanæs 2005).
pub(crate) struct FlatTriangles {
    mesh: SurfaceMesh,
    tree: BoxTree,
    /// Sum of the unit normals at each edge, smaller vertex first.
    edge_normals: HashMap<[u32; 2], Vec3>,
    /// Sum of the unit normals at each vertex, weighted by the angles of the triangles.
    vertex_normals: Vec<Vec3>,
    ball: (Vec3, f64),
    /// Distances at the centres of cubic cells, which bound those around them.
    samples: Option<Samples>,
}

/// Signed distances at the centres of the cells of a grid.
struct Samples {
    low: Vec3,
    width: f64,
    distances: Vec<f64>,
}

/// The part of a triangle on which the closest point lies, by the positions of its vertices.
#[derive(Clone, Copy)]
enum Feature {
    Face,
    Edge(usize, usize),
    Vertex(usize),
}

impl FlatTriangles {
    /// Builds the tree. Cost: O(n log² n).
    pub fn new(mesh: SurfaceMesh) -> Self {
        let boxes = mesh.triangles.iter().map(|triangle| {
            let corners = triangle.map(|v| mesh.points[v as usize]);
            BoundingBox::around(&corners)
        });
        let tree = BoxTree::new(boxes.enumerate());
        let mut edge_normals: HashMap<[u32; 2], Vec3> = HashMap::new();
        let mut vertex_normals = vec![Vec3::zeros(); mesh.points.len()];
        for tri in &mesh.triangles {
            let x = tri.map(|v| mesh.points[v as usize]);
            let normal = unit((x[1] - x[0]).cross(&(x[2] - x[0])));
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let edge = [tri[i].min(tri[j]), tri[i].max(tri[j])];
                *edge_normals.entry(edge).or_default() += normal;
                vertex_normals[tri[i] as usize] += (x[j] - x[i]).angle(&(x[k] - x[i])) * normal;
            }
        }
        let vertices = || (mesh.triangles.iter().flatten()).map(|&v| &mesh.points[v as usize]);
        let BoundingBox { min, max } = BoundingBox::around(vertices());
        let centre = 0.5 * (min + max);
        let radius = (vertices().map(|x| (x - centre).norm())).fold(0.0, f64::max);
        Self {
            mesh,
            tree,
            edge_normals,
            vertex_normals,
            ball: (centre, radius),
            samples: None,
        }
    }

    /// The surface with samples that answer most of the questions whether it contains a ball.
    ///
    /// They take as long as [`SAMPLES`] cubed distances, in parallel.
    pub fn with_samples(mut self) -> Self {
        let (centre, radius) = self.ball;
        let low = centre - Vec3::repeat(radius);
        let width = 2.0 * radius / SAMPLES as f64;
        let distances = (0..SAMPLES.pow(3))
            .into_par_iter()
            .map(|k| {
                let cell = [k % SAMPLES, k / SAMPLES % SAMPLES, k / SAMPLES / SAMPLES];
                let at = Vec3::from(cell.map(|c| (c as f64 + 0.5) * width));
                self.signed_distance(low + at)
            })
            .collect();
        self.samples = Some(Samples {
            low,
            width,
            distances,
        });
        self
    }

    /// The triangles.
    pub fn mesh(&self) -> &SurfaceMesh {
        &self.mesh
    }

    /// The closest point, with its triangle and the feature that it lies on.
    fn closest(&self, point: Vec3) -> Option<(Vec3, usize, Feature)> {
        let cost = |t: usize, _: f64| {
            let corners = self.mesh.triangles[t].map(|v| self.mesh.points[v as usize]);
            let (foot, feature) = closest_on_triangle(point, corners);
            Some(((point - foot).norm(), (foot, feature)))
        };
        let bound = |around: &BoundingBox| around.distance(&point);
        let best = self.tree.best(f64::INFINITY, bound, cost);
        best.map(|(t, _, (foot, feature))| (foot, t, feature))
    }
}

impl Surface for FlatTriangles {
    fn signed_distance(&self, point: Vec3) -> f64 {
        let Some((foot, t, feature)) = self.closest(point) else {
            return f64::INFINITY;
        };
        let tri = self.mesh.triangles[t];
        let arm = point - foot;
        let normal = match feature {
            Feature::Face => {
                let x = tri.map(|v| self.mesh.points[v as usize]);
                (x[1] - x[0]).cross(&(x[2] - x[0]))
            }
            Feature::Edge(i, j) => {
                let edge = [tri[i].min(tri[j]), tri[i].max(tri[j])];
                self.edge_normals.get(&edge).copied().unwrap_or_default()
            }
            Feature::Vertex(i) => self.vertex_normals[tri[i] as usize],
        };
        arm.norm().copysign(arm.dot(&normal))
    }

    fn contains_ball(&self, centre: Vec3, radius: f64) -> bool {
        let bound = self.samples.as_ref().and_then(|s| s.bound(centre));
        bound.is_some_and(|bound| -bound > radius) || -self.signed_distance(centre) >= radius
    }

    fn closest_point(&self, point: Vec3) -> Vec3 {
        self.closest(point).map_or(point, |(foot, ..)| foot)
    }

    fn bounding_ball(&self) -> (Vec3, f64) {
        self.ball
    }

    fn volume(&self) -> f64 {
        let of_tet = |tri: &[u32; 3]| {
            let [a, b, c] = tri.map(|v| self.mesh.points[v as usize] - self.ball.0);
            a.dot(&b.cross(&c)) / 6.0
        };
        self.mesh.triangles.iter().map(of_tet).sum()
    }

    fn is_convex(&self) -> bool {
        false
    }

    /// Zero: at its edges the surface has no tangential balls.
    fn reach(&self) -> f64 {
        0.0
    }

    fn triangulation(&self) -> Option<SurfaceMesh> {
        Some(self.mesh.clone())
    }
}

impl Samples {
    /// Upper bound of the signed distance, if `point` is in the grid: it changes by at most the
    /// distance from a sample.
    fn bound(&self, point: Vec3) -> Option<f64> {
        let cell = ((point - self.low) / self.width).map(|c| c.floor() as usize);
        if cell.max() >= SAMPLES {
            return None;
        }
        let at = self.low + self.width * cell.map(|c| c as f64 + 0.5);
        let sample = self.distances[cell.x + SAMPLES * (cell.y + SAMPLES * cell.z)];
        Some(sample + (point - at).norm())
    }
}

/// The vector scaled to length one; zero stays zero.
fn unit(v: Vec3) -> Vec3 {
    v.try_normalize(0.0).unwrap_or_default()
}

/// Closest point of a triangle (Ericson 2005, 5.1.5), and the feature that it lies on.
fn closest_on_triangle(p: Vec3, [a, b, c]: [Vec3; 3]) -> (Vec3, Feature) {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(&(p - a)), ac.dot(&(p - a)));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (a, Feature::Vertex(0));
    }
    let (d3, d4) = (ab.dot(&(p - b)), ac.dot(&(p - b)));
    if d3 >= 0.0 && d4 <= d3 {
        return (b, Feature::Vertex(1));
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (a + d1 / (d1 - d3) * ab, Feature::Edge(0, 1));
    }
    let (d5, d6) = (ab.dot(&(p - c)), ac.dot(&(p - c)));
    if d6 >= 0.0 && d5 <= d6 {
        return (c, Feature::Vertex(2));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (a + d2 / (d2 - d6) * ac, Feature::Edge(0, 2));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let part = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return (b + part * (c - b), Feature::Edge(1, 2));
    }
    let sum = va + vb + vc;
    (a + vb / sum * ab + vc / sum * ac, Feature::Face)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The surface of a cube with side 2 around the origin, 12 triangles.
    fn cube() -> FlatTriangles {
        let points = (0..8)
            .map(|k| Vec3::from([0, 1, 2].map(|axis| f64::from(k >> axis & 1) * 2.0 - 1.0)))
            .collect();
        let mut triangles = Vec::new();
        for axis in 0..3u32 {
            let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
            let top = 1 << axis;
            triangles.push([top, top + u, top + u + v]);
            triangles.push([top, top + u + v, top + v]);
            triangles.push([0, u + v, u]);
            triangles.push([0, v, u + v]);
        }
        FlatTriangles::new(SurfaceMesh {
            points,
            triangles,
            ..SurfaceMesh::default()
        })
        .with_samples()
    }

    #[test]
    fn distances_from_a_cube_are_those_of_the_box() {
        let cube = cube();
        assert!((cube.volume() - 8.0).abs() < 1e-14);
        for k in 0..1000 {
            let t = f64::from(k);
            let x = 2.0 * Vec3::new((12.9 * t).sin(), (78.2 * t).sin(), (37.7 * t).sin());
            let beyond = x.abs().add_scalar(-1.0);
            let exact = match beyond.max() <= 0.0 {
                true => beyond.max(),
                false => beyond.map(|c| c.max(0.0)).norm(),
            };
            assert!((cube.signed_distance(x) - exact).abs() < 1e-14, "{x}");
            for radius in [0.1, 0.5] {
                assert_eq!(cube.contains_ball(x, radius), exact <= -radius, "{x}");
            }
            let foot = cube.closest_point(x);
            assert!(((foot - x).norm() - exact.abs()).abs() < 1e-14);
        }
    }
}
