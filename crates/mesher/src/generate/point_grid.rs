//! Search for points near a point, with a spacing that varies.

use mesh::Vec3;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// Points sorted into cubic cells whose width is about the edge length wanted there.
///
/// The level of a cell is the binary logarithm of its width. Every point is stored on the level of
/// its own edge length and on the two next to it, so that a search looks at one level only: edge
/// lengths within one spacing differ by less than a factor of two, because they grow by less than
/// one per unit of length.
#[derive(Default)]
pub(super) struct PointGrid {
    heads: HashMap<(i32, [i32; 3]), u32, BuildHasherDefault<CellHasher>>,
    /// Points, each with the index of the next point in the same cell.
    entries: Vec<(Vec3, u32)>,
}

impl PointGrid {
    const NONE: u32 = u32::MAX;

    fn cell(p: Vec3, level: i32) -> [i32; 3] {
        let width = 2f64.powi(level);
        [p.x, p.y, p.z].map(|c| (c / width).floor() as i32)
    }

    /// Adds a point with the edge length `h`.
    pub fn insert(&mut self, p: Vec3, h: f64) {
        let level = h.log2().ceil() as i32;
        for level in level - 1..=level + 1 {
            let head = self
                .heads
                .entry((level, Self::cell(p, level)))
                .or_insert(Self::NONE);
            self.entries.push((p, *head));
            *head = self.entries.len() as u32 - 1;
        }
    }

    /// Whether a point is closer to `p` than `radius`, which is at most the edge length `h`.
    pub fn any_within(&self, p: Vec3, radius: f64, h: f64) -> bool {
        // Cells are at least `h` wide, so the ball meets at most eight of them.
        self.visit(p, radius, h, |q| (p - q).norm_squared() < radius * radius)
    }

    /// Collects points around `p`, most of those closer than `radius`.
    ///
    /// Points with less than half or more than twice the edge length `h` may be missing.
    pub fn some_around(&self, p: Vec3, radius: f64, h: f64, found: &mut Vec<Vec3>) {
        found.clear();
        self.visit(p, radius, h, |q| {
            found.push(q);
            false
        });
    }

    /// Visits the points in the cells of level `h` around `p` until `stop`; returns whether it did.
    fn visit(&self, p: Vec3, radius: f64, h: f64, mut stop: impl FnMut(Vec3) -> bool) -> bool {
        let level = h.log2().ceil() as i32;
        let low = Self::cell(p - Vec3::repeat(radius), level);
        let high = Self::cell(p + Vec3::repeat(radius), level);
        for i in low[0]..=high[0] {
            for j in low[1]..=high[1] {
                for k in low[2]..=high[2] {
                    let head = self.heads.get(&(level, [i, j, k]));
                    let mut entry = head.copied().unwrap_or(Self::NONE);
                    while entry != Self::NONE {
                        let (q, next) = self.entries[entry as usize];
                        if stop(q) {
                            return true;
                        }
                        entry = next;
                    }
                }
            }
        }
        false
    }
}

/// Multiplicative hash of cell numbers (Fibonacci hashing, Knuth volume 3).
///
/// Cell numbers are not hostile input, so a faster hash than that of the standard library is safe.
#[derive(Default)]
struct CellHasher(u64);

impl Hasher for CellHasher {
    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u32(u32::from(byte));
        }
    }

    fn write_i32(&mut self, i: i32) {
        self.write_u32(i.cast_unsigned());
    }

    fn write_u32(&mut self, i: u32) {
        self.0 = (self.0.rotate_left(23) ^ u64::from(i)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }

    fn finish(&self) -> u64 {
        // The map uses the low bits, but the high bits of the product are the random ones.
        self.0 ^ (self.0 >> 32)
    }
}
