//! Resolution of the gaps between close surfaces.

use rayon::prelude::*;

use crate::{Surface, TET_EDGES, TetMesh};

impl TetMesh {
    /// Largest ratio of a cell's longest edge to the local gap width, see [`TetMesh::gap_widths`].
    ///
    /// From 1 on, cells are longer than the gap is wide and do not resolve the flow in it, however
    /// good their shape. Zero with fewer than two surfaces. The fluid is inside `wall` and outside
    /// `bodies`. Cost: cells times surfaces, in parallel; the result does not depend on the number
    /// of threads.
    pub fn gap_ratio(&self, bodies: &[&dyn Surface], wall: Option<&dyn Surface>) -> f64 {
        if bodies.len() + usize::from(wall.is_some()) < 2 {
            return 0.0;
        }
        (0..self.n_cells())
            .into_par_iter()
            .with_min_len(1024)
            .map(|cell| {
                let corners = self.cell_vertices(cell);
                let longest = TET_EDGES
                    .iter()
                    .map(|&[i, j]| (corners[i] - corners[j]).norm())
                    .fold(0.0, f64::max);
                longest / self.gap_width(cell, bodies, wall)
            })
            .reduce(|| 0.0, f64::max)
    }

    /// Local gap width at each cell: the sum of the distances from its centroid to the two nearest
    /// surfaces.
    ///
    /// On the line across a gap this sum is the width of the gap. Infinite with fewer than two
    /// surfaces. The fluid is inside `wall` and outside `bodies`. Cost: cells times surfaces, in
    /// parallel; the result does not depend on the number of threads.
    pub fn gap_widths(&self, bodies: &[&dyn Surface], wall: Option<&dyn Surface>) -> Vec<f64> {
        (0..self.n_cells())
            .into_par_iter()
            .with_min_len(1024)
            .map(|cell| self.gap_width(cell, bodies, wall))
            .collect()
    }

    fn gap_width(&self, cell: usize, bodies: &[&dyn Surface], wall: Option<&dyn Surface>) -> f64 {
        let centroid = self.cell_vertices(cell).iter().sum::<crate::Vec3>() / 4.0;
        let to_wall = wall.map(|wall| -wall.signed_distance(centroid));
        let distances = bodies
            .iter()
            .map(|body| body.signed_distance(centroid))
            .chain(to_wall);
        let [first, second] = distances.fold([f64::INFINITY; 2], |[a, b], d| {
            // The centroid of a cell at a curved surface may lie slightly inside the body. A
            // surface without a distance, whose numbers are not finite, leaves no gap.
            let d = d.max(0.0);
            if d < a { [d, a] } else { [a, b.min(d)] }
        });
        first + second
    }
}
