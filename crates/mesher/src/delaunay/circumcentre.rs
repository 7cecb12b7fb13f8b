//! Circumcentres of tets.

use mesh::Vec3;

/// Circumcentre and volume of a tet.
#[inline]
pub(crate) fn circumcentre(x: [Vec3; 4]) -> (Vec3, f64) {
    let [u, v, w] = [x[1] - x[0], x[2] - x[0], x[3] - x[0]];
    let (vw, wu, uv) = (v.cross(&w), w.cross(&u), u.cross(&v));
    let det = u.dot(&vw);
    let arm = (u.norm_squared() * vw + v.norm_squared() * wu + w.norm_squared() * uv) / (2.0 * det);
    (x[0] + arm, det / 6.0)
}
