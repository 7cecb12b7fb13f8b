//! Lamb's general solution inside a sphere, for one azimuthal number.
//!
//! ```text
//! u = sum_k ∇φ_k + ∇ × (r χ_k) + c_k r² ∇p_k - e_k r p_k
//! c_k = (k+3) / (2 (k+1) (2k+3)),   e_k = k / ((k+1) (2k+3))
//! ```
//! with solid harmonics `φ_k`, `χ_k`, `p_k` of degree `k` and the position vector `r` (Lamb 1932,
//! art. 336; Happel & Brenner 1983, section 3-2). The coefficients belong to `r^k Y_km` and are
//! scaled by the radius `a` of the sphere, such that `a^(k-1) φ`, `a^k χ` and `a^(k+1) p` are
//! velocities on its surface. `φ` and `p` go with `cos mφ`, `χ` with `sin mφ`; the modes with
//! sine and cosine exchanged follow by reversing the sign of `m`.

use super::modes::Family;

/// `c_k`, the coefficient of `r² ∇p_k`.
pub(crate) fn c(k: usize) -> f64 {
    let k = k as f64;
    (k + 3.0) / (2.0 * (k + 1.0) * (2.0 * k + 3.0))
}

/// `e_k`, the coefficient of `-r p_k`.
pub(crate) fn e(k: usize) -> f64 {
    let k = k as f64;
    k / ((k + 1.0) * (2.0 * k + 3.0))
}

/// Coefficients of one degree of Lamb's solution.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct LambCoefficients {
    pub phi: f64,
    pub chi: f64,
    pub p: f64,
}

impl LambCoefficients {
    /// The same flow multiplied by a factor.
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            phi: self.phi * factor,
            chi: self.chi * factor,
            p: self.p * factor,
        }
    }

    /// The flow whose velocity on the surface of the sphere is one harmonic: the inverse of
    /// [`LambCoefficients::trace`].
    pub fn of_trace(family: Family, k: usize) -> Self {
        let radial = e(k) / (2 * k + 1) as f64;
        let [phi, chi, p] = match family {
            Family::Stokeslet => [1.0, 0.0, 0.0],
            Family::Rotlet => [0.0, -1.0, 0.0],
            Family::Source => [1.0 - c(k) / radial, 0.0, 1.0 / radial],
        };
        Self { phi, chi, p }
    }

    /// Coefficients of `W_k`, `X_k`, `V_k` in the velocity on the surface of the sphere.
    pub fn trace(&self, k: usize) -> [f64; 3] {
        let radial = e(k) / (2 * k + 1) as f64;
        [
            self.phi + (c(k) - radial) * self.p,
            -self.chi,
            radial * self.p,
        ]
    }
}

/// Index of a family in [`LambCoefficients::trace`].
pub(crate) fn trace_index(family: Family) -> usize {
    family.shift()
}
