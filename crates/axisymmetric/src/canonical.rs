//! One representative of all configurations with the same flow.

use crate::AxisymmetricError;
use crate::collar::Motion;
use crate::meridian::Surroundings;
use crate::resistance::AxialResistance;
use crate::spheroid::AxialSpheroid;
use crate::surface_modes::{LENGTHS, MODES, PARITIES};

/// Bodies from left to right, shifted, mirrored and scaled to a standard position.
///
/// Equal flows have equal representatives in all bits, and one computation serves them all.
pub(crate) struct Canonical {
    pub bodies: Vec<AxialSpheroid>,
    pub surroundings: Surroundings,
    /// Index of each body in the caller's list.
    given: Vec<usize>,
    /// Whether the axis is reversed.
    is_mirrored: bool,
    /// The caller's length that is one here: a power of two, at most the smallest semi-axis.
    unit: f64,
}

/// Distances are rounded to this fraction of the smallest gap, or of the smallest semi-axis if that
/// is smaller.
///
/// Rounding errors of a stroke's lengths, a few `1e-16` of the lengths, then seldom distinguish
/// configurations. Resistances change by a relative `1e-13`.
const GRID: f64 = 1.0 / (1_u64 << 43) as f64;

impl Canonical {
    /// The representative of valid bodies.
    pub fn new(bodies: &[AxialSpheroid], surroundings: Surroundings) -> Self {
        let semi_axes = bodies.iter().flat_map(|b| [b.axial, b.equatorial]);
        let unit = power_of_two_below(semi_axes.fold(f64::INFINITY, f64::min));
        let scaled = |body: &AxialSpheroid| AxialSpheroid {
            centre: body.centre / unit,
            axial: body.axial / unit,
            equatorial: body.equatorial / unit,
        };
        let surroundings = match surroundings {
            Surroundings::Unbounded => Surroundings::Unbounded,
            Surroundings::Ball { radius } => Surroundings::Ball {
                radius: radius / unit,
            },
            Surroundings::Cylinder { radius } => Surroundings::Cylinder {
                radius: radius / unit,
            },
        };
        let mut given: Vec<usize> = (0..bodies.len()).collect();
        given.sort_by(|&i, &j| bodies[i].centre.total_cmp(&bodies[j].centre));
        // the difference of near numbers is exact: subtracted before it is scaled
        let first = bodies[given[0]].centre;
        let mut sorted: Vec<AxialSpheroid> = given
            .iter()
            .map(|&i| match surroundings {
                Surroundings::Ball { .. } => scaled(&bodies[i]),
                _ => scaled(&AxialSpheroid {
                    centre: bodies[i].centre - first,
                    ..bodies[i]
                }),
            })
            .collect();
        let gaps = sorted
            .windows(2)
            .map(|pair| pair[1].centre - pair[1].axial - pair[0].centre - pair[0].axial);
        let to_wall = sorted.iter().map(|body| match surroundings {
            Surroundings::Ball { radius } => radius - body.centre.abs() - body.axial,
            _ => 1.0,
        });
        let smallest = gaps.chain(to_wall).fold(1.0, f64::min);
        let grid = GRID * power_of_two_below(smallest.max(GRID));
        let rounded = |x: f64| (x / grid).round() * grid;
        let mut mirrored: Vec<AxialSpheroid> = sorted.iter().rev().copied().collect();
        let last = match surroundings {
            Surroundings::Ball { .. } => 0.0,
            _ => sorted[sorted.len() - 1].centre,
        };
        for body in &mut mirrored {
            // positive zero at the centre of a ball
            body.centre = rounded(last - body.centre) + 0.0;
        }
        for body in &mut sorted {
            body.centre = rounded(body.centre) + 0.0;
        }
        let numbers = |list: &[AxialSpheroid]| -> Vec<[f64; 3]> {
            list.iter()
                .map(|b| [b.axial, b.equatorial, b.centre])
                .collect()
        };
        let mut is_mirrored = false;
        if numbers(&mirrored) < numbers(&sorted) {
            given.reverse();
            sorted = mirrored;
            is_mirrored = true;
        }
        Self {
            bodies: sorted,
            surroundings,
            given,
            is_mirrored,
            unit,
        }
    }

