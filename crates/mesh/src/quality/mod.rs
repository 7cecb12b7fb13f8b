//! How good the cells are: angles and mean ratio of the straight tets, Jacobian of the curved ones.

mod gap;
mod jacobian;
mod shape;

use rayon::prelude::*;

pub use jacobian::scaled_jacobian_bound;
pub(crate) use jacobian::{curved_volume, straight_jacobian};
pub use shape::{dihedral_angles, mean_ratio};

use crate::{LinearTets, MeshError, TetMesh, Vec3};

/// Cells a task; fixed, so that sums do not depend on the number of threads.
const CHUNK: usize = 1024;

/// The worst and the mean of the cells of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// Smallest [`scaled_jacobian_bound`]; 1 if all cells are straight.
    pub min_jacobian: f64,
    /// The (first) cell that has it.
    pub worst_cell: usize,
}

impl Quality {
    /// What is left when there are no cells, and the start of every minimum.
    const NONE: Self = Self {
        cells: 0,
        min_dihedral: f64::INFINITY,
        max_dihedral: f64::NEG_INFINITY,
        min_quality: f64::INFINITY,
        mean_quality: f64::NAN,
        min_jacobian: f64::INFINITY,
        worst_cell: 0,
    };

    /// Measures `n_cells` cells, given the corners and the scaled Jacobian of each.
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
    /// Quality of the tets; the Jacobian is 1 or, if some tet is inverted or flat, -1 or 0.
    ///
    /// Cost: one pass over the tets, parallel, bitwise the same for any number of threads.
    /// # Panics
    /// If a tet refers to a point that does not exist.
    pub fn quality(&self) -> Quality {
        Quality::measure(self.tets.len(), |c| {
            let corners = self.tets[c].map(|v| self.points[v as usize]);
            (corners, sign(straight_jacobian(corners)))
        })
    }
}

impl TetMesh {
    /// Quality of the cells: shape of their straight tets, Jacobian of the curved ones.
    ///
    /// Cost: one pass over the cells, parallel, bitwise the same for any number of threads.
    pub fn quality(&self) -> Quality {
        Quality::measure(self.n_cells(), |c| {
            (self.cell_vertices(c), self.scaled_jacobian(c))
        })
    }

    /// [`scaled_jacobian_bound`] of one cell; straight cells need no bound: 1, or -1 if inverted, or 0 if flat.
    pub fn scaled_jacobian(&self, cell: usize) -> f64 {
        if self.is_affine(cell) {
            sign(straight_jacobian(self.cell_vertices(cell)))
        } else {
            scaled_jacobian_bound(&self.cell_points(cell))
        }
    }

    /// That the geometry map of every cell is one-to-one.
    ///
    /// # Errors
    /// [`MeshError::InvertedCell`] with the worst cell.
    pub(crate) fn check_jacobians(&self) -> Result<(), MeshError> {
        let worst: Vec<(f64, usize)> = (0..self.n_cells().div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                (chunk * CHUNK..self.n_cells().min((chunk + 1) * CHUNK))
                    .map(|cell| (self.scaled_jacobian(cell), cell))
                    .fold((f64::INFINITY, 0), |a, b| if b.0 < a.0 { b } else { a })
            })
            .collect();
        let (jacobian, cell) = worst
            .into_iter()
            .fold((f64::INFINITY, 0), |a, b| if b.0 < a.0 { b } else { a });
        if jacobian > 0.0 {
            return Ok(());
        }
        let [a, b, c, d] = self.cell_vertices(cell);
        Err(MeshError::InvertedCell {
            cell,
            at: ((a + b + c + d) / 4.0).into(),
            jacobian,
        })
    }
}

/// 1, 0 or -1; -infinity for NaN, which is as bad as a cell gets.
fn sign(x: f64) -> f64 {
    if x > 0.0 {
        1.0
    } else if x < 0.0 {
        -1.0
    } else if x == 0.0 {
        0.0
    } else {
        f64::NEG_INFINITY
    }
}
