//! Shape measures of straight tets.

use crate::jacobian::straight_jacobian;
use crate::{TET_EDGES, Vec3};

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
