//! Limits on the ratios of lengths.

use crate::AxisymmetricError;
use crate::meridian::Surroundings;
use crate::spheroid::Spheroid;

/// Largest ratio of the semi-axes of a body; the number of triangles is 30 times the ratio.
const MAX_ASPECT: f64 = 500.0;

/// Largest length of the problem relative to the smallest semi-axis.
const MAX_RATIO: f64 = 1e6;

/// Fails if lengths differ so much that meshes are too large or positions are rounded too much.
pub(crate) fn check_sizes(
    bodies: &[Spheroid],
    surroundings: Surroundings,
) -> Result<(), AxisymmetricError> {
    let fold = |f: fn(f64, f64) -> f64, lengths: &dyn Fn(&Spheroid) -> f64| {
        bodies.iter().map(lengths).reduce(f).unwrap_or(0.0)
    };
    let smallest = fold(f64::min, &|b| b.axial.min(b.equatorial));
    let right = fold(f64::max, &|b| b.centre + b.axial.max(b.equatorial));
    let left = fold(f64::min, &|b| b.centre - b.axial.max(b.equatorial));
    let largest = match surroundings {
        Surroundings::Unbounded => right - left,
        Surroundings::Ball { radius } => radius,
        Surroundings::Cylinder { radius } => radius.max(right - left),
    };
    for (i, body) in bodies.iter().enumerate() {
        let aspect = body.axial.max(body.equatorial) / body.axial.min(body.equatorial);
        if aspect > MAX_ASPECT {
            return Err(AxisymmetricError::TooSlender {
                body: i,
                aspect,
                limit: MAX_ASPECT,
            });
        }
    }
    let ratio = largest / smallest;
    if ratio <= MAX_RATIO {
        return Ok(());
    }
    Err(AxisymmetricError::SizesTooDifferent {
        ratio,
        limit: MAX_RATIO,
    })
}
