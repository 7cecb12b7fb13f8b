//! Closed surfaces of flat triangles: closest points and signed distances.

use mesh::{Surface, SurfaceMesh, Vec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// Largest number of triangles in a leaf of the tree.
const LEAF: usize = 4;

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
    /// Triangles in the order of the leaves.
    order: Vec<u32>,
    nodes: Vec<Node>,
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

/// A box around consecutive triangles of the order.
struct Node {
    low: Vec3,
    high: Vec3,
    /// The triangles of a leaf, as a range of the order; for inner nodes the number of the second
    /// child, the first being the next node.
    content: Content,
}

enum Content {
    Leaf(std::ops::Range<usize>),
    Second(usize),
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
        let mut order: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        let mut nodes = Vec::new();
        if !order.is_empty() {
            divide(&mesh, &mut order, 0, &mut nodes);
        }
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
        let far = Vec3::repeat(f64::INFINITY);
        let (low, high) = (mesh.triangles.iter().flatten())
            .map(|&v| mesh.points[v as usize])
            .fold((far, -far), |(low, high), p| (low.inf(&p), high.sup(&p)));
        let centre = 0.5 * (low + high);
        let radius = (mesh.triangles.iter().flatten())
            .map(|&v| (mesh.points[v as usize] - centre).norm())
            .fold(0.0, f64::max);
        Self {
            mesh,
            order,
            nodes,
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
    fn closest(&self, point: Vec3) -> Option<(Vec3, u32, Feature)> {
        let mut best = None;
        let mut smallest = f64::INFINITY;
        let mut stack = vec![0];
        while let Some(node) = stack.pop() {
            let Some(Node { content, .. }) = self.nodes.get(node) else {
                continue;
            };
            if self.bound(node, point) >= smallest {
                continue;
            }
            match content {
                Content::Leaf(range) => {
                    for &t in &self.order[range.clone()] {
                        let x =
                            self.mesh.triangles[t as usize].map(|v| self.mesh.points[v as usize]);
                        let (foot, feature) = closest_on_triangle(point, x);
                        let squared = (point - foot).norm_squared();
                        if squared < smallest {
                            (smallest, best) = (squared, Some((foot, t, feature)));
                        }
                    }
                }
                &Content::Second(second) => {
                    // The nearer child is visited first.
                    let first = node + 1;
                    match self.bound(first, point) <= self.bound(second, point) {
                        true => stack.extend([second, first]),
                        false => stack.extend([first, second]),
                    }
                }
            }
        }
        best
    }

    /// Lower bound of the squared distance from the triangles of a node.
    fn bound(&self, node: usize, point: Vec3) -> f64 {
        let Node { low, high, .. } = &self.nodes[node];
        (point - point.sup(low).inf(high)).norm_squared()
    }
}

impl Surface for FlatTriangles {
    fn signed_distance(&self, point: Vec3) -> f64 {
        let Some((foot, t, feature)) = self.closest(point) else {
            return f64::INFINITY;
        };
        let tri = self.mesh.triangles[t as usize];
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

/// Adds the node of `order`, which starts at `first` in the whole order, and its children.
fn divide(mesh: &SurfaceMesh, order: &mut [u32], first: usize, nodes: &mut Vec<Node>) {
    let corners = |t: u32| mesh.triangles[t as usize].map(|v| mesh.points[v as usize]);
    let far = Vec3::repeat(f64::INFINITY);
    let (low, high) = (order.iter().flat_map(|&t| corners(t)))
        .fold((far, -far), |(low, high), p| (low.inf(&p), high.sup(&p)));
    let number = nodes.len();
    nodes.push(Node {
        low,
        high,
        content: Content::Leaf(first..first + order.len()),
    });
    if order.len() <= LEAF {
        return;
    }
    let axis = (high - low).imax();
    let centroid = |t: u32| corners(t).iter().map(|x| x[axis]).sum::<f64>();
    order.sort_by(|&s, &t| centroid(s).total_cmp(&centroid(t)).then(s.cmp(&t)));
    let middle = order.len() / 2;
    let (left, right) = order.split_at_mut(middle);
    divide(mesh, left, first, nodes);
    nodes[number].content = Content::Second(nodes.len());
    divide(mesh, right, first + middle, nodes);
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
