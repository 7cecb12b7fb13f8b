//! Image of a flow in a plane wall by Lorentz's reflection, as a map of Lamb's coefficients.
//!
//! If `w`, `q` are velocity and pressure of the flow reflected in the wall `z = 0`, then
//! ```text
//! u* = -J w - 2 z ∇w_z + z² ∇q,   J = diag(1, 1, -1)
//! ```
//! is a Stokes flow that cancels the original one on the wall (Lorentz 1907; Kim & Karrila 1991,
//! section 12.1). The signs were derived independently: `∇·u* = 0` and `p* = q - 4 ∂_z w_z + 2
//! z ∂_z q` follow by differentiation.

use super::lamb::{LambCoefficients, c, e};

/// Lamb's coefficients of the image flow about a centre at `height` above the wall.
///
/// `height` is in radii of the sphere at that centre. `reflected` holds the coefficients of `w` of
/// degrees 0 to `top + 2`; degree 0 is ignored. `m` carries the sign of the symmetry class:
/// positive when `φ` goes with the cosine. The result has degrees `0 ..= top`.
pub(crate) fn image(
    reflected: &[LambCoefficients],
    m: i32,
    height: f64,
    top: usize,
) -> Vec<LambCoefficients> {
    let order = m.unsigned_abs() as usize;
    let azimuth = f64::from(m);
    // d/dz of r^k Y_k is down(k) r^(k-1) Y_(k-1); the harmonic part of z r^(k-1) Y_(k-1) is up(k)
    // r^k Y_k
    let squares = |k: usize| ((k * k) as f64 - (order * order) as f64).max(0.0);
    let down = |k: usize| (squares(k) * (2 * k + 1) as f64 / (2.0 * k as f64 - 1.0)).sqrt();
    let up = |k: usize| (squares(k) / ((2.0 * k as f64 - 1.0) * (2 * k + 1) as f64)).sqrt();
    let at = |k: usize| {
        if k >= 1 {
            reflected.get(k).copied().unwrap_or_default()
        } else {
            LambCoefficients::default()
        }
    };
    // the harmonic part of w_z, nonzero from degree `order` on
    let normal = |k: usize| {
        if k < order {
            return 0.0;
        }
        let from_below = if k > 1 {
            e(k - 1) * up(k) * at(k - 1).p
        } else {
            0.0
        };
        down(k + 1) * at(k + 1).phi - azimuth * at(k).chi - from_below
    };
    let mut result = vec![LambCoefficients::default(); top + 1];
    for k in order.max(1)..=top {
        let kf = k as f64;
        let (own, below) = (at(k), at(k - 1));
        let below2 = if k >= 2 {
            at(k - 2)
        } else {
            LambCoefficients::default()
        };
        let up_below = if k >= 2 { up(k - 1) } else { 0.0 };
        let gradient = down(k + 1) * (down(k + 2) * at(k + 2).phi - azimuth * at(k + 1).chi)
            + ((2.0 * c(k) - e(k)) * up(k) * down(k) - e(k)) * own.p;
        let (f, f_below) = (normal(k), normal(k - 1));
        result[k] = LambCoefficients {
            p: (1.0 + 2.0 * up(k) * down(k)) * own.p - 4.0 * gradient
                + 2.0 * height * down(k + 1) * at(k + 1).p,
            chi: -own.chi
                + azimuth / (kf * (kf + 1.0))
                    * (2.0 * (height * own.p + up(k) * below.p) - 4.0 * f),
            phi: -own.phi
                + (2.0 * up(k) * (2.0 - kf) * f_below - 2.0 * height * kf * f
                    + height * height * kf * own.p
                    + 2.0 * height * up(k) * (kf - 1.0) * below.p
                    + up(k) * up_below * (kf - 2.0) * below2.p)
                    / kf,
        };
    }
    result
}
