//! Whether the fluid between two close surfaces is resolved.

use rayon::prelude::*;

use crate::{Surface, TET_EDGES, TetMesh};

impl TetMesh {
    /// The largest edge of a cell over the sum of the distances of the cell's middle to the two nearest of `bodies` and `wall`; zero
    /// with fewer than two surfaces.
    ///
    /// Across a gap of width `g` the sum is `g`: from 1 on, cells are longer than the gap is wide and the flow in it is not resolved, however
    /// well they are shaped otherwise. The wall is a surface with the fluid inside.
    /// Cost: cells times surfaces, parallel, the same for any number of threads.
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

    /// For each cell the sum of the distances of its middle to the two nearest of `bodies` and `wall`: across a gap, its width.
    ///
    /// Infinite with fewer than two surfaces. The wall is a surface with the fluid inside.
    /// Cost: cells times surfaces, parallel, the same for any number of threads.
    pub fn gap_widths(&self, bodies: &[&dyn Surface], wall: Option<&dyn Surface>) -> Vec<f64> {
        (0..self.n_cells())
            .into_par_iter()
            .with_min_len(1024)
            .map(|cell| self.gap_width(cell, bodies, wall))
            .collect()
    }

    fn gap_width(&self, cell: usize, bodies: &[&dyn Surface], wall: Option<&dyn Surface>) -> f64 {
        let middle = self.cell_vertices(cell).iter().sum::<crate::Vec3>() / 4.0;
        let to_wall = wall.map(|wall| -wall.signed_distance(middle));
        let distances = bodies
            .iter()
            .map(|body| body.signed_distance(middle))
            .chain(to_wall);
        let [first, second] = distances.fold([f64::INFINITY; 2], |[a, b], d| {
            // The middle of a cell at a curved surface may lie a little behind it.
            let d = d.max(0.0);
            if d < a { [d, a] } else { [a, b.min(d)] }
        });
        first + second
    }
}
