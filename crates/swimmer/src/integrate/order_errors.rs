//! Errors of successive orders of the collocation, from the changes between them.

/// Ratio of successive changes up to which a single change is trusted, and corrections are
/// interpolated.
const SURE_RATIO: f64 = 0.1;

/// Error of the last of several orders, from the changes between successive orders.
///
/// A change is the error of the order before. Errors decrease geometrically, at first by a smooth
/// part of the velocity and later by a ratio that the nearest singularity determines, with changing
/// signs: single changes are far below their neighbours by chance. Therefore the largest ratio `r`
/// of successive changes `c_k` counts, or the one expected for the singularity, `least_ratio`, and
/// the error of order `n` is estimated as the largest of all `c_k r^(n-k+1) / (1 - r)`, the sum of
/// the changes still to come. Changes that no longer decrease are noise of their own size.
pub(super) fn remaining_error(changes: &[f64], least_ratio: f64) -> f64 {
    match *changes {
        // Near contact a single change may be small by chance.
        [_] if least_ratio > SURE_RATIO => return f64::INFINITY,
        [change] => return change,
        [.., before, last] if is_stalled(before, last) => return 2.0 * before.max(last),
        _ => {}
    }
    let pairs = changes
        .windows(2)
        .filter(|pair| !is_stalled(pair[0], pair[1]));
    let ratio = pairs.fold(least_ratio, |ratio, pair| ratio.max(pair[1] / pair[0]));
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
