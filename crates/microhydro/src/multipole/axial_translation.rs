//! Translation of multipoles along the axis: closed forms for each azimuthal number.
//!
//! The flow of a multipole about one centre is expanded in Lamb's general solution (`lamb`) about
//! another centre at distance `d` along the axis. The derivation uses the translation of solid
//! harmonics
//! ```text
//! R_km = r^k P_k^m e^(imφ) / (k+m)!        I_lm = (l-m)! P_l^m e^(imφ) / r^(l+1)
//! I_lm(r + d) = sum_k (-1)^(k-m) (l+k)! / d^(l+k+1) R_km(r)
//! R_km(r + d) = sum_l d^(k-l) / (k-l)! R_lm(r)
//! ```
//! and the scalars `r'·u` and `r'·(∇ × u)`, which determine Lamb's coefficients about the new
//! centre. Each coefficient costs a few operations; none is a small difference of large numbers.

use super::lamb::{LambCoefficients, c, e};
use super::modes::Family;

/// `(k² - m²)/(2k - 1)`: coefficient of the degree-`k` harmonic in `z R_(k-1)`.
fn raise(k: usize, m: usize) -> f64 {
    ((k * k) as f64 - (m * m) as f64) / (2.0 * k as f64 - 1.0)
}

/// Translation of the outgoing multipoles of a sphere to another sphere in the direction of the
/// axis.
pub(crate) struct OutgoingTranslation {
    m: usize,
    source: f64,
    target: f64,
    distance: f64,
    /// Normalised translation coefficients, `l` slowest, both degrees from `m` on.
    ///
    /// For source radius `a_i` and target radius `a_j`:
    /// ```text
    /// sqrt((2l+1)/(2k+1)) (-1)^(k-m) a_i^l a_j^k / d^(l+k) (l+k)!
    ///     / sqrt((l-m)! (l+m)! (k-m)! (k+m)!)
    /// ```
    table: Vec<f64>,
    width: usize,
}

impl OutgoingTranslation {
    /// Translation over `distance` between spheres of radii `source` and `target`, up to the
    /// degrees `top_l` and `top_k`.
    pub fn new(
        m: usize,
        (source, top_l): (f64, usize),
        (target, top_k): (f64, usize),
        distance: f64,
    ) -> Self {
        let (rows, width) = ((top_l + 1).saturating_sub(m), (top_k + 1).saturating_sub(m));
        let (s, t) = (source / distance, target / distance);
        let step = |l: usize, k: usize, ratio: f64| {
            // factor from degree l to l + 1 at fixed k
            (l + k + 1) as f64 * ratio / (((l + 1) * (l + 1) - m * m) as f64).sqrt()
        };
        let mut table = vec![0.0; rows * width];
        let mut first = (s * t).powi(m as i32);
        for row in 0..rows {
            let l = row + m;
            let mut value = first;
            for column in 0..width {
                let k = column + m;
                let sign = if column % 2 == 0 { 1.0 } else { -1.0 };
                table[row * width + column] =
                    sign * value * ((2 * l + 1) as f64 / (2 * k + 1) as f64).sqrt();
                value *= step(k, l, t);
            }
            first *= step(l, m, s);
        }
        Self {
            m,
            source,
            target,
            distance,
            table,
            width,
        }
    }

    /// Coefficients of degree `k` about the target centre.
    ///
    /// The flow is the one that equals the harmonic of `family` and degree `l` on the source
    /// sphere.
    pub fn coefficients(&self, family: Family, l: usize, k: usize) -> LambCoefficients {
        let m = self.m;
        let s = self.table[(l - m) * self.width + k - m];
        let (a, b, d) = (self.source, self.target, self.distance);
        let (lf, kf, mf) = (l as f64, k as f64, m as f64);
        match family {
            Family::Source => LambCoefficients {
                phi: a * a / (b * d) * s,
                ..LambCoefficients::default()
            },
            Family::Rotlet => LambCoefficients {
                phi: -a / b * mf / kf * s,
                chi: a / d * lf / (kf + 1.0) * s,
                p: 0.0,
            },
            Family::Stokeslet => {
                let mut all = self.unscaled_with_pressure(l, k);
                all.phi += potential(l) * a * a / (b * d);
                all.scaled(s)
            }
        }
    }

    /// Coefficients of degree `k` of the part with pressure of the flow that equals the harmonic
    /// `W` of degree `l` on the source sphere.
    ///
    /// With `p = Y/r^(l+1)` and a number `K`, it is
    /// ```text
    /// K a^l (alpha r^2 grad p - beta r p)
    /// ```
    /// and the rest of the flow is [`potential`] times that of the harmonic `V`.
    pub fn with_pressure(&self, l: usize, k: usize) -> LambCoefficients {
        let s = self.table[(l - self.m) * self.width + k - self.m];
        self.unscaled_with_pressure(l, k).scaled(s)
    }

