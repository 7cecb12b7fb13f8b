//! Quality of cells: angles and mean ratio of the straight tets, Jacobian of the curved ones.

mod gap;
mod shape;

use rayon::prelude::*;

pub use shape::{dihedral_angles, mean_ratio};

use crate::jacobian::scaled_jacobian_of_straight_tet;
use crate::{LinearTets, TetMesh, Vec3};

/// Cells per parallel task; fixed, so that sums do not depend on the number of threads.
const CHUNK: usize = 1024;

/// Worst and mean quality of the cells of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Quality {
    /// Number of cells.
    pub cells: usize,
    /// Smallest dihedral angle of the straight tets, degrees.
    pub min_dihedral: f64,
    /// Largest dihedral angle of the straight tets, degrees.
    pub max_dihedral: f64,
    /// Smallest [`mean_ratio`].
    pub min_quality: f64,
    /// Mean of [`mean_ratio`]; NaN if there are no cells.
    pub mean_quality: f64,
    /// Smallest [`TetMesh::scaled_jacobian`]; 1 if all cells are straight.
    pub min_jacobian: f64,
    /// The first cell with the smallest scaled Jacobian.
    pub worst_cell: usize,
}

impl Quality {
    /// Neutral element of the minima and maxima: the quality of no cells.
    const NONE: Self = Self {
        cells: 0,
        min_dihedral: f64::INFINITY,
        max_dihedral: f64::NEG_INFINITY,
        min_quality: f64::INFINITY,
        mean_quality: f64::NAN,
        min_jacobian: f64::INFINITY,
        worst_cell: 0,
    };

    /// Measures `n_cells` cells; `cell` returns the corners and the scaled Jacobian of each.
    fn measure(n_cells: usize, cell: impl Fn(usize) -> ([Vec3; 4], f64) + Sync) -> Self {
        let chunks: Vec<(Self, f64)> = (0..n_cells.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let mut worst = Self::NONE;
                let mut sum = 0.0;
                for c in chunk * CHUNK..n_cells.min((chunk + 1) * CHUNK) {
                    let (corners, jacobian) = cell(c);
                    let quality = mean_ratio(corners);
                    sum += quality;
                    worst.min_quality = worst.min_quality.min(quality);
                    for angle in dihedral_angles(corners) {
                        worst.min_dihedral = worst.min_dihedral.min(angle);
                        worst.max_dihedral = worst.max_dihedral.max(angle);
                    }
                    if jacobian < worst.min_jacobian {
                        (worst.min_jacobian, worst.worst_cell) = (jacobian, c);
                    }
                }
                (worst, sum)
            })
            .collect();
        let mut all = Self::NONE;
        let mut total = 0.0;
        for (worst, sum) in chunks {
            total += sum;
            all.min_dihedral = all.min_dihedral.min(worst.min_dihedral);
            all.max_dihedral = all.max_dihedral.max(worst.max_dihedral);
            all.min_quality = all.min_quality.min(worst.min_quality);
            if worst.min_jacobian < all.min_jacobian {
                (all.min_jacobian, all.worst_cell) = (worst.min_jacobian, worst.worst_cell);
            }
        }
        all.cells = n_cells;
        all.mean_quality = total / n_cells as f64;
        all
    }
}

impl LinearTets {
    /// Quality of the tets; the scaled Jacobian of a straight tet is 1, 0 (flat) or -1 (inverted).
    ///
    /// Cost: one pass over the tets, in parallel; bitwise the same for any number of threads.
    ///
    /// # Panics
    /// If a tet refers to a point that does not exist.
    pub fn quality(&self) -> Quality {
        Quality::measure(self.tets.len(), |c| {
            let corners = self.tets[c].map(|v| self.points[v as usize]);
            (corners, scaled_jacobian_of_straight_tet(corners))
        })
    }
}

impl TetMesh {
    /// Quality of the cells: shape of their straight tets, Jacobian of the curved ones.
    ///
    /// Cost: one pass over the cells, in parallel; bitwise the same for any number of threads.
    pub fn quality(&self) -> Quality {
        Quality::measure(self.n_cells(), |c| {
            (self.cell_vertices(c), self.scaled_jacobian(c))
        })
    }
}
