//! Spheres that are deformed along the radius.

use crate::quadrature::legendre;

/// Number of amplitudes of a radial function: degrees from zero to twelve.
pub const RADIAL_DEGREES: usize = 13;

/// A sphere on the axis that is deformed along the radius, to
///
/// ```text
/// r(θ) = a (1 + Σ_l α_l P_l(cos θ) / p)^p
/// ```
///
/// at the angle `θ` from the axis, with Legendre polynomials `P_l`. With `p = 1/3` all amplitudes
/// but that of the degree zero keep its volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeformedSphere {
    /// Position of the centre on the axis.
    pub centre: f64,
    /// `a`.
    pub radius: f64,
    /// `p`.
    pub power: f64,
    /// `α_l`.
    pub amplitudes: [f64; RADIAL_DEGREES],
}

impl DeformedSphere {
    /// Distance of the surface from the centre at an angle from the axis.
    pub fn radius_at(&self, angle: f64) -> f64 {
        self.with_slope(angle)[0]
    }

    /// The distance `r(θ)` and its derivative.
    pub(crate) fn with_slope(&self, angle: f64) -> [f64; 2] {
        let (sin, cos) = angle.sin_cos();
        let mut base = [1.0, 0.0];
        for (degree, amplitude) in self.amplitudes.iter().enumerate() {
            if *amplitude == 0.0 {
                continue;
            }
            let [p, slope] = match degree {
                0 => [1.0, 0.0],
                _ => {
                    let [p, slope, _] = legendre(degree, cos);
                    [p, slope]
                }
            };
            base[0] += amplitude * p / self.power;
            base[1] -= amplitude * slope * sin / self.power;
        }
        let radius = self.radius * base[0].powf(self.power);
        [radius, self.power * radius / base[0] * base[1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `r = 1 + 0.1 P_2 + 0.2 P_3` is 1.3 and 0.9 at the poles, where its slope vanishes.
    #[test]
    fn the_slope_vanishes_at_the_poles() {
        let mut amplitudes = [0.0; RADIAL_DEGREES];
        (amplitudes[2], amplitudes[3]) = (0.1, 0.2);
        let sphere = DeformedSphere {
            centre: 0.0,
            radius: 1.0,
            power: 1.0,
            amplitudes,
        };
        for (angle, radius) in [(0.0, 1.3), (std::f64::consts::PI, 0.9)] {
            let [found, slope] = sphere.with_slope(angle);
            assert!((found - radius).abs() < 1e-14 && slope.abs() < 1e-14);
        }
    }
}
