//! Backward differentiation formulae of variable steps.

/// The derivative at the end of a step as a sum over time levels, the newest first.
///
/// ```text
/// du/dt ≈ (c_0 u_new + c_1 u_1 + c_2 u_2) / Δt
/// ```
///
/// With the ratio `r` of the step to the one before, BDF2 has `c_0 = (1 + 2 r) / (1 + r)`,
/// `c_1 = -(1 + r)`, `c_2 = r^2 / (1 + r)` (Hairer, Nørsett, Wanner, Solving Ordinary Differential
/// Equations I, section III.5). The first step is BDF1, the implicit Euler method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeDerivative {
    /// Length of the step.
    pub step: f64,
    /// Coefficients of the new and of the two older levels.
    pub coefficients: [f64; 3],
    /// Factor from the difference of a new value from its prediction to the error of the value;
    /// zero if there are too few levels to predict.
    pub error_factor: f64,
}

impl TimeDerivative {
    /// The formula of a step, after steps of these lengths, the last one first.
    ///
    /// The error of BDF2 is `Δt^2 (Δt + Δt_1) u''' / (6 c_0)`, and a quadratic prediction from
    /// three levels differs from the new value by `Δt (Δt + Δt_1) (Δt + Δt_1 + Δt_2) u''' / 6`.
    /// With two levels the prediction is linear and differs by `Δt (Δt + Δt_1) u'' / 2`; the error
    /// is then overestimated by that of BDF1, `Δt^2 u'' / 2`.
    pub fn new(step: f64, before: &[f64]) -> Self {
        let Some(&first) = before.first() else {
            return Self {
                step,
                coefficients: [1.0, -1.0, 0.0],
                error_factor: 0.0,
            };
        };
        let ratio = step / first;
        let newest = (1.0 + 2.0 * ratio) / (1.0 + ratio);
        let error_factor = match before.get(1) {
            Some(second) => step / (newest * (step + first + second)),
            None => step / (step + first),
        };
        Self {
            step,
            coefficients: [newest, -(1.0 + ratio), ratio * ratio / (1.0 + ratio)],
            error_factor,
        }
    }

    /// Coefficient `c_0 / Δt` of the new value.
    pub fn newest(&self) -> f64 {
        self.coefficients[0] / self.step
    }

    /// Coefficient `c_k / Δt` of the value `k` levels before the new one.
    pub fn older(&self, k: usize) -> f64 {
        self.coefficients[k] / self.step
    }
}

/// Weights of the values of older levels, the newest first, that extrapolate to the end of a step.
///
/// `before` are the lengths of the steps between them. The polynomial has degree `weights.len() -
/// 1`.
pub fn extrapolation(step: f64, before: &[f64]) -> Vec<f64> {
    // times of the levels before the new one
    let mut ages = vec![step];
    for length in before {
        ages.push(ages[ages.len() - 1] + length);
    }
    (0..ages.len())
        .map(|k| {
            let others = (0..ages.len()).filter(|&j| j != k);
            others.map(|j| ages[j] / (ages[j] - ages[k])).product()
        })
        .collect()
}

/// Factor from the length of a step with this relative error to that of the next, for BDF2.
///
/// The local error is of third order. 0.9 leaves a reserve; steps at most double, below the ratio
/// `1 + 2^(1/2)` up to which BDF2 with variable steps is stable (Grigorieff 1983). Without an
/// estimate, which is infinite, the length stays.
fn step_factor(tolerance: f64, error: f64) -> f64 {
    match error.is_finite() {
        true => (0.9 * (tolerance / error).cbrt()).clamp(0.2, 2.0),
        false => 1.0,
    }
}

/// An adaptive step that would have to be shorter than rounding allows.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "at time {time} a step of {step:.3e} still has the error {error:.3e} of {tolerance:.3e}; is \
     there a jump in the motion that is not a restart? Raise the tolerance or restart there"
)]
pub struct StepTooShort {
    /// Time before the step.
    pub time: f64,
    /// Length of the step.
    pub step: f64,
    /// Its error.
    pub error: f64,
    /// Largest error allowed.
    pub tolerance: f64,
}

/// Lengths of steps whose errors stay below a tolerance.
///
/// ```
/// use linalg::StepControl;
///
/// let mut steps = StepControl::new(0.4, 1e-12);
/// // The end is 0.5 away: two equal steps instead of a rest of 0.1.
/// assert_eq!(steps.next(0.5), 0.25);
/// // The error of a step of 0.4 is 1 / 8 of what is allowed, so the next may be 1.8 times longer.
/// assert!(steps.accepts(0.0, 0.4, 1.0, 8.0)?);
/// assert!((steps.next(10.0) - 0.72).abs() < 1e-15);
/// # Ok::<(), linalg::StepTooShort>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepControl {
    length: f64,
    least: f64,
}

/// Shortest step relative to the times of an integration: rounding.
const LEAST_STEP: f64 = 1e-12;

