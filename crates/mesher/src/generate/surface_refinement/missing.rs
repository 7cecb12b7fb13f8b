//! Changes of a surface triangulation whose triangles are not all faces of Delaunay tets.

use super::{Refiner, sorted};
use crate::generate::recovered_surfaces::Missing;
use mesh::SurfaceMesh;

impl Refiner<'_> {
    /// Exchanges diagonals where the tets have the other one, and divides the other missing
    /// triangles.
    ///
    /// Triangles are divided at the end of the path of longest edges from them (Rivara 1984), which
    /// bounds their angles. The new vertices are on the surface.
    pub(crate) fn changed(mut self, missing: &[&Missing]) -> SurfaceMesh {
        let mut is_changed = vec![false; self.mesh.triangles.len()];
        for missing in missing {
            let t = missing.triangle;
            let Some(with) = missing.with.filter(|u| !is_changed[t] && !is_changed[*u]) else {
                continue;
            };
            let beside = (0..3).find(|&i| self.neighbours[t][i] as usize == with);
            let flips = beside.filter(|&i| {
                let [_, b, c] = self.rotated(t, i);
                !self.sharp.contains(&sorted([b, c]))
            });
            if let Some(i) = flips {
                self.flip(t, i);
                (is_changed[t], is_changed[with]) = (true, true);
            }
        }
        for missing in missing {
            let mut t = missing.triangle;
            if is_changed[t] {
                continue;
            }
            let mut i = self.longest(t);
            let neighbour = loop {
                let u = self.neighbours[t][i] as usize;
                let j = self.longest(u);
                if self.neighbours[u][j] as usize == t {
                    break u;
                }
                (t, i) = (u, j);
            };
            if !is_changed[t] && !is_changed[neighbour] {
                self.split(t, i);
                is_changed.resize(self.mesh.triangles.len(), true);
                (is_changed[t], is_changed[neighbour]) = (true, true);
            }
        }
        self.into_mesh()
    }

    /// The position in a triangle of the vertex opposite its longest edge.
    ///
    /// Of equal edges, that with the larger vertex numbers counts as longer.
    fn longest(&self, t: usize) -> usize {
        let x = self.corners(t);
        let length = |i: usize| {
            let [_, b, c] = self.rotated(t, i);
            ((x[(i + 1) % 3] - x[(i + 2) % 3]).norm(), sorted([b, c]))
        };
        let longer = |i: usize, j: usize| if length(j) > length(i) { j } else { i };
        longer(longer(0, 1), 2)
    }

    /// Splits sharp edges that are not Delaunay: whose opposite angles add up to more than 180
    /// degrees. Other edges are flipped instead.
    ///
    /// Returns whether there were any.
    pub(super) fn split_sharp(&mut self) -> bool {
        let mut wide = Vec::new();
        for t in 0..self.mesh.triangles.len() {
            for i in 0..3 {
                let [_, b, c] = self.rotated(t, i);
                let u = self.neighbours[t][i] as usize;
                if b < c && self.sharp.contains(&[b, c]) {
                    let sum = self.angle(t, i) + self.angle(u, self.slot(u, t));
                    if sum > std::f64::consts::PI {
                        wide.push([t, i]);
                    }
                }
            }
        }
        let mut is_changed = vec![false; self.mesh.triangles.len()];
        let any = !wide.is_empty();
        for [t, i] in wide {
            let u = self.neighbours[t][i] as usize;
            if !is_changed[t] && !is_changed[u] {
                (is_changed[t], is_changed[u]) = (true, true);
                self.split(t, i);
                is_changed.resize(self.mesh.triangles.len(), true);
            }
        }
        any
    }
}
