//! Cells of points: cubes of one size on each level, of which only those with points exist.

use std::ops::Range;
use std::sync::LazyLock;

use nalgebra::Vector3;

use super::harmonics::{ORDER, degree_at};

/// Finest level at which points are sorted: cells of a millionth of the extent.
const FINEST: usize = 20;

/// Cells of one level.
pub(super) struct Level {
    /// Interleaved bits of the cells' positions, in ascending order.
    pub codes: Vec<u64>,
    /// Edge of the cells.
    pub edge: f64,
}

/// Points sorted by cells.
pub(super) struct Octree {
    lowest: Vector3<f64>,
    /// Indices of the points, cell by cell of the last level.
    pub order: Vec<usize>,
    /// Points of the cells of the last level, as places in `order`.
    pub leaves: Vec<Range<usize>>,
    /// The levels 0 (one cell) to the last one.
    pub levels: Vec<Level>,
}

/// Sums over pairs of points that take as long as a translation of an expansion: measured, of 5000
/// to 30 000 points within 10 % of the best one for each.
const PAIRS_PER_TRANSLATION: f64 = 2000.0;

/// Parts of the edge of the first cell that the points fill: edges of the last cells are then a
/// half to one of each other, in steps of about a seventh.
const FILLED: [f64; 4] = [1.0, 0.875, 0.75, 0.625];

impl Octree {
    /// The tree of points whose cells take the least work, as predicted from the numbers of pairs
    /// of points in neighbours and of translations; at least two levels below the first.
    pub fn new(points: &[Vector3<f64>]) -> Self {
        let none = Vector3::repeat(0.0);
        let lowest = points.iter().copied().reduce(|low, x| low.inf(&x));
        let highest = points.iter().copied().reduce(|high, x| high.sup(&x));
        let (lowest, highest) = (lowest.unwrap_or(none), highest.unwrap_or(none));
        // The largest coordinate is inside the last cell.
        let extent = match (highest - lowest).amax() * (1.0 + 1e-9) {
            0.0 => 1.0,
            extent => extent,
        };
        let [first, others @ ..] =
            FILLED.map(|filled| Self::within(points, lowest, extent / filled));
        let (_, tree) = others
            .into_iter()
            .fold(first, |best, found| match found.0 < best.0 {
                true => found,
                false => best,
            });
        tree
    }

    /// The best tree with a first cell of this edge at this corner, and its work.
    fn within(points: &[Vector3<f64>], lowest: Vector3<f64>, edge: f64) -> (f64, Self) {
        let cells = (1_u64 << FINEST) as f64;
        let code = |x: &Vector3<f64>| {
            let cell = (x - lowest) / edge * cells;
            interleaved([cell.x as u64, cell.y as u64, cell.z as u64])
        };
        let mut sorted: Vec<(u64, usize)> = points.iter().map(code).zip(0..).collect();
        sorted.sort_unstable();
        let at = |level: usize| {
            let mut codes: Vec<u64> = Vec::new();
            let mut starts = Vec::new();
            for (place, (code, _)) in sorted.iter().enumerate() {
                let code = code >> (3 * (FINEST - level));
                if codes.last() != Some(&code) {
                    codes.push(code);
                    starts.push(place);
                }
            }
            starts.push(sorted.len());
            let leaves: Vec<Range<usize>> = starts.windows(2).map(|w| w[0]..w[1]).collect();
            let edge = edge / (1_u64 << level) as f64;
            (Level { codes, edge }, leaves)
        };
        let mut levels = vec![at(0).0, at(1).0];
        let mut best = (f64::INFINITY, 2, Vec::new());
        let mut translations = 0.0;
        for depth in 2..=FINEST {
            let (level, leaves) = at(depth);
            let [pairs, more] = level.work(&levels[depth - 1], &leaves);
            translations += more * PAIRS_PER_TRANSLATION;
            let work = pairs + translations;
            levels.push(level);
            if work < best.0 {
                best = (work, depth, leaves);
            }
            let few = 4 * levels[depth].codes.len() > points.len();
            if few || translations > best.0 {
                break;
            }
        }
        levels.truncate(best.1 + 1);
        let tree = Self {
            lowest,
            order: sorted.into_iter().map(|(_, point)| point).collect(),
            leaves: best.2,
            levels,
        };
        (best.0, tree)
    }

    /// Centre of a cell.
    pub fn centre(&self, level: usize, cell: usize) -> Vector3<f64> {
        let level = &self.levels[level];
        let position = separated(level.codes[cell]).map(|c| c as f64 + 0.5);
        self.lowest + Vector3::from(position) * level.edge
    }
}

fn squared(offset: [i64; 3]) -> usize {
    offset.iter().map(|d| d * d).sum::<i64>() as usize
}

/// Work of translations by offsets with these squared lengths, relative to those of all degrees:
/// that of products of matrices.
static PARTS_OF_WORK: LazyLock<[f64; 28]> = LazyLock::new(|| {
    let mut parts = [0.0; 28];
    for offset in offsets(3).filter(|offset| offset.iter().any(|d| d.abs() > 1)) {
        let terms = ((degree_at(offset) + 1) as f64 / (ORDER + 1) as f64).powi(2);
        parts[squared(offset)] = terms.powi(2);
    }
    parts
});

