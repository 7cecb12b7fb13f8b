//! Errors of successive orders of the collocation, from the changes between them.

/// Ratio of successive changes up to which a single change is trusted, and corrections are
/// interpolated.
const SURE_RATIO: f64 = 0.1;

/// Error of the last of several orders, from the changes between successive orders.
///
/// The change from one order to the next estimates the error of the lower one. Errors decrease
/// geometrically, with changing signs, so single changes may be small by chance. The ratio `r` is
/// therefore the largest ratio of successive changes `c_k`, and at least `least_ratio`, which the
/// nearest singularity determines. The error of order `n` is the largest `c_k r^(n-k+1) / (1 - r)`,
/// a bound of the sum of all later changes. If the changes stop decreasing, it is twice the larger
/// of the last two.
pub(super) fn remaining_error(changes: &[f64], least_ratio: f64) -> f64 {
    match *changes {
        // Near contact a single change may be small by chance.
        [_] if least_ratio > SURE_RATIO => return f64::INFINITY,
        [change] => return change,
        [.., before, last] if is_stalled(before, last) => return 2.0 * before.max(last),
        _ => {}
    }
    let ratio = largest_ratio(changes, least_ratio);
    let largest = |error: f64, &change: &f64| ratio * error.max(change);
    changes.iter().fold(0.0, largest) / (1.0 - ratio)
}

/// Largest ratio of successive changes that decrease, at least `least_ratio`.
fn largest_ratio(changes: &[f64], least_ratio: f64) -> f64 {
    let pairs = changes.windows(2);
    let decreasing = pairs.filter(|pair| !is_stalled(pair[0], pair[1]));
    decreasing.fold(least_ratio, |ratio, pair| ratio.max(pair[1] / pair[0]))
}

/// Share of the ratio that contact causes below which no ratio of errors is trusted.
///
/// Lubrication is a weak singularity: the errors of few points decrease faster than those of many.
/// Bars of 600 random strokes of three spheres, with singularities of lubrication added to the
/// mobility of Rotne, Prager and Yamakawa, held in 99 % with this share, with the median 7.6 of bar
/// and error, and in 98 % with 0.5 (7.1). Single errors were up to 1.2 and 1.8 bars.
///
/// Of 109 random collinear strokes by multipoles, which had no part in the choice, 99 % of the bars
/// of displacements held, the worst error was 1.04 bars, and the median of bar and error 16.7
/// (`docs/figures/random_cases.py`).
const CONTACT_SHARE: f64 = 0.7;

/// Uncertainty of the error of a motion, relative to it: with 0.3 bars of the same strokes held in
/// 98 %.
const MOTION_UNCERTAINTY: f64 = 0.5;

/// Uncertainty of the error of works and loads, which are singular at contact: with 1, three errors
/// of eleven works of random strokes were up to 1.4 bars.
const LOAD_UNCERTAINTY: f64 = 2.0;

/// Estimated error of the last of several orders, as a multiple of the last change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SignedError {
    /// The error, computed minus exact, over the last change.
    pub ratio: f64,
    /// Uncertainty of the error.
    pub uncertainty: f64,
}

impl SignedError {
    /// The error from the sizes of the changes between successive orders.
    ///
    /// It is what bars report; whether a step is accepted is decided by the more cautious
    /// [`remaining_error`]. That bound carries the largest ratio of changes on from the first
    /// order, and has no sign, although errors of opposite phases of a stroke cancel: its sum over
    /// a stroke was 400 times the error.
    ///
    /// All further changes are expected to have the sign of the last one, as they have for a
    /// singularity beside the step (the remainder of Gauss quadrature is a derivative of even
    /// order), and to decrease by the largest ratio `r` so far: the error is `-r / (1 - r)` times
    /// the last change. Where that is small by chance, as where changes turn their sign, the change
    /// before counts, times its ratio to the one before. A single change, or changes that stop to
    /// decrease, leave a size without a sign.
    fn new(changes: &[f64], least_ratio: f64, relative_uncertainty: f64) -> Self {
        let (before, last) = match *changes {
            [] => return Self::unsigned(0.0),
            [change] => return Self::unsigned(change),
            [.., before, last] if is_stalled(before, last) => {
                return Self::unsigned(before.max(last));
            }
            [.., before, last] => (before, last),
        };
        let ratio = largest_ratio(changes, least_ratio);
        let typical = match *changes {
            [.., first, _, _] if first > 0.0 => before * (before / first).min(0.5),
            _ => 0.0,
        };
        let error = last.max(typical) * ratio / (1.0 - ratio);
        match last > 0.0 {
            true => Self {
                ratio: -error / last,
                uncertainty: relative_uncertainty * error,
            },
            false => Self::unsigned(error),
        }
    }

