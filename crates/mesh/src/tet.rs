//! Points in space and the local numbering of a tetrahedron.

use nalgebra::Vector3;

/// A point or a displacement in space.
pub type Vec3 = Vector3<f64>;

/// Local vertex pairs whose midside nodes are local nodes 4..10 (VTK order of
/// `VTK_QUADRATIC_TETRA`).
pub const TET_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

/// Local vertices of face `i`, opposite vertex `i`; in a positively oriented tet the normal points
/// outwards.
pub(crate) const TET_FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_of_the_reference_tet_point_outwards() {
        let x = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        for (opposite, face) in TET_FACES.iter().enumerate() {
            let [a, b, c] = face.map(|i| x[i]);
            assert!((b - a).cross(&(c - a)).dot(&(x[opposite] - a)) < 0.0);
        }
    }
}