/// Part of the length of a step above which it says how long the next one may be; a shorter one
/// ends where the motion does.
const WHOLE: f64 = 0.99;

/// Factor below which a longer step is not worth a new matrix, which depends on the length.
const WORTHWHILE: f64 = 1.2;

impl StepControl {
    /// Begins with steps of the length `first`; none is shorter than `least`.
    pub fn new(first: f64, least: f64) -> Self {
        Self {
            length: first,
            least,
        }
    }

    /// Begins at the time `start` with steps of the length `first`, until `end`; none is so short
    /// that rounding of the times counts.
    pub fn between(first: f64, start: f64, end: f64) -> Self {
        Self::new(first, LEAST_STEP * end.abs().max(end - start))
    }

    /// Length of the next step, `left` before the end.
    ///
    /// No rest is left that is shorter than half a step.
    pub fn next(&self, left: f64) -> f64 {
        match left < 1.5 * self.length && left > self.length * (1.0 + 1e-9) {
            true => 0.5 * left,
            false => self.length.min(left),
        }
    }

    /// The length that the error of the last step allows, without regard to the end.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Continues with steps that are at most this long.
    pub fn shorten(&mut self, length: f64) {
        self.length = self.length.min(length);
    }

    /// Whether a step from `time` with this error is accepted; chooses the length of the next.
    ///
    /// The error is infinite where too few levels are known for an estimate; such a step is
    /// accepted.
    ///
    /// # Errors
    /// [`StepTooShort`] for a step that would have to be repeated with less than the least length.
    pub fn accepts(
        &mut self,
        time: f64,
        step: f64,
        error: f64,
        tolerance: f64,
    ) -> Result<bool, StepTooShort> {
        let factor = step_factor(tolerance, error);
        if !error.is_finite() || error <= tolerance {
            if step >= WHOLE * self.length && !(1.0..WORTHWHILE).contains(&factor) {
                self.length = factor.max(0.5) * step;
            }
            return Ok(true);
        }
        self.length = factor.min(0.9) * step;
        match self.length <= self.least {
            false => Ok(false),
            true => Err(StepTooShort {
                time,
                step,
                error,
                tolerance,
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bdf2_differentiates_quadratics_exactly_and_extrapolation_reproduces_them() {
        let f = |t: f64| 1.0 - 2.0 * t + 3.0 * t * t;
        let (step, before) = (0.3, [0.2, 0.5]);
        let times = [step, 0.0, -0.2, -0.7];
        let bdf = TimeDerivative::new(step, &before);
        let sum: f64 = (0..3).map(|k| bdf.older(k) * f(times[k])).sum();
        assert!((sum - (-2.0 + 6.0 * step)).abs() < 1e-13);
        let weights = extrapolation(step, &before);
        let sum: f64 = (0..3).map(|k| weights[k] * f(times[k + 1])).sum();
        assert!((sum - f(step)).abs() < 1e-13);
    }

    #[test]
    fn steps_with_an_error_shrink_and_those_without_an_estimate_stay() {
        assert_eq!(step_factor(1e-6, f64::INFINITY), 1.0);
        assert_eq!(step_factor(1e-6, 0.0), 2.0);
        assert!((step_factor(1e-6, 8e-6) - 0.45).abs() < 1e-15);
    }

    #[test]
    fn steps_are_repeated_until_they_are_too_short() {
        let mut steps = StepControl::new(1.0, 0.05);
        assert_eq!(steps.accepts(2.0, 1.0, f64::INFINITY, 1e-3), Ok(true));
        assert_eq!(steps.accepts(2.0, 1.0, 1.0, 1e-3), Ok(false));
        assert_eq!(steps.next(9.0), 0.2);
        let short = steps.accepts(2.0, 0.2, 1.0, 1e-3).unwrap_err();
        assert_eq!((short.time, short.step), (2.0, 0.2));
        // the last step before the end says nothing about the next
        let mut steps = StepControl::new(1.0, 0.0);
        assert_eq!(steps.accepts(0.0, 0.1, 1e-9, 1e-3), Ok(true));
        assert_eq!(steps.length(), 1.0);
    }

    #[test]
    fn the_error_factor_gives_the_error_of_a_cubic() {
        // u = t^3: the BDF2 solution of u' = 3 t^2 from exact levels errs by the residual / c_0
        let (step, before) = (0.3, [0.2, 0.5]);
        let f = |t: f64| t * t * t;
        let times = [step, 0.0, -0.2, -0.7];
        let bdf = TimeDerivative::new(step, &before);
        let history: f64 = (1..3).map(|k| bdf.older(k) * f(times[k])).sum();
        let computed = (3.0 * step * step - history) / bdf.newest();
        let weights = extrapolation(step, &before);
        let predicted: f64 = (0..3).map(|k| weights[k] * f(times[k + 1])).sum();
        let error = computed - f(step);
        let estimate = (f(step) - predicted) * bdf.error_factor;
        assert!(
            (estimate.abs() - error.abs()).abs() < 1e-13,
            "{estimate} {error}"
        );
    }
}
