//! Vertices on sharp edges of a surface triangulation.

use super::Refiner;
use mesh::Vec3;
use std::collections::BTreeMap;

impl Refiner<'_> {
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
    pub(super) fn smooth_sharp_edges(&self, moved: &mut [Vec3]) {
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
