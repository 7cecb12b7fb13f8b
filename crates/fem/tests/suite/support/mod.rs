//! Structured test meshes and a small Stokes solver, so that the tests of this crate need no other.
#![allow(dead_code, reason = "each test binary uses a part")]

pub mod meshes;
pub mod stokes;

/// A number in -1..1 that depends on `seed` and `index` alone (splitmix64).
pub fn noise(seed: u64, index: usize) -> f64 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15_u64.wrapping_mul(index as u64 + 1));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) as f64 / 2f64.powi(63) - 1.0
}

/// A vector of such numbers.
pub fn noise_vector(seed: u64, len: usize) -> Vec<f64> {
    (0..len).map(|i| noise(seed, i)).collect()
}

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
