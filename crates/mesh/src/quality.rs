//! Quality of cells: angles and mean ratio of the straight tets, Jacobian of the curved ones.

use rayon::prelude::*;

use crate::jacobian::{scaled_jacobian_of_straight_tet, straight_jacobian};
use crate::{LinearTets, TET_EDGES, Vec3};

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
    /// Smallest [`scaled_jacobian`](crate::TetMesh::scaled_jacobian); 1 if all cells are straight.
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
    pub(crate) fn measure(n_cells: usize, cell: impl Fn(usize) -> ([Vec3; 4], f64) + Sync) -> Self {
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

/// Ratio of a tet's determinant to the product of its edge lengths below which rounding hides its
/// sign.
///
/// The determinant of three rounded edge vectors has an error of at most about 16 units of rounding
/// of the product of their lengths (Higham 2002, 3.5).
const MIN_DETERMINANT: f64 = 16.0 * f64::EPSILON;

/// Whether the volume of a straight tet, positive or negative, is larger than its rounding error.
///
/// A [`TetMesh`](crate::TetMesh) has no other tets.
pub fn has_volume(x: [Vec3; 4]) -> bool {
    let lengths: f64 = (1..4).map(|i| (x[i] - x[0]).norm()).product();
    // False for NaN, from overflow.
    straight_jacobian(x).abs() > MIN_DETERMINANT * lengths
}

/// Mean-ratio quality of a straight tet: `q = 12 (3 V)^(2/3) / sum of squared edge lengths`.
///
/// One for a regular tet, zero for a flat one, negative for an inverted one; invariant under
/// translation, rotation and scaling (Liu & Joe, BIT 34, 1994). Zero also for coincident vertices
/// and where the volume overflows.
///
/// ```
/// use mesh::{Vec3, mean_ratio};
/// let corner = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
/// assert!((mean_ratio(corner) - 0.8399473665965822).abs() < 1e-14); // 12 (1/2)^(2/3) / 9
/// ```
pub fn mean_ratio(x: [Vec3; 4]) -> f64 {
    let squares: f64 = TET_EDGES
        .iter()
        .map(|&[i, j]| (x[j] - x[i]).norm_squared())
        .sum();
    // 3 V = det / 2
    let triple_volume = 0.5 * straight_jacobian(x);
    let size = (triple_volume * triple_volume).cbrt();
    let ratio = (12.0 * size / squares).copysign(triple_volume);
    // not finite for coincident vertices, and where squares or volume overflow
    if ratio.is_finite() { ratio } else { 0.0 }
}

/// Dihedral angles of a straight tet at the edges [`TET_EDGES`], in degrees.
///
/// Between 0 and 180; 70.53 at every edge of a regular tet. The angles of a tet with coincident
/// vertices are finite but meaningless.
pub fn dihedral_angles(x: [Vec3; 4]) -> [f64; 6] {
    TET_EDGES.map(|[i, j]| {
        // The angle between the other two vertices, seen along the edge; atan2 is accurate for
        // angles near 0 and near 180 degrees.
        let mut others = (0..4).filter(|&v| v != i && v != j);
        let (k, l) = (others.next().unwrap_or(i), others.next().unwrap_or(j));
        let edge = x[j] - x[i];
        let (a, b) = (edge.cross(&(x[k] - x[i])), edge.cross(&(x[l] - x[i])));
        a.cross(&b).norm().atan2(a.dot(&b)).to_degrees()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const REGULAR: [[f64; 3]; 4] = [
        [1.0, 1.0, 1.0],
        [1.0, -1.0, -1.0],
        [-1.0, 1.0, -1.0],
        [-1.0, -1.0, 1.0],
    ];

    #[test]
    fn regular_tet_has_mean_ratio_one_and_equal_angles() {
        let x = REGULAR.map(Vec3::from);
        let q = mean_ratio(x);
        assert!((q.abs() - 1.0).abs() < 1e-15);
        for angle in dihedral_angles(x) {
            assert!((angle - (1.0_f64 / 3.0).acos().to_degrees()).abs() < 1e-13);
        }
    }

    #[test]
    fn sign_of_the_mean_ratio_is_the_orientation() {
        let [a, b, c, d] = REGULAR.map(Vec3::from);
        assert_eq!(mean_ratio([a, b, c, d]), -mean_ratio([b, a, c, d]));
    }

    #[test]
    fn corner_tet_has_three_right_angles() {
        let angles = dihedral_angles([Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()]);
        let steep = (1.0 / 3.0_f64.sqrt()).acos().to_degrees();
        // Right angles at the edges 01, 02, 03; the edges 12, 13, 23 bound the oblique face.
        let expected = [90.0, steep, 90.0, 90.0, steep, steep];
        for (angle, exact) in angles.into_iter().zip(expected) {
            assert!((angle - exact).abs() < 1e-13, "{angle} {exact}");
        }
    }

    #[test]
    fn coincident_vertices_have_mean_ratio_zero() {
        assert_eq!(mean_ratio([Vec3::zeros(); 4]), 0.0);
    }
}
