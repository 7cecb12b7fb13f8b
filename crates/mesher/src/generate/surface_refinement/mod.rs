//! Refinement of surface triangulations to a varying edge length.

mod coarsening;
mod edge_flips;
mod missing;
mod surface_smoothing;

use super::symmetry_planes::SymmetryPlanes;
use crate::GenerateError;
use crate::surface::{sphere_radius, triangles};
use mesh::{Surface, SurfaceMesh, Vec3};
use std::collections::HashSet;

/// Ratio to the wanted length above which edges are split.
///
/// The halves are then shorter than the wanted length by at most the same factor.
const SPLIT: f64 = std::f64::consts::SQRT_2;

/// Number of smoothing rounds at the end.
///
/// After them no vertex moves by more than about a hundredth of an edge.
const FINAL_ROUNDS: usize = 20;

/// Largest number of splitting passes.
///
/// Each pass shortens the longest edges by `sqrt(2)`, so these passes span more than ten orders of
/// magnitude.
const MAX_PASSES: usize = 100;

/// Number of splitting passes after which longer edges are accepted, and by how much per pass.
///
/// On a long tube the smoothing after a split can make the edges beside it too long by a few
/// percent, so that a front of few splits travels along the tube, a triangle per pass.
const STRICT_PASSES: usize = 30;
const SLACK: f64 = 0.01;

/// Cosine of the angle between normals (84 degrees) beyond which an edge is a ridge.
///
/// Faces of a box meet at right angles, fine triangles that follow a smooth surface do not.
const RIDGE: f64 = 0.1;

/// Cosine of the angle between normals (60 degrees) beyond which triangles do not follow a smooth
/// surface yet.
const BENT: f64 = 0.5;

/// Largest number of steps along a ray; each covers the distance to the nearest point of the
/// surface.
const RAY_STEPS: usize = 64;

/// Splits, flips and smooths a triangulation until its edges have the wanted length.
pub(super) struct Refiner<'a> {
    surface: &'a dyn Surface,
    size: &'a dyn Fn(Vec3) -> f64,
    mesh: SurfaceMesh,
    /// Neighbour of each triangle across the edge opposite each vertex.
    neighbours: Vec<[u32; 3]>,
    /// Radius, if the surface is a sphere.
    sphere: Option<f64>,
    /// Cosine between normals below which an edge is a ridge.
    ridge: f64,
    /// Sharp edges, the smaller vertex first; they are neither flipped nor left.
    sharp: HashSet<[u32; 2]>,
    /// Symmetry planes; edges on them stay there.
    planes: SymmetryPlanes,
    name: &'a str,
}

impl<'a> Refiner<'a> {
    pub fn new(
        mesh: SurfaceMesh,
        name: &'a str,
        surface: &'a dyn Surface,
        size: &'a dyn Fn(Vec3) -> f64,
        planes: SymmetryPlanes,
    ) -> Self {
        let neighbours = triangles::neighbours(&mesh);
        let mesh_sharp = mesh.sharp_edges.iter().map(|&edge| sorted(edge)).collect();
        Refiner {
            surface,
            size,
            mesh,
            neighbours,
            sphere: sphere_radius(surface),
            // Spheres have no ridges. On other shapes coarse triangles do: a flip there could join
            // opposite sides of a slender body.
            ridge: match sphere_radius(surface) {
                Some(_) => -2.0,
                // Sharp edges are known one by one, if there are any.
                None if surface.reach() > 0.0 => BENT,
                None => RIDGE,
            },
            sharp: mesh_sharp,
            planes,
            name,
        }
    }

    /// Refines the triangulation.
    ///
    /// # Errors
    /// [`GenerateError::TooManyVertices`] if more than `limit` vertices are needed,
    /// [`GenerateError::SurfaceNotRecovered`] if splitting does not end.
    pub fn run(mut self, limit: usize) -> Result<SurfaceMesh, GenerateError> {
        if self.surface.has_fine_triangulation() {
            self.coarsen();
        }
        let mut passes = 0_usize;
        while self
            .split_longest(SPLIT * (1.0 + SLACK * passes.saturating_sub(STRICT_PASSES) as f64))
        {
            passes += 1;
            if self.mesh.triangles.len() > 2 * limit {
                return Err(GenerateError::TooManyVertices { limit });
            }
            if passes > MAX_PASSES {
                return Err(GenerateError::SurfaceNotRecovered {
                    body: self.name.into(),
                    at: self.mesh.points[0].into(),
                });
            }
            self.flip_all();
            self.smooth();
            self.flip_all();
        }
        for _ in 0..MAX_PASSES {
            if !self.split_sharp() {
                break;
            }
            self.flip_all();
            self.smooth();
            self.flip_all();
        }
        for _ in 0..FINAL_ROUNDS {
            self.smooth();
            self.flip_all();
        }
        Ok(self.into_mesh())
    }

    /// The triangulation, with its present sharp edges.
    fn into_mesh(mut self) -> SurfaceMesh {
        self.mesh.sharp_edges = self.sharp.into_iter().collect();
        self.mesh.sharp_edges.sort_unstable();
        self.mesh
    }

    fn corners(&self, t: usize) -> [Vec3; 3] {
        self.mesh.triangles[t].map(|v| self.mesh.points[v as usize])
    }

    fn normal(&self, t: usize) -> Vec3 {
        let [a, b, c] = self.corners(t);
        (b - a).cross(&(c - a))
    }

    /// Length of the edge opposite vertex `i` of `t`, relative to the wanted length.
    fn stretch(&self, t: usize, i: usize) -> f64 {
        let x = self.corners(t);
        let (b, c) = (x[(i + 1) % 3], x[(i + 2) % 3]);
        (b - c).norm() / (self.size)(0.5 * (b + c))
    }