    /// The same without the translation coefficient of the degrees.
    fn unscaled_with_pressure(&self, l: usize, k: usize) -> LambCoefficients {
        let m = self.m;
        let (b, d) = (self.target, self.distance);
        let (lf, kf, mf) = (l as f64, k as f64, m as f64);
        let strength = lf * (4.0 * lf * lf - 1.0) / (lf + 1.0);
        let alpha = (2.0 - lf) / (2.0 * lf * (2.0 * lf - 1.0));
        let beta = -(lf + 1.0) / (lf * (2.0 * lf - 1.0));
        let gamma = (lf + 1.0) / (2.0 * (2.0 * lf - 1.0));
        let (up, sum) = (raise(k, m), lf + kf);
        let phi =
            (gamma - (2.0 * gamma + beta) * up / sum + alpha * (sum + 1.0 - 2.0 * up) + beta) / kf;
        LambCoefficients {
            phi: strength * phi * d / b,
            chi: -strength * mf / (lf * kf * (kf + 1.0)),
            p: strength * b / d,
        }
    }
}

/// The part without pressure, in units of the harmonic `V`, of the flow that equals the harmonic
/// `W` of degree `l` on a sphere: `a^(l+2) grad(Y/r^(l+1))` for the radius `a`.
pub(crate) fn potential(l: usize) -> f64 {
    let l = l as f64;
    1.0 - (2.0 * l + 1.0) * (2.0 - l) / (2.0 * (l + 1.0))
}

/// Translation of the flow inside a container to a sphere in the direction of the axis.
pub(crate) struct InteriorTranslation {
    m: usize,
    container: f64,
    target: f64,
    offset: f64,
    /// Normalised translation coefficients, `l` slowest, both degrees from `m` on; zero for `l >
    /// k`.
    ///
    /// For the radius `a` of the sphere, `b` of the container and the offset `c` of the centres:
    /// ```text
    /// sqrt((2k+1)/(2l+1)) a^l c^(k-l) / b^k / (k-l)! sqrt((k-m)! (k+m)! / ((l-m)! (l+m)!))
    /// ```
    table: Vec<f64>,
    width: usize,
}

impl InteriorTranslation {
    /// Translation from a container to a sphere of radius `target` at distance `offset` from its
    /// centre.
    pub fn new(
        m: usize,
        (container, top_k): (f64, usize),
        (target, top_l): (f64, usize),
        offset: f64,
    ) -> Self {
        let (rows, width) = ((top_l + 1).saturating_sub(m), (top_k + 1).saturating_sub(m));
        let mut table = vec![0.0; rows * width];
        for l in m..m + rows {
            let mut value = (target / container).powi(l as i32);
            for k in l..m + width {
                table[(l - m) * width + k - m] =
                    value * ((2 * k + 1) as f64 / (2 * l + 1) as f64).sqrt();
                let next = (((k + 1) * (k + 1) - m * m) as f64).sqrt();
                value *= offset / container * next / (k + 1 - l) as f64;
            }
        }
        Self {
            m,
            container,
            target,
            offset,
            table,
            width,
        }
    }

    /// Coefficients of degree `l` about the centre of the sphere.
    ///
    /// The flow is the one that equals the harmonic of `family` and degree `k` on the container.
    pub fn coefficients(&self, family: Family, k: usize, l: usize) -> LambCoefficients {
        let m = self.m;
        let (a, b, z) = (self.target, self.container, self.offset);
        let (lf, kf, mf) = (l as f64, k as f64, m as f64);
        let s = self.table[(l - m) * self.width + k - m];
        match family {
            Family::Stokeslet => LambCoefficients {
                phi: b / a * s,
                ..LambCoefficients::default()
            },
            Family::Rotlet => LambCoefficients {
                phi: -z / a * mf / lf * s,
                chi: -(kf + 1.0) / (lf + 1.0) * s,
                p: 0.0,
            },
            Family::Source => {
                // u = Q (c_k r^2 grad p - e_k r p) / b^(k+1) - g b^(1-k) grad(r^k Y), p = r^k Y
                let strength = (2.0 * kf + 1.0) / e(k);
                let potential = strength * c(k) - 1.0;
                // translation coefficient of degree l - 1, which is nonzero for l = k + 1 too
                let below = if l == k + 1 {
                    (a / b).powi(k as i32) * a / ((l * l - m * m) as f64).sqrt()
                        * ((2.0 * kf + 1.0) / (2.0 * lf + 1.0)).sqrt()
                } else if l <= k {
                    s * z / (kf - lf + 1.0)
                } else {
                    0.0
                };
                let gamma = kf / (2.0 * (2.0 * kf + 3.0));
                let up = raise(l, m);
                let phi = (z * z * s * (gamma - c(k) * (kf - lf + 2.0 * up) + e(k))
                    + z * below * up * (2.0 * gamma + e(k)))
                    / lf;
                LambCoefficients {
                    phi: strength * phi / (a * b) - potential * b / a * s,
                    chi: strength * z / b * mf / ((kf + 1.0) * lf * (lf + 1.0)) * s,
                    p: strength * a / b * s,
                }
            }
        }
    }
}