impl Level {
    /// The cell and its neighbours, in ascending order of their offsets.
    pub fn neighbours(&self, cell: usize) -> impl Iterator<Item = usize> + '_ {
        let own = separated(self.codes[cell]);
        offsets(1).filter_map(move |offset| self.find(moved(own, offset)?))
    }

    /// Cells near enough for their parents to be neighbours of the parent, but no neighbours
    /// themselves, with their offsets.
    pub fn distant(&self, cell: usize) -> impl Iterator<Item = ([i64; 3], usize)> + '_ {
        let own = separated(self.codes[cell]);
        let is_far = |offset: &[i64; 3]| offset.iter().any(|d| d.abs() > 1);
        offsets(3).filter(is_far).filter_map(move |offset| {
            let other = moved(own, offset)?;
            let are_near = (0..3).all(|k| (other[k] >> 1).abs_diff(own[k] >> 1) <= 1);
            are_near.then_some(())?;
            Some((offset, self.find(other)?))
        })
    }

    /// Pairs of points in neighbours, and translations between others whose parents are neighbours,
    /// in those of all degrees.
    fn work(&self, parents: &Self, leaves: &[Range<usize>]) -> [f64; 2] {
        let positions: Vec<[i64; 3]> = (self.codes.iter())
            .map(|code| separated(*code).map(|c| c as i64))
            .collect();
        let first = |parent: &u64| self.codes.partition_point(|code| code >> 3 < *parent);
        let mut starts: Vec<usize> = parents.codes.iter().map(first).collect();
        starts.push(self.codes.len());
        let parts = |parent: usize| starts[parent]..starts[parent + 1];
        let parts_of_work = &*PARTS_OF_WORK;
        let (mut pairs, mut translations) = (0.0, 0.0);
        for parent in 0..parents.codes.len() {
            for other in parents.neighbours(parent).flat_map(parts) {
                for cell in parts(parent) {
                    let offset = [0, 1, 2].map(|k| positions[other][k] - positions[cell][k]);
                    if offset.iter().all(|d| d.abs() <= 1) {
                        pairs += (leaves[cell].len() * leaves[other].len()) as f64;
                    } else {
                        translations += parts_of_work[squared(offset)];
                    }
                }
            }
        }
        [pairs, translations]
    }

    fn find(&self, position: [u64; 3]) -> Option<usize> {
        self.codes.binary_search(&interleaved(position)).ok()
    }
}

/// Offsets of up to `most` cells along each axis.
fn offsets(most: i64) -> impl Iterator<Item = [i64; 3]> {
    let all = move || -most..=most;
    all().flat_map(move |i| all().flat_map(move |j| all().map(move |k| [i, j, k])))
}

/// A position moved by an offset; none outside the range of positions.
fn moved(position: [u64; 3], offset: [i64; 3]) -> Option<[u64; 3]> {
    let mut moved = position;
    for (own, by) in moved.iter_mut().zip(offset) {
        *own = own.checked_add_signed(by)?;
    }
    moved.iter().all(|c| c >> FINEST == 0).then_some(moved)
}

/// The bits of three numbers, one after the other.
fn interleaved(position: [u64; 3]) -> u64 {
    let [x, y, z] = position.map(|mut bits| {
        for (shift, mask) in SPREAD {
            bits = (bits | bits << shift) & mask;
        }
        bits
    });
    x | y << 1 | z << 2
}

/// The three numbers whose bits a code has.
fn separated(code: u64) -> [u64; 3] {
    [code, code >> 1, code >> 2].map(|code| {
        let (_, every_third) = SPREAD[SPREAD.len() - 1];
        let mut bits = code & every_third;
        for (step, (shift, _)) in SPREAD.iter().enumerate().rev() {
            let mask = match step {
                0 => (1 << FINEST) - 1,
                _ => SPREAD[step - 1].1,
            };
            bits = (bits | bits >> shift) & mask;
        }
        bits
    })
}

/// Shifts and masks that move each bit of a number to every third place.
const SPREAD: [(u32, u64); 5] = [
    (32, 0x001f_0000_0000_ffff),
    (16, 0x001f_0000_ff00_00ff),
    (8, 0x100f_00f0_0f00_f00f),
    (4, 0x10c3_0c30_c30c_30c3),
    (2, 0x1249_2492_4924_9249),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_have_the_bits_of_the_positions() {
        for position in [[0, 1, 2], [5, 0, 1_048_575], [777_777, 123_456, 1 << 19]] {
            assert_eq!(separated(interleaved(position)), position);
        }
        assert_eq!(interleaved([1, 0, 3]), 0b10_0101);
    }

    /// Two points of the last level are in neighbours, or in distant cells of one level exactly.
    #[test]
    fn each_pair_of_points_is_summed_once() {
        let points: Vec<Vector3<f64>> = (0..4000)
            .map(|k| {
                let k = f64::from(k);
                Vector3::new(
                    (k * 0.37).sin(),
                    (k * 0.73).cos() * 3.0,
                    (k * k * 0.1).sin(),
                )
            })
            .collect();
        let tree = Octree::new(&points);
        assert!(tree.levels.len() > 3, "{}", tree.levels.len());
        let mut summed = 0;
        for (cell, own) in tree.leaves.iter().enumerate() {
            let last = tree.levels.len() - 1;
            for near in tree.levels[last].neighbours(cell) {
                summed += own.len() * tree.leaves[near].len();
            }
        }
        for level in &tree.levels[2..] {
            let last = tree.levels.last().unwrap();
            let inside = |cell: usize| -> usize {
                let depth = (last.edge / level.edge).log2().round().abs() as u32;
                let all = last.codes.iter().zip(&tree.leaves);
                let own = all.filter(|(code, _)| **code >> (3 * depth) == level.codes[cell]);
                own.map(|(_, leaf)| leaf.len()).sum()
            };
            for cell in 0..level.codes.len() {
                let distant = level.distant(cell).map(|(_, other)| inside(other));
                summed += inside(cell) * distant.sum::<usize>();
            }
        }
        assert_eq!(summed, points.len() * points.len());
    }
}