    /// Splits the edges that are too long and within a factor of `sqrt(2)` of the longest edge.
    ///
    /// Too long are those of more than `least` times the wanted length. Returns whether there were
    /// any.
    fn split_longest(&mut self, least: f64) -> bool {
        let mut long: Vec<(f64, [u32; 2])> = Vec::new();
        for t in 0..self.mesh.triangles.len() {
            for i in 0..3 {
                let tri = self.mesh.triangles[t];
                let (b, c) = (tri[(i + 1) % 3], tri[(i + 2) % 3]);
                if b < c {
                    let stretch = self.stretch(t, i);
                    if stretch > least {
                        long.push((stretch, [t as u32, i as u32]));
                    }
                }
            }
        }
        let longest = long.iter().fold(least, |m, e| m.max(e.0));
        long.retain(|e| e.0 * SPLIT > longest);
        long.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
        let mut touched = vec![false; self.mesh.triangles.len()];
        let any = !long.is_empty();
        for (_, [t, i]) in long {
            let (t, i) = (t as usize, i as usize);
            let u = self.neighbours[t][i] as usize;
            // The edges of a triangle that was split in this pass wait for the next pass.
            if !touched[t] && !touched[u] {
                touched[t] = true;
                touched[u] = true;
                self.split(t, i);
                touched.resize(self.mesh.triangles.len(), true);
            }
        }
        any
    }

    /// The point that is projected onto the surface to split the edge between triangles `t` and
    /// `u`.
    ///
    /// The midpoint, in general. The midpoint of a long edge around a sharp rim is closer to the
    /// faces on both sides than to the rim, so it is moved outwards to the surface.
    fn split_point(&self, t: usize, u: usize, edge: [u32; 2]) -> Vec3 {
        let [b, c] = edge.map(|v| self.mesh.points[v as usize]);
        let middle = 0.5 * (b + c);
        let (n_t, n_u) = (self.normal(t).normalize(), self.normal(u).normalize());
        if n_t.dot(&n_u) > BENT || self.surface.reach() == 0.0 {
            return middle;
        }
        let outwards = (n_t + n_u).try_normalize(1e-6).unwrap_or(n_t);
        // From inside, the ray is followed to the surface by the distances to it.
        let mut point = middle;
        for _ in 0..RAY_STEPS {
            let depth = -self.surface.signed_distance(point);
            if depth.is_nan() || depth <= 0.0 {
                break;
            }
            point += depth * outwards;
        }
        point
    }

    /// Splits the edge opposite vertex `i` of `t`: `a b c | d c b` become `a b m, a m c | d c m, d
    /// m b`.
    fn split(&mut self, t: usize, i: usize) {
        let u = self.neighbours[t][i] as usize;
        let j = self.slot(u, t);
        let [a, b, c] = self.rotated(t, i);
        let d = self.mesh.triangles[u][j];
        let [_, t_b, t_c] = [0, 1, 2].map(|k| self.neighbours[t][(i + k) % 3]);
        let [_, u_c, u_b] = [0, 1, 2].map(|k| self.neighbours[u][(j + k) % 3]);
        let m = self.mesh.points.len() as u32;
        let point = if self.sharp.remove(&sorted([b, c])) {
            self.sharp.extend([sorted([b, m]), sorted([m, c])]);
            self.on_sharp_edge([b, c])
        } else {
            let middle = self.split_point(t, u, [b, c]);
            let planes = self.planes.at(middle);
            planes.along(self.surface.closest_point(middle))
        };
        self.mesh.points.push(point);
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

    /// Flips the edge opposite vertex `i` of `t`: `a b c | d c b` become `a b d | d c a`.
    fn flip(&mut self, t: usize, i: usize) {
        let u = self.neighbours[t][i] as usize;
        let j = self.slot(u, t);
        let [a, b, c] = self.rotated(t, i);
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

    /// Position of `neighbour` among the neighbours of `t`.
    fn slot(&self, t: usize, neighbour: usize) -> usize {
        let around = &self.neighbours[t];
        (0..2)
            .find(|&k| around[k] as usize == neighbour)
            .unwrap_or(2)
    }

    /// The vertices of `t`, rotated to begin with vertex `i`.
    fn rotated(&self, t: usize, i: usize) -> [u32; 3] {
        let tri = self.mesh.triangles[t];
        [tri[i], tri[(i + 1) % 3], tri[(i + 2) % 3]]
    }

    /// Replaces neighbour `old` of `t` by `new`.
    fn relink(&mut self, t: u32, old: u32, new: u32) {
        let k = self.slot(t as usize, old as usize);
        self.neighbours[t as usize][k] = new;
    }
}

/// An edge with the smaller vertex first.
fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Centre and radius of the circle through three points.
pub(crate) fn circumcircle([a, b, c]: [Vec3; 3]) -> (Vec3, f64) {
    let (u, v) = (b - a, c - a);
    let n = u.cross(&v);
    let arm = (v.norm_squared() * n.cross(&u) + u.norm_squared() * v.cross(&n))
        / (2.0 * n.norm_squared()).max(f64::MIN_POSITIVE);
    (a + arm, arm.norm())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_ball_has_the_corners_on_its_surface() {
        let corners = [
            Vec3::new(0.3, -1.0, 0.2),
            Vec3::new(1.1, 0.4, -0.5),
            Vec3::new(-0.2, 0.9, 0.8),
        ];
        let (centre, radius) = circumcircle(corners);
        for x in corners {
            assert!(((x - centre).norm() - radius).abs() < 1e-15 * 10.0);
        }
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        assert!((centre - corners[0]).dot(&normal).abs() < 1e-14);
    }
}
