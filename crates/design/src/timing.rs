//! Timing of a stroke: its shortest period within bounds on rates and power.

use models::{ModelError, ShapeGeometry};
use nalgebra::DVector;
use scene::{Scene, spans};

use super::limits::StrokeLimits;
use super::quadrature::GaussRule;
use super::stroke_path::StrokeCurve;
use crate::error::DesignError;

/// Rows per term of a series: the error of the cubic spline is then `(π/16)^4 / 384 = 4e-6` of the
/// amplitude of the highest term.
const ROWS_PER_TERM: usize = 16;

/// Rows of a polygon with a bound on the power, at least. The power changes along a side, the rates
/// of a row do not.
const ROWS_PER_POLYGON: usize = 512;

/// Rows per side of such a polygon, at least.
const ROWS_PER_SIDE: usize = 4;

/// Number of times at which the largest rates and powers of a scene are measured, at least.
const CHECKS: usize = 2048;

/// Smallest number of these times per phase span.
const CHECKS_PER_SPAN: usize = 8;

/// Number of intervals of the quadrature of the energy of a scene, at least.
const ENERGY_INTERVALS: usize = 64;

/// Bounds `optimise.max_rate` and `optimise.max_power` on the motion along a stroke.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionBounds {
    /// Largest rate of each joint that moves; infinite without a bound.
    pub rates: Vec<f64>,
    /// Largest power on the fluid; infinite without a bound.
    pub power: f64,
}

/// Largest values along a stroke.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Peaks {
    /// Largest rate of each joint that moves.
    pub rates: Vec<f64>,
    /// Largest power on the fluid.
    pub power: f64,
}

/// Points of a curve and the times at which they are reached.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Timing {
    /// Parameters of the curve, from 0 to 1.
    pub parameters: Vec<f64>,
    /// Times, from 0 to the period.
    pub times: Vec<f64>,
    /// Whether the times are proportional to the parameters.
    pub is_uniform: bool,
}

impl MotionBounds {
    /// The bounds of a scene; none if it has neither key.
    ///
    /// # Errors
    /// Values that do not fit the joints.
    pub fn from_scene(scene: &Scene, limits: &StrokeLimits) -> Result<Option<Self>, DesignError> {
        let options = scene.optimise();
        let mut rates = vec![f64::INFINITY; limits.variables.len()];
        if let Some(values) = &options.max_rate {
            let values = scene.joint_values("optimise.max_rate", values)?;
            for (rate, &joint) in rates.iter_mut().zip(&limits.variables) {
                *rate = values[joint].unwrap_or(*rate);
            }
        }
        let power = options.max_power.unwrap_or(f64::INFINITY);
        let all_finite = power.is_finite() || rates.iter().all(|rate| rate.is_finite());
        if options.max_rate.is_some() && !all_finite {
            return Err(DesignError::not_applicable(
                scene,
                "optimise.max_rate",
                "a joint that moves has no largest rate; give one value for all joints, or \
                 optimise.max_power",
            ));
        }
        Ok(all_finite.then_some(Self { rates, power }))
    }

    /// How many times as fast as the bounds allow: the largest of `|rate| / bound` and of the root
    /// of `power / bound`, which is proportional to the rates.
    pub fn load(&self, rates: &[f64], power: f64) -> f64 {
        let pairs = rates.iter().zip(&self.rates);
        let of_rates = pairs.fold(0.0_f64, |load, (rate, bound)| load.max(rate.abs() / bound));
        of_rates.max((power / self.power).max(0.0).sqrt())
    }
}

impl Timing {
    /// Times proportional to the parameter.
    pub fn uniform(curve: &StrokeCurve, period: f64) -> Self {
        let parameters = match curve {
            StrokeCurve::Polygon { times, .. } => times.clone(),
            StrokeCurve::Series { .. } => equal_steps(ROWS_PER_TERM * curve.terms()),
        };
        Self {
            times: parameters.iter().map(|u| period * u).collect(),
            parameters,
            is_uniform: true,
        }
    }

