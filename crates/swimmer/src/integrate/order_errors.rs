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
    let ratio_at = |k: usize| changes[k] / changes[k - 1];
    error_by_ratios(changes, least_ratio, ratio_at)
}

/// The error as in [`remaining_error`], for a quantity on which no step depends, such as the work.
///
/// After a change that is small by chance the ratio of the next one is large. Carried on from the
/// first order, a single ratio of 0.49 made the bar of a smooth gait's work 4e-4 where the error
/// was 2e-10. Here the ratio over two orders counts where it is smaller. Decisions about steps keep
/// the more cautious ratio.
pub(super) fn reported_error(changes: &[f64], least_ratio: f64) -> f64 {
    let ratio_at = |k: usize| {
        let ratio = changes[k] / changes[k - 1];
        match k {
            1 => ratio,
            k => ratio.min((changes[k] / changes[k - 2]).sqrt()),
        }
    };
    error_by_ratios(changes, least_ratio, ratio_at)
}

/// The error of the last order, with the ratio that `ratio_at` gives for each change but the first.
fn error_by_ratios(changes: &[f64], least_ratio: f64, ratio_at: impl Fn(usize) -> f64) -> f64 {
    match *changes {
        // Near contact a single change may be small by chance.
        [_] if least_ratio > SURE_RATIO => return f64::INFINITY,
        [change] => return change,
        [.., before, last] if is_stalled(before, last) => return 2.0 * before.max(last),
        _ => {}
    }
    let decreasing = (1..changes.len()).filter(|&k| !is_stalled(changes[k - 1], changes[k]));
    let ratio = decreasing.fold(least_ratio, |ratio, k| ratio.max(ratio_at(k)));
    let largest = |error: f64, &change: &f64| ratio * error.max(change);
    changes.iter().fold(0.0, largest) / (1.0 - ratio)
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
                let bar = reported_error(&changes, 0.05);
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
