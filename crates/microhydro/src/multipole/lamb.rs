//! Lamb's general solution inside a sphere, for one azimuthal number.
//!
//! $u = \sum_k \nabla\phi_k + \nabla\times(r \chi_k) + c_k r^2 \nabla p_k - e_k r p_k$ with solid harmonics $\phi_k, \chi_k, p_k$ of degree $k$,
//! $c_k = (k+3)/(2(k+1)(2k+3))$, $e_k = k/((k+1)(2k+3))$ (Lamb 1932, art. 336; Happel & Brenner 1983, section 3-2). The coefficients
//! belong to $r^k Y_{km}$ and are scaled by the sphere's radius: $a^{k-1}\phi$, $a^k \chi$, $a^{k+1} p$ are velocities on its surface.
//! $\phi$ and $p$ go with $\cos m\varphi$, $\chi$ with $\sin m\varphi$; the other half is had by the sign of `m`.

use super::modes::Family;

/// $c_k$, the factor of $r^2 \nabla p_k$.
pub(crate) fn c(k: usize) -> f64 {
    let k = k as f64;
    (k + 3.0) / (2.0 * (k + 1.0) * (2.0 * k + 3.0))
}

/// $e_k$, the factor of $-r p_k$.
pub(crate) fn e(k: usize) -> f64 {
    let k = k as f64;
    k / ((k + 1.0) * (2.0 * k + 3.0))
}

/// The three coefficients of one degree.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Lamb {
    pub phi: f64,
    pub chi: f64,
    pub p: f64,
}

impl Lamb {
    /// The same flow times a factor.
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            phi: self.phi * factor,
            chi: self.chi * factor,
            p: self.p * factor,
        }
    }

    /// The harmonics $W_k$, $X_k$, $V_k$ of the velocity on the sphere.
    pub fn trace(&self, k: usize) -> [f64; 3] {
        let radial = e(k) / (2 * k + 1) as f64;
        [
            self.phi + (c(k) - radial) * self.p,
            -self.chi,
            radial * self.p,
        ]
    }
}

/// Place of a family in a [`Lamb::trace`].
pub(crate) fn place(family: Family) -> usize {
    family.shift()
}
