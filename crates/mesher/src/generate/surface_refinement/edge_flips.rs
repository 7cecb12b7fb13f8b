//! Flips of the edges of a surface triangulation.

use super::{Refiner, circumcircle, sorted};
use mesh::Vec3;

impl Refiner<'_> {
    /// Flips edges until the Delaunay ball of no triangle contains the opposite corner of a
    /// neighbour.
    ///
    /// On a sphere the balls touch the triangles from inside: they are empty exactly if the
    /// triangles lie on the convex hull, and those are the faces of the tets. On other surfaces the
    /// criterion is that the angles opposite an edge add up to less than 180 degrees (Delaunay on
    /// the surface itself); the tets may then join four points near one circle across the other
    /// diagonal.
    pub(super) fn flip_all(&mut self) {
        // In a plane the flips are known to end; the bound is for curved surfaces.
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

    /// Whether the edge opposite vertex `i` of `t` is to be flipped.
    fn wants_flip(&self, t: usize, i: usize) -> bool {
        let u = self.neighbours[t][i] as usize;
        let [a, b, c] = self.rotated(t, i).map(|v| self.mesh.points[v as usize]);
        let d = self.mesh.points[self.mesh.triangles[u][self.slot(u, t)] as usize];
        let [_, v, w] = self.rotated(t, i);
        if !self.planes.through(&[b, c]).is_empty() || self.sharp.contains(&sorted([v, w])) {
            return false;
        }
        // The new triangles must be oriented like the old ones.
        let facing = self.normal(t) + self.normal(u);
        let faces = |x: Vec3, y: Vec3| (x - a).cross(&(y - a)).dot(&facing) > 0.0;
        faces(b, d)
            && faces(d, c)
            && self.contains_opposite_corner(t, i)
            && !self.is_joined(t, i, self.mesh.triangles[u][self.slot(u, t)])
    }

    /// Whether an edge joins vertex `i` of `t` to vertex `d`.
    ///
    /// Walks around the vertex. A second edge between two vertices would not be a surface.
    fn is_joined(&self, t: usize, i: usize, d: u32) -> bool {
        let a = self.mesh.triangles[t][i];
        let (mut here, mut slot) = (t, i);
        // No vertex has more triangles than there are.
        for _ in 0..self.mesh.triangles.len() {
            let triangle = self.mesh.triangles[here];
            if triangle.contains(&d) {
                return true;
            }
            // The neighbour across the edge from `a` to the next vertex but one.
            here = self.neighbours[here][(slot + 1) % 3] as usize;
            slot = (0..2)
                .find(|&k| self.mesh.triangles[here][k] == a)
                .unwrap_or(2);
            if here == t {
                break;
            }
        }
        false
    }

    /// Whether the Delaunay ball of triangle `t` contains the corner beyond the edge opposite
    /// vertex `i`.
    fn contains_opposite_corner(&self, t: usize, i: usize) -> bool {
        let u = self.neighbours[t][i] as usize;
        let j = self.slot(u, t);
        let (n_t, n_u) = (self.normal(t), self.normal(u));
        // Ridges are not flipped, nor edges where the surface would fold.
        if n_t.dot(&n_u) < self.ridge * n_t.norm() * n_u.norm() {
            return false;
        }
        // The diagonals of cocircular points (squares on a box) stay unchanged.
        let decided = 1e-10;
        match self.sphere {
            Some(radius) => {
                let d = self.mesh.points[self.mesh.triangles[u][j] as usize];
                let (centre, r) = circumcircle(self.corners(t));
                // Slightly smaller than the sphere itself, on which rounding would decide, but
                // larger than the circumcircle.
                let radius = (0.9 * radius).max(1.05 * r);
                let centre = centre - (radius * radius - r * r).sqrt() * n_t.normalize();
                (d - centre).norm() < radius * (1.0 - decided)
            }
            None => self.angle(t, i) + self.angle(u, j) > std::f64::consts::PI * (1.0 + decided),
        }
    }

    /// Angle of triangle `t` at its vertex `i`.
    pub(super) fn angle(&self, t: usize, i: usize) -> f64 {
        let x = self.corners(t);
        let (u, v) = (x[(i + 1) % 3] - x[i], x[(i + 2) % 3] - x[i]);
        u.cross(&v).norm().atan2(u.dot(&v))
    }
}
