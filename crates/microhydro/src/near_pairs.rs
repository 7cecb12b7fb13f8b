//! Pairs of points within a distance, found by a grid of cells.

use nalgebra::Vector3;

/// Smallest cell relative to the extent of the points, so that numbers of cells fit into integers.
const SMALLEST_CELL: f64 = 1e-6;

/// Calls `found` for each pair of points whose distance is at most `reach`, and for some others
/// with a distance of at most `4 reach`.
///
/// The first index of a pair is the smaller one; pairs come in no particular order, which is the
/// same for the same points. Points are finite. Cost: `O(n log n)` for points that are not crowded.
pub(crate) fn for_near_pairs(
    points: &[Vector3<f64>],
    reach: f64,
    mut found: impl FnMut(usize, usize),
) {
    let Some(first) = points.first() else { return };
    let lowest = points.iter().fold(*first, |low, x| low.inf(x));
    let highest = points.iter().fold(*first, |high, x| high.sup(x));
    let size = reach.max(SMALLEST_CELL * (highest - lowest).amax());
    let cell = |x: &Vector3<f64>| ((x - lowest) / size).map(|c| c as i64);
    let mut sorted: Vec<([i64; 3], usize)> = (points.iter().enumerate())
        .map(|(k, x)| (cell(x).into(), k))
        .collect();
    sorted.sort_unstable();
    let start = |key: [i64; 3]| sorted.partition_point(|(other, _)| *other < key);
    for &([i, j, k], point) in &sorted {
        // Cells along the last axis are neighbours in the list.
        for (di, dj) in (-1..=1).flat_map(|di| (-1..=1).map(move |dj| (di, dj))) {
            let column = [i + di, j + dj];
            let from = start([column[0], column[1], k - 1]);
            let near = sorted[from..]
                .iter()
                .take_while(|([a, b, c], _)| [*a, *b] == column && *c <= k + 1);
            for &(_, other) in near.filter(|(_, other)| *other > point) {
                found(point, other);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_pairs_within_the_distance_are_found_once() {
        let mut state = 1_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 40) as f64 / (1 << 24) as f64
        };
        let points: Vec<_> = (0..300)
            .map(|_| Vector3::new(10.0 * random(), 3.0 * random(), 20.0 * random() - 5.0))
            .collect();
        for reach in [0.3, 1.0, 100.0] {
            let mut found = Vec::new();
            for_near_pairs(&points, reach, |i, j| found.push((i, j)));
            let all = found.len();
            found.sort_unstable();
            found.dedup();
            assert_eq!(found.len(), all);
            let near = |&(i, j): &(usize, usize)| (points[i] - points[j]).norm() <= reach;
            let found: Vec<_> = found.into_iter().filter(near).collect();
            let pairs = (0..300).flat_map(|i| (i + 1..300).map(move |j| (i, j)));
            assert_eq!(found, pairs.filter(near).collect::<Vec<_>>());
        }
    }
}
