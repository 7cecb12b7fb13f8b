//! Smoothing of a surface triangulation and of its sharp edges.

use super::Refiner;
use mesh::Vec3;
use std::collections::BTreeMap;

impl Refiner<'_> {
    /// Moves each vertex to the weighted centroid of its triangles, projected onto the surface.
    ///
    /// Vertices on ridges stay, those on sharp edges move along them.
    ///
    /// The weight of a triangle is its area relative to the wanted one, `area / h^2`. This evens
    /// out shapes and leaves the number of vertices in each region to the splitting. (The density
    /// `h^-4` of a centroidal Voronoi tessellation attracts vertices from far away during the
    /// splitting, and doubles the triangles around a gap of 0.02 radii.)
    pub(super) fn smooth(&mut self) {
        let n = self.mesh.points.len();
        let mut sums = vec![(Vec3::zeros(), 0.0); n];
        let mut first_normal = vec![Vec3::zeros(); n];
        let mut ridge = vec![false; n];
        for t in 0..self.mesh.triangles.len() {
            let [a, b, c] = self.corners(t);
            let normal = self.normal(t);
            let centroid = (a + b + c) / 3.0;
            let weight = normal.norm() * (self.size)(centroid).powi(-2);
            for v in self.mesh.triangles[t].map(|v| v as usize) {
                sums[v].0 += weight * centroid;
                sums[v].1 += weight;
                if first_normal[v] == Vec3::zeros() {
                    first_normal[v] = normal;
                }
                ridge[v] |=
                    normal.dot(&first_normal[v]) < 0.1 * normal.norm() * first_normal[v].norm();
            }
        }
        let mut moved = self.mesh.points.clone();
        for v in 0..n {
            if !ridge[v] && sums[v].1 > 0.0 {
                let planes = self.planes.at(self.mesh.points[v]);
                let centre = planes.along(sums[v].0 / sums[v].1);
                moved[v] = planes.along(self.surface.closest_point(centre));
            }
        }
        self.smooth_sharp_edges(&mut moved);
        self.keep_orientations(&mut moved);
        self.mesh.points = moved;
    }

    /// Takes back the moves of the vertices of triangles that they would turn over.
    ///
    /// Around the tips of slender bodies, centroids are closest to other parts of the surface.
    fn keep_orientations(&self, moved: &mut [Vec3]) {
        loop {
            let mut kept = false;
            for (t, triangle) in self.mesh.triangles.iter().enumerate() {
                let [a, b, c] = triangle.map(|v| moved[v as usize]);
                let before = self.normal(t);
                let turns = (b - a).cross(&(c - a)).dot(&before) <= 0.0 && before.norm() > 0.0;
                for v in triangle.map(|v| v as usize) {
                    if turns && moved[v] != self.mesh.points[v] {
                        moved[v] = self.mesh.points[v];
                        kept = true;
                    }
                }
            }
            if !kept {
                break;
            }
        }
    }

    /// The point of the sharp edges of the surface that divides an edge of the triangulation.
    pub(super) fn on_sharp_edge(&self, edge: [u32; 2]) -> Vec3 {
        let [a, b] = edge.map(|v| self.mesh.points[v as usize]);
        let middle = 0.5 * (a + b);
        (self.surface.closest_on_sharp_edges(middle)).unwrap_or(middle)
    }

    /// For each vertex on sharp edges, the other ends of these edges.
    pub(super) fn sharp_neighbours(&self) -> BTreeMap<u32, Vec<u32>> {
        let mut ends: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for &[a, b] in &self.sharp {
            ends.entry(a).or_default().push(b);
            ends.entry(b).or_default().push(a);
        }
        // The order in the set is arbitrary.
        ends.values_mut().for_each(|list| list.sort_unstable());
        ends
    }

    /// Moves the vertices on sharp edges half-way to the middle of their neighbours, along the
    /// edges; corners stay.
    fn smooth_sharp_edges(&self, moved: &mut [Vec3]) {
        let at = |v: u32| self.mesh.points[v as usize];
        for (v, ends) in self.sharp_neighbours() {
            moved[v as usize] = match ends[..] {
                [a, b] if self.mesh.corners.binary_search(&v).is_err() => {
                    let target = 0.5 * at(v) + 0.25 * (at(a) + at(b));
                    self.surface.closest_on_sharp_edges(target).unwrap_or(at(v))
                }
                _ => at(v),
            };
        }
    }
}