    /// The error of a displacement or rotation, for the ratio that contact causes.
    pub fn of_motion(changes: &[f64], least_ratio: f64) -> Self {
        Self::new(changes, CONTACT_SHARE * least_ratio, MOTION_UNCERTAINTY)
    }

    /// The error of a work or load, which grows without bound towards contact.
    pub fn of_load(changes: &[f64], least_ratio: f64) -> Self {
        Self::new(changes, least_ratio, LOAD_UNCERTAINTY)
    }

    /// An error of this size at most.
    pub fn unsigned(size: f64) -> Self {
        Self {
            ratio: 0.0,
            uncertainty: size,
        }
    }

    /// Size of the error without regard to its sign.
    pub fn size(&self, changes: &[f64]) -> f64 {
        let last = changes.last().copied().unwrap_or(0.0);
        self.uncertainty.max(self.ratio.abs() * last)
    }
}

/// Error expected of the order after the last one, if the changes go on to decrease as before.
pub(super) fn expected_error(changes: &[f64], least_ratio: f64) -> f64 {
    let next = match *changes {
        [.., before, last] => last * (last / before).max(least_ratio),
        [change] => change * least_ratio,
        [] => return f64::INFINITY,
    };
    remaining_error(&[changes, &[next]].concat(), least_ratio)
}

/// Whether the changes between orders decrease so fast that corrections can be interpolated.
pub(super) fn is_smooth(changes: &[f64], least_ratio: f64) -> bool {
    least_ratio <= SURE_RATIO
        && changes
            .windows(2)
            .all(|pair| pair[1] <= SURE_RATIO * pair[0])
}

/// Whether the change by an order is not clearly smaller than that by the order before.
pub(super) fn is_stalled(before: f64, change: f64) -> bool {
    change > 0.5 * before
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::gauss::Gauss;

    /// The power of an arm that oscillates near another body, over quarters of its period.
    #[test]
    fn the_bar_of_a_smooth_power_is_not_too_wide() {
        let power = |t: f64| t.cos().powi(2) * (1.0 + 1.0 / (1.0 - 1.5 / (6.0 + 2.0 * t.sin())));
        for quarter in 0..4 {
            let work = |points: usize| -> f64 {
                let gauss = Gauss::new(points);
                let at = |node: &f64| power(FRAC_PI_2 * (f64::from(quarter) + node));
                let values = gauss.nodes.iter().map(at);
                values.zip(&gauss.weights).map(|(p, w)| w * p).sum()
            };
            let exact = work(30);
            let mut changes = vec![(work(2) - work(1)).abs()];
            for points in 3..=8 {
                changes.push((work(points) - work(points - 1)).abs());
                let error = (work(points) - exact).abs();
                let estimate = SignedError::of_load(&changes, 0.05);
                let bar = (estimate.ratio * changes[points - 2]).hypot(estimate.uncertainty);
                assert!(
                    error <= bar + 1e-15,
                    "{quarter} {points}: {error:e} {bar:e}"
                );
                // The changes decrease by 0.15 per order at most.
                let allowed = changes[0] * 0.2_f64.powi(points as i32 - 2);
                assert!(bar < allowed, "{quarter} {points}: {bar:e} {allowed:e}");
            }
        }
    }
}
