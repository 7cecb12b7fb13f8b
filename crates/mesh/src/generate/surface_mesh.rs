//! Triangulations of surfaces: designed where a sphere has one size, refined step by step where sizes vary.

use super::geodesic::{geodesic_sphere, triangles_for};
use crate::{MeshError, Surface, Vec3};
use std::collections::HashMap;

/// Edges longer than this times the wanted length are split: halves then fall below it by the same factor, up to rounding.
const SPLIT: f64 = std::f64::consts::SQRT_2;

/// Sizes on one sphere that differ by less than this are served by one geodesic triangulation.
const UNIFORM: f64 = 1.25;

/// Smoothing rounds at the end; vertices move by less than a hundredth of an edge after that many.
const FINAL_ROUNDS: usize = 20;

/// A closed triangulated surface, triangles counterclockwise as seen from outside the shape.
#[derive(Clone, Debug, Default)]
pub(super) struct SurfaceMesh {
    pub points: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl SurfaceMesh {
    /// The triangle behind the edge opposite each vertex.
    pub fn neighbours(&self) -> Vec<[u32; 3]> {
        let mut left = HashMap::new();
        for (t, tri) in self.triangles.iter().enumerate() {
            for i in 0..3 {
                left.insert((tri[(i + 1) % 3], tri[(i + 2) % 3]), t as u32);
            }
        }
        self.triangles
            .iter()
            .map(|tri| [0, 1, 2].map(|i| left[&(tri[(i + 2) % 3], tri[(i + 1) % 3])]))
            .collect()
    }
}

/// The radius of `surface` if it is a sphere, which its volume tells.
pub(super) fn sphere_radius(surface: &dyn Surface) -> Option<f64> {
    let (_, radius) = surface.bounding_ball();
    let ball = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    // Rounding of a cube and a few products.
    ((surface.volume() - ball).abs() <= 1e-12 * ball).then_some(radius)
}

/// Triangulates `surface` with edges of length about `size(point)`.
///
/// # Errors
/// More than `limit` triangles would be needed.
pub(super) fn triangulate(
    surface: &dyn Surface,
    size: &dyn Fn(Vec3) -> f64,
    limit: usize,
) -> Result<SurfaceMesh, MeshError> {
    let (centre, reach) = surface.bounding_ball();
    let coarse = geodesic_sphere(0.5);
    let seen = surface.centre();
    let samples = coarse.points.iter().map(|d| size(cast(surface, seen, *d)));
    let (low, high) = samples.fold((f64::INFINITY, 0.0), |(l, h): (f64, f64), s| {
        (l.min(s), h.max(s))
    });
    if let Some(radius) = sphere_radius(surface) {
        let one_size = high <= UNIFORM * low;
        let edge = if one_size { (low * high).sqrt() } else { high };
        if triangles_for(edge / radius) > limit as f64 {
            return Err(MeshError::TooManyVertices { limit });
        }
        let mut mesh = geodesic_sphere(edge / radius);
        for p in &mut mesh.points {
            *p = centre + radius * *p;
        }
        if one_size {
            return Ok(mesh);
        }
        Refiner::new(mesh, surface, size).run(limit)
    } else {
        let mut mesh = geodesic_sphere((high / reach).max(0.5));
        for p in &mut mesh.points {
            *p = cast(surface, seen, *p);
        }
        Refiner::new(mesh, surface, size).run(limit)
    }
}

/// Triangulates the surface of the box between `min` and `max`, its edges and corners kept.
///
/// # Errors
/// More than `limit` triangles would be needed.
pub(super) fn triangulate_box(
    surface: &dyn Surface,
    [min, max]: [Vec3; 2],
    size: &dyn Fn(Vec3) -> f64,
    limit: usize,
) -> Result<SurfaceMesh, MeshError> {
    // Corner `i` takes the upper bound of the axes whose bit is set.
    let points = (0..8usize)
        .map(|i| {
            Vec3::from_fn(|axis, _| {
                if i >> axis & 1 == 1 {
                    max[axis]
                } else {
                    min[axis]
                }
            })
        })
        .collect();
    let mut triangles = Vec::new();
    for [a, b, c, d] in [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ] {
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    Refiner::new(SurfaceMesh { points, triangles }, surface, size).run(limit)
}

/// Where the ray from `centre` along `direction` leaves the shape.
fn cast(surface: &dyn Surface, centre: Vec3, direction: Vec3) -> Vec3 {
    let (middle, radius) = surface.bounding_ball();
    let (mut inside, mut outside) = (0.0, (middle - centre).norm() + radius);
    // Bisection to the last bit of a f64.
    for _ in 0..f64::MANTISSA_DIGITS {
        let t = 0.5 * (inside + outside);
        if surface.signed_distance(centre + t * direction) < 0.0 {
            inside = t;
        } else {
            outside = t;
        }
    }
    surface.closest_point(centre + outside * direction)
}

/// Splits, turns and moves until edges fit the size.
struct Refiner<'a> {
    surface: &'a dyn Surface,
    size: &'a dyn Fn(Vec3) -> f64,
    mesh: SurfaceMesh,
    /// Triangle behind the edge opposite each vertex.
    neighbours: Vec<[u32; 3]>,
}

impl<'a> Refiner<'a> {
    fn new(mesh: SurfaceMesh, surface: &'a dyn Surface, size: &'a dyn Fn(Vec3) -> f64) -> Self {
        let neighbours = mesh.neighbours();
        Refiner {
            surface,
            size,
            mesh,
            neighbours,
        }
    }

