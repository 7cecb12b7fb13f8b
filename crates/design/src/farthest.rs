//! The stroke of the largest displacement of two joints.

use models::ShapeGeometry;

use super::objective::DisplacementMeasure;
use super::optimise::Optimum;
use super::stroke_path::{SampledPath, StrokeCurve};
use super::totals::Stroke;
use crate::error::DesignError;

/// Number of values per joint at which the sign of the curvature is checked.
const CHECKS: usize = 64;

/// Rotation per change of a joint, relative to the displacement, that counts as none.
const ROTATION: f64 = 1e-8;

/// The simple closed curve of the largest displacement inside `limits`.
///
/// The displacement of a swimmer that does not turn is the integral of the curvature over the area
/// inside the curve (Stokes' theorem). If the curvature has one sign, the curve is the boundary of
/// the rectangle. Each side is passed at a constant rate, in a time that makes the mean power of
/// all sides equal.
///
/// Curves that wind several times go farther, with one stroke per winding.
///
/// # Errors
/// [`DesignError::NoStroke`] for other numbers of joints, a swimmer that turns, and a curvature
/// that changes its sign.
pub fn farthest(
    geometry: &ShapeGeometry,
    measure: DisplacementMeasure,
    limits: &[(f64, f64)],
) -> Result<Optimum, DesignError> {
    let refuse = |problem: &str| {
        DesignError::no_stroke(format!("{problem}; use the objective efficiency or energy"))
    };
    let [x, y] = limits else {
        return Err(refuse("the largest displacement is known for two joints"));
    };
    let mut strengths = Vec::new();
    let at = |range: &(f64, f64), k: usize| {
        range.0 + (range.1 - range.0) * k as f64 / (CHECKS - 1) as f64
    };
    let middle = geometry
        .at(&[0.5 * (x.0 + x.1), 0.5 * (y.0 + y.1)])?
        .curvature(0, 1);
    let direction = match measure {
        DisplacementMeasure::Along(direction) => direction,
        DisplacementMeasure::Length => middle.fixed_rows::<3>(0).normalize(),
    };
    for row in 0..CHECKS {
        for column in 0..CHECKS {
            let local = geometry.at(&[at(x, column), at(y, row)])?;
            let is_turning = (local.connection.iter())
                .any(|a| a.fixed_rows::<3>(3).norm() > ROTATION * a.fixed_rows::<3>(0).norm());
            if is_turning {
                return Err(refuse("the swimmer turns"));
            }
            strengths.push(local.curvature(0, 1).fixed_rows::<3>(0).dot(&direction));
        }
    }
    let sign = strengths[0].signum();
    if strengths.iter().any(|s| s * sign <= 0.0) {
        return Err(refuse("the curvature changes its sign within the limits"));
    }
    let mut corners = vec![
        vec![x.1, y.1],
        vec![x.0, y.1],
        vec![x.0, y.0],
        vec![x.1, y.0],
    ];
    if sign < 0.0 {
        corners.reverse();
    }
    let equal: Vec<f64> = (0..=4).map(|k| 0.25 * f64::from(k)).collect();
    let path = SampledPath::from_polygon(&corners, &equal);
    let per_side = path.shapes.len() / 4;
    // The time of a side is proportional to the root of its energy in equal times.
    let mut times = vec![0.0];
    for side in 0..4 {
        let points = side * per_side..(side + 1) * per_side;
        let part = SampledPath {
            widths: path.widths[side * path.widths.len() / 4..(side + 1) * path.widths.len() / 4]
                .to_vec(),
            shapes: path.shapes[points.clone()].to_vec(),
            rates: path.rates[points].to_vec(),
        };
        let energy = Stroke::along(geometry, &part)?.totals.energy;
        times.push(times[side] + energy.sqrt());
    }
    let end = times[4];
    let times: Vec<f64> = times.iter().map(|t| t / end).collect();
    let stroke = Stroke::along(geometry, &SampledPath::from_polygon(&corners, &times))?;
    Ok(Optimum {
        cost: -measure.of(&stroke.totals).0,
        totals: stroke.totals,
        period_energy_product: stroke.length.powi(2),
        refinement_error: 0.0,
        at_limits: true,
        starts: 0,
        iterations: 0,
        curve: StrokeCurve::Polygon { corners, times },
    })
}
