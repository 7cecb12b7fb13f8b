//! Insertion order of the points: biased randomised rounds, each along a Hilbert curve.

use mesh::Vec3;

/// Bits per coordinate on the curve; those of three coordinates fit into a `u64`.
const BITS: u32 = 21;

/// Point indices in insertion order.
///
/// Rounds of geometrically growing size (Amenta, Choi & Rote 2003), each sorted along a Hilbert
/// curve: the walk from the last tet to the next point is short for any order of the input.
pub(crate) fn insertion_order(points: &[Vec3]) -> Vec<u32> {
    let Some(first) = points.first() else {
        return Vec::new();
    };
    let (low, high) = points
        .iter()
        .fold((*first, *first), |(l, h), p| (l.inf(p), h.sup(p)));
    let extent = (high - low).max().max(f64::MIN_POSITIVE);
    let cells = f64::from((1u32 << BITS) - 1);
    let mut keyed: Vec<(u32, u64, u32)> = points
        .iter()
        .enumerate()
        .map(|(i, p)| {
            let cell = (p - low) * (cells / extent);
            let key = hilbert_key([cell.x as u32, cell.y as u32, cell.z as u32]);
            (round(i as u64), key, i as u32)
        })
        .collect();
    keyed.sort_unstable();
    keyed.into_iter().map(|(_, _, i)| i).collect()
}

/// Round of a point, drawn by hashing its index.
///
/// The last round has seven eighths of all points, the one before it seven eighths of the others,
/// and so on.
fn round(index: u64) -> u32 {
    // The finaliser of splitmix64 (Steele, Lea & Flood 2014).
    let mut z = index.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    BITS - (z.trailing_zeros() / 3).min(BITS)
}

/// Position of a cell along the Hilbert curve (Skilling 2004, "Programming the Hilbert curve").
fn hilbert_key(mut x: [u32; 3]) -> u64 {
    let top = 1u32 << (BITS - 1);
    let mut bit = top;
    while bit > 1 {
        let mask = bit - 1;
        for i in 0..3 {
            if x[i] & bit != 0 {
                x[0] ^= mask;
            } else {
                let t = (x[0] ^ x[i]) & mask;
                x[0] ^= t;
                x[i] ^= t;
            }
        }
        bit >>= 1;
    }
    x[1] ^= x[0];
    x[2] ^= x[1];
    let mut t = 0;
    bit = top;
    while bit > 1 {
        if x[2] & bit != 0 {
            t ^= bit - 1;
        }
        bit >>= 1;
    }
    let gray = x.map(|v| v ^ t);
    (0..BITS).rev().fold(0, |key, b| {
        gray.iter()
            .fold(key, |key, v| (key << 1) | u64::from((v >> b) & 1))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_on_the_curve_are_neighbours_in_space() {
        // The first 4096 steps of the curve fill a cube of side 16 and move by one cell at a time.
        let mut cells: Vec<([u32; 3], u64)> = Vec::new();
        for i in 0..16 {
            for j in 0..16 {
                for k in 0..16 {
                    cells.push(([i, j, k], hilbert_key([i, j, k])));
                }
            }
        }
        cells.sort_unstable_by_key(|c| c.1);
        for (step, pair) in cells.windows(2).enumerate() {
            assert_eq!(pair[0].1, step as u64);
            let distance: u32 = (0..3).map(|a| pair[0].0[a].abs_diff(pair[1].0[a])).sum();
            assert_eq!(distance, 1);
        }
    }

    #[test]
    fn every_point_is_inserted_once() {
        let points: Vec<Vec3> = (0..1000)
            .map(|i| {
                Vec3::new(
                    f64::from(i % 10),
                    f64::from(i / 10 % 10),
                    f64::from(i / 100),
                )
            })
            .collect();
        let mut order = insertion_order(&points);
        order.sort_unstable();
        assert!(order.into_iter().eq(0..1000));
    }
}