    fn run(mut self, limit: usize) -> Result<SurfaceMesh, MeshError> {
        while self.split_longest() {
            if self.mesh.triangles.len() > limit {
                return Err(MeshError::TooManyVertices { limit });
            }
            self.flip_all();
            self.smooth();
            self.flip_all();
        }
        for _ in 0..FINAL_ROUNDS {
            self.smooth();
            self.flip_all();
        }
        Ok(self.mesh)
    }

    fn corners(&self, t: usize) -> [Vec3; 3] {
        self.mesh.triangles[t].map(|v| self.mesh.points[v as usize])
    }

    fn normal(&self, t: usize) -> Vec3 {
        let [a, b, c] = self.corners(t);
        (b - a).cross(&(c - a))
    }

    /// Length of the edge opposite vertex `i` of `t`, in units of the wanted length there.
    fn stretch(&self, t: usize, i: usize) -> f64 {
        let x = self.corners(t);
        let (b, c) = (x[(i + 1) % 3], x[(i + 2) % 3]);
        (b - c).norm() / (self.size)(0.5 * (b + c))
    }

    /// Splits the longest edges of the mesh, those within a factor of the very longest; false if none is too long.
    fn split_longest(&mut self) -> bool {
        let mut long: Vec<(f64, [u32; 2])> = Vec::new();
        for t in 0..self.mesh.triangles.len() {
            for i in 0..3 {
                let tri = self.mesh.triangles[t];
                let (b, c) = (tri[(i + 1) % 3], tri[(i + 2) % 3]);
                if b < c {
                    let stretch = self.stretch(t, i);
                    if stretch > SPLIT {
                        long.push((stretch, [t as u32, i as u32]));
                    }
                }
            }
        }
        let longest = long.iter().fold(SPLIT, |m, e| m.max(e.0));
        long.retain(|e| e.0 * SPLIT > longest);
        long.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
        let mut touched = vec![false; self.mesh.triangles.len()];
        let any = !long.is_empty();
        for (_, [t, i]) in long {
            let (t, i) = (t as usize, i as usize);
            let u = self.neighbours[t][i] as usize;
            // A triangle split in this pass is another one now: its edges wait for the next pass.
            if !touched[t] && !touched[u] {
                touched[t] = true;
                touched[u] = true;
                self.split(t, i);
                touched.resize(self.mesh.triangles.len(), true);
            }
        }
        any
    }

    /// Splits the edge opposite vertex `i` of `t`: `a b c | d c b` become `a b m, a m c | d c m, d m b`.
    fn split(&mut self, t: usize, i: usize) {
        let u = self.neighbours[t][i] as usize;
        let j = self.slot(u, t);
        let [a, b, c] = self.turned(t, i);
        let d = self.mesh.triangles[u][j];
        let [_, t_b, t_c] = [0, 1, 2].map(|k| self.neighbours[t][(i + k) % 3]);
        let [_, u_c, u_b] = [0, 1, 2].map(|k| self.neighbours[u][(j + k) % 3]);
        let middle = 0.5 * (self.mesh.points[b as usize] + self.mesh.points[c as usize]);
        let m = self.mesh.points.len() as u32;
        self.mesh.points.push(self.surface.closest_point(middle));
        let (t2, u2) = (
            self.mesh.triangles.len() as u32,
            self.mesh.triangles.len() as u32 + 1,
        );
        let (t1, u1) = (t as u32, u as u32);
        self.mesh.triangles[t] = [a, b, m];
        self.neighbours[t] = [u2, t2, t_c];
        self.mesh.triangles.push([a, m, c]);
        self.neighbours.push([u1, t_b, t1]);
        self.mesh.triangles[u] = [d, c, m];
        self.neighbours[u] = [t2, u2, u_b];
        self.mesh.triangles.push([d, m, b]);
        self.neighbours.push([t1, u_c, u1]);
        self.relink(t_b, t1, t2);
        self.relink(u_c, u1, u2);
    }

    /// Turns the edge opposite vertex `i` of `t`: `a b c | d c b` become `a b d | d c a`.
    fn flip(&mut self, t: usize, i: usize) {
        let u = self.neighbours[t][i] as usize;
        let j = self.slot(u, t);
        let [a, b, c] = self.turned(t, i);
        let d = self.mesh.triangles[u][j];
        let [_, t_b, t_c] = [0, 1, 2].map(|k| self.neighbours[t][(i + k) % 3]);
        let [_, u_c, u_b] = [0, 1, 2].map(|k| self.neighbours[u][(j + k) % 3]);
        let (t1, u1) = (t as u32, u as u32);
        self.mesh.triangles[t] = [a, b, d];
        self.neighbours[t] = [u_c, u1, t_c];
        self.mesh.triangles[u] = [d, c, a];
        self.neighbours[u] = [t_b, t1, u_b];
        self.relink(t_b, t1, u1);
        self.relink(u_c, u1, t1);
    }