    /// The fastest motion along a curve within bounds, of which one is active at every time.
    ///
    /// ```text
    /// T = ∫ max(max_i |dq_i/du| / v_i, sqrt(dq/du · G dq/du / P)) du
    /// ```
    ///
    /// with the largest rates `v` and the largest power `P`. Where the power rules it is constant.
    /// Only with a bound on the power, `T = length / sqrt(P)` with the length in the metric `G`, so
    /// that the stroke of the highest efficiency is the one of the largest displacement per time.
    ///
    /// # Errors
    /// Those of the table.
    pub fn fastest(
        geometry: &ShapeGeometry,
        curve: &StrokeCurve,
        bounds: &MotionBounds,
    ) -> Result<Self, ModelError> {
        let rule = GaussRule::new();
        let rows_per_side = match bounds.power.is_finite() {
            true => ROWS_PER_POLYGON
                .div_ceil(curve.terms().max(1))
                .max(ROWS_PER_SIDE),
            false => 1,
        };
        let rows = match curve {
            StrokeCurve::Polygon { times, .. } => (times.windows(2))
                .flat_map(|side| {
                    let steps = equal_steps(rows_per_side).into_iter().skip(1);
                    // The last step is at the corner to the last bit.
                    steps.map(|s| (1.0 - s) * side[0] + s * side[1])
                })
                .collect(),
            StrokeCurve::Series { .. } => equal_steps(ROWS_PER_TERM * curve.terms()).split_off(1),
        };
        let (mut parameters, mut times) = (vec![0.0], vec![0.0]);
        let (mut from, mut time) = (0.0, 0.0);
        for to in rows {
            for (node, weight) in rule.nodes.iter().zip(rule.weights) {
                let u = from + node * (to - from);
                let (shape, rates) = (curve.shape(u), curve.rates(u));
                let power = power(geometry, &shape, &rates)?;
                time += weight * (to - from) * bounds.load(&rates, power);
            }
            from = to;
            // Rows at the same time would not be a motion.
            if time > *times.last().unwrap_or(&0.0) {
                parameters.push(to);
                times.push(time);
            }
        }
        Ok(Self {
            parameters,
            times,
            is_uniform: false,
        })
    }

    /// The same motion, slower by a factor.
    #[must_use]
    pub fn slower(mut self, factor: f64) -> Self {
        self.times.iter_mut().for_each(|time| *time *= factor);
        self
    }

    /// The period.
    pub fn period(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }

    /// Parameter of the curve at a share of the period, linear between the points.
    pub fn parameter(&self, share: f64) -> f64 {
        let time = share * self.period();
        let next = (self.times.partition_point(|t| *t <= time)).clamp(1, self.times.len() - 1);
        let (t, u) = (
            &self.times[next - 1..=next],
            &self.parameters[next - 1..=next],
        );
        u[0] + (u[1] - u[0]) * (time - t[0]) / (t[1] - t[0])
    }
}

/// Largest rates and power along the gait of a scene, and its largest load.
///
/// # Errors
/// A gait that cannot be followed, and errors of the table.
pub fn peaks(
    scene: &Scene,
    limits: &StrokeLimits,
    geometry: &ShapeGeometry,
    bounds: Option<&MotionBounds>,
) -> Result<(Peaks, f64), DesignError> {
    let cycle: Vec<_> = spans(scene.gait(), scene.articulation().initial_shape())?.collect();
    let checks = (CHECKS / cycle.len().max(1)).max(CHECKS_PER_SPAN);
    let mut largest = 0.0_f64;
    let mut peaks = Peaks {
        rates: vec![0.0; limits.variables.len()],
        power: 0.0,
    };
    for span in &cycle {
        for s in equal_steps(checks) {
            let (shape, rates) = (limits.moving(&span.shape(s)), limits.moving(&span.rates(s)));
            let power = power(geometry, &shape, &rates)?;
            for (peak, rate) in peaks.rates.iter_mut().zip(&rates) {
                *peak = peak.max(rate.abs());
            }
            peaks.power = peaks.power.max(power);
            largest = largest.max(bounds.map_or(0.0, |bounds| bounds.load(&rates, power)));
        }
    }
    Ok((peaks, largest))
}

/// Energy of one cycle of the gait of a scene on the fluid.
///
/// # Errors
/// A gait that cannot be followed, and errors of the table.
pub fn energy(
    scene: &Scene,
    limits: &StrokeLimits,
    geometry: &ShapeGeometry,
) -> Result<f64, DesignError> {
    let rule = GaussRule::new();
    let mut energy = 0.0;
    let cycle: Vec<_> = spans(scene.gait(), scene.articulation().initial_shape())?.collect();
    let parts = ENERGY_INTERVALS.div_ceil(cycle.len().max(1));
    for span in &cycle {
        for part in 0..parts {
            for (node, weight) in rule.nodes.iter().zip(rule.weights) {
                let s = (part as f64 + node) / parts as f64;
                let (shape, rates) = (limits.moving(&span.shape(s)), limits.moving(&span.rates(s)));
                let power = power(geometry, &shape, &rates)?;
                energy += weight * span.duration / parts as f64 * power;
            }
        }
    }
    Ok(energy)
}

/// Power `rates · G rates` on the fluid. Shapes outside the box by rounding count as its boundary.
fn power(geometry: &ShapeGeometry, shape: &[f64], rates: &[f64]) -> Result<f64, ModelError> {
    let ranges = shape.iter().zip(geometry.ranges());
    let shape: Vec<f64> = ranges.map(|(x, range)| x.clamp(range.0, range.1)).collect();
    let rates = DVector::from_column_slice(rates);
    Ok(rates.dot(&(geometry.at(&shape)?.metric * &rates)))
}

/// Numbers from 0 to 1 in equal steps.
fn equal_steps(count: usize) -> Vec<f64> {
    (0..=count).map(|k| k as f64 / count as f64).collect()
}
