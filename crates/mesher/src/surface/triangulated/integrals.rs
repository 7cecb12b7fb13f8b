//! Integrals over the volume that patches enclose.

use super::patch::Patch;
use mesh::Vec3;

/// Nodes and weights of the Gauss-Legendre rule of degree 11 on the unit interval (Abramowitz &
/// Stegun 1964, 25.4.30).
const GAUSS: [(f64, f64); 6] = [
    (0.033_765_242_898_423_99, 0.085_662_246_189_585_17),
    (0.169_395_306_766_867_74, 0.180_380_786_524_069_3),
    (0.380_690_406_958_401_56, 0.233_956_967_286_345_5),
    (0.619_309_593_041_598_4, 0.233_956_967_286_345_5),
    (0.830_604_693_233_132_3, 0.180_380_786_524_069_3),
    (0.966_234_757_101_576, 0.085_662_246_189_585_17),
];

/// Volume, first moments `int x dV` and area.
pub(super) struct Integrals {
    pub volume: f64,
    pub moments: Vec3,
    pub area: f64,
}

/// Integrals over the patches by the divergence theorem: `V = int x . n / 3 dA`,
/// `int x_i dV = int x_i^2 n_i / 2 dA`.
///
/// Exact but for rounding, except the area: the integrands are polynomials of degree 10. Moments
/// are taken about the point `about`, relative to it.
pub(super) fn integrals(patches: &[Patch], about: Vec3) -> Integrals {
    let mut sums = Integrals {
        volume: 0.0,
        moments: Vec3::zeros(),
        area: 0.0,
    };
    for patch in patches {
        for (s, ws) in GAUSS {
            for (t, wt) in GAUSS {
                // The square is mapped onto the triangle with one side becoming a corner.
                let at = [1.0 - s, s * (1.0 - t), s * t];
                let x = patch.at(at) - about;
                let [u, v] = patch.tangents(at);
                let normal = (ws * wt * s) * u.cross(&v);
                sums.volume += x.dot(&normal) / 3.0;
                sums.moments += 0.5 * x.component_mul(&x).component_mul(&normal);
                sums.area += normal.norm();
            }
        }
    }
    sums
}