    fn slot(&self, t: usize, neighbour: usize) -> usize {
        let around = &self.neighbours[t];
        (0..2)
            .find(|&k| around[k] as usize == neighbour)
            .unwrap_or(2)
    }

    /// The vertices of `t` from vertex `i` on.
    fn turned(&self, t: usize, i: usize) -> [u32; 3] {
        let tri = self.mesh.triangles[t];
        [tri[i], tri[(i + 1) % 3], tri[(i + 2) % 3]]
    }

    fn relink(&mut self, t: u32, old: u32, new: u32) {
        let k = self.slot(t as usize, old as usize);
        self.neighbours[t as usize][k] = new;
    }

    /// Flips until every triangle has an empty ball beneath it: the triangulation that the tets will find.
    ///
    /// The balls have half the smallest radius of curvature and lie on the inner side. On a sphere such a ball is empty
    /// exactly when the triangle lies on the convex hull; on other surfaces all of it but a thin cap is inside the body, where
    /// no vertex of the fluid is, hence the triangle is a face of the Delaunay tets too.
    fn flip_all(&mut self) {
        // Each flip makes progress on a fixed point set; the bound guards against rounding among cocircular points.
        for _ in 0..100 {
            let mut flipped = false;
            for t in 0..self.mesh.triangles.len() {
                for i in 0..3 {
                    if self.wants_flip(t, i) {
                        self.flip(t, i);
                        flipped = true;
                    }
                }
            }
            if !flipped {
                break;
            }
        }
    }

    fn wants_flip(&self, t: usize, i: usize) -> bool {
        let u = self.neighbours[t][i] as usize;
        let (n_t, n_u) = (self.normal(t), self.normal(u));
        // Across an edge of a box, or one that would fold the surface, nothing is turned (60 degrees).
        if n_t.dot(&n_u) < 0.5 * n_t.norm() * n_u.norm() {
            return false;
        }
        let [a, b, c] = self.turned(t, i).map(|v| self.mesh.points[v as usize]);
        let d = self.mesh.points[self.mesh.triangles[u][self.slot(u, t)] as usize];
        // The new triangles must face the same way.
        let facing = n_t + n_u;
        if (b - a).cross(&(d - a)).dot(&facing) <= 0.0
            || (d - a).cross(&(c - a)).dot(&facing) <= 0.0
        {
            return false;
        }
        let (centre_t, r_t) = circumcircle([a, b, c]);
        let (_, r_u) = circumcircle([d, c, b]);
        // A ball must be larger than the circle that it rests on.
        let radius = (0.5 * self.surface.smallest_curvature_radius()).max(1.05 * r_t.max(r_u));
        let depth = (radius * radius - r_t * r_t).sqrt();
        let centre = centre_t - n_t.normalize() * depth;
        // Cocircular points (squares on a box) stay as they are.
        (d - centre).norm() < radius * (1.0 - 1e-10)
    }

    /// Moves each vertex towards the size-weighted centroid of its triangles, on the surface; ridges stay.
    ///
    /// The weight `area / h^4` is that of a centroidal Voronoi tessellation with density `h^-4`, which spaces points by
    /// `h` (Du & Wang 2005).
    fn smooth(&mut self) {
        let n = self.mesh.points.len();
        let mut sums = vec![(Vec3::zeros(), 0.0); n];
        let mut first_normal = vec![Vec3::zeros(); n];
        let mut ridge = vec![false; n];
        for t in 0..self.mesh.triangles.len() {
            let [a, b, c] = self.corners(t);
            let normal = self.normal(t);
            let centroid = (a + b + c) / 3.0;
            let weight = normal.norm() * (self.size)(centroid).powi(-4);
            for v in self.mesh.triangles[t].map(|v| v as usize) {
                sums[v].0 += weight * centroid;
                sums[v].1 += weight;
                if first_normal[v] == Vec3::zeros() {
                    first_normal[v] = normal;
                }
                // Faces of a box meet at right angles; triangles that follow a smooth surface never do.
                ridge[v] |=
                    normal.dot(&first_normal[v]) < 0.1 * normal.norm() * first_normal[v].norm();
            }
        }
        for v in 0..n {
            if !ridge[v] && sums[v].1 > 0.0 {
                self.mesh.points[v] = self.surface.closest_point(sums[v].0 / sums[v].1);
            }
        }
    }
}

/// Centre and radius of the circle through three points.
fn circumcircle([a, b, c]: [Vec3; 3]) -> (Vec3, f64) {
    let (u, v) = (b - a, c - a);
    let n = u.cross(&v);
    let arm = (v.norm_squared() * n.cross(&u) + u.norm_squared() * v.cross(&n))
        / (2.0 * n.norm_squared()).max(f64::MIN_POSITIVE);
    (a + arm, arm.norm())
}