    /// The bits of all numbers that determine the flow.
    pub fn bits(&self) -> Vec<u64> {
        let wall = match self.surroundings {
            Surroundings::Unbounded => [0.0, 0.0],
            Surroundings::Ball { radius } => [1.0, radius],
            Surroundings::Cylinder { radius } => [2.0, radius],
        };
        let bodies = self
            .bodies
            .iter()
            .flat_map(|b| [b.centre, b.axial, b.equatorial]);
        wall.into_iter().chain(bodies).map(f64::to_bits).collect()
    }

    /// A result for these bodies in the caller's order and unit of length.
    ///
    /// # Errors
    /// [`AxisymmetricError::OutOfRange`].
    pub fn in_units_of_caller(
        &self,
        found: AxialResistance,
        motion: Motion,
    ) -> Result<AxialResistance, AxisymmetricError> {
        // forces per velocity are lengths, torques per angular velocity volumes
        let factor = match motion {
            Motion::Translation | Motion::Surfaces => self.unit,
            Motion::Rotation => self.unit.powi(3),
        };
        // Place in the list of the caller, and factor of each velocity. All bodies reverse their
        // velocities in a mirror image, which does not change the matrix.
        let mut places: Vec<(usize, f64)> = self.given.iter().map(|&body| (body, 1.0)).collect();
        if motion == Motion::Surfaces {
            for (&body, mode) in self
                .given
                .iter()
                .flat_map(|b| (0..MODES).map(move |m| (b, m)))
            {
                let sign = if self.is_mirrored {
                    -PARITIES[mode]
                } else {
                    1.0
                };
                let place = self.given.len() + MODES * body + mode;
                places.push((place, sign * self.unit.powi(LENGTHS[mode])));
            }
        }
        let mut converted = found.clone();
        for (from, to) in [
            (&found.matrix, &mut converted.matrix),
            (&found.lower_order, &mut converted.lower_order),
        ] {
            for (i, &(row, of_row)) in places.iter().enumerate() {
                for (j, &(column, of_column)) in places.iter().enumerate() {
                    to[(row, column)] = of_row * of_column * factor * from[(i, j)];
                }
            }
            if !to.diagonal().iter().all(|r| r.is_normal()) {
                let semi_axis = self.unit;
                return Err(AxisymmetricError::OutOfRange { semi_axis });
            }
        }
        Ok(converted)
    }
}

/// The largest power of two that is not above a positive `x`.
fn power_of_two_below(x: f64) -> f64 {
    const EXPONENT: u64 = 0x7ff << 52;
    if x.is_normal() {
        // without the digits of the fraction
        return f64::from_bits(x.to_bits() & EXPONENT);
    }
    // the highest bit of a subnormal number
    f64::from_bits(1 << (63 - x.to_bits().max(1).leading_zeros()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_two_are_at_most_a_factor_of_two_below() {
        for x in [1.0, 1.9, 2.0, 0.3, 1e300, 1e-300, 1e-310, 5e-324] {
            let power = power_of_two_below(x);
            assert!(power <= x && x < 2.0 * power, "{x:e} {power:e}");
        }
        assert_eq!(power_of_two_below(0.75), 0.5);
    }

    #[test]
    fn mirror_images_and_shifted_bodies_have_equal_representatives() {
        let at = |z: f64, radius: f64| AxialSpheroid::sphere(z, radius);
        let bits =
            |bodies: &[AxialSpheroid], surroundings| Canonical::new(bodies, surroundings).bits();
        let tube = Surroundings::Cylinder { radius: 3.0 };
        let ball = Surroundings::Ball { radius: 30.0 };
        let one = [at(0.0, 1.0), at(6.1, 1.0), at(16.1, 1.0)];
        // reversed, in another order, and with rounding errors
        let other = [at(3.1, 1.0), at(-6.9, 1.0), at(9.2, 1.0)];
        assert_eq!(
            bits(&one, Surroundings::Unbounded),
            bits(&other, Surroundings::Unbounded)
        );
        assert_eq!(bits(&one, tube), bits(&other, tube));
        // the centre of the ball distinguishes them
        assert_ne!(bits(&one, ball), bits(&other, ball));
        let mirrored = one.map(|b| at(-b.centre, b.axial));
        assert_eq!(bits(&one, ball), bits(&mirrored, ball));
        let unlike = [at(0.0, 1.0), at(6.1, 1.2), at(16.1, 1.0)];
        assert_ne!(bits(&one, tube), bits(&unlike, tube));
    }
}
