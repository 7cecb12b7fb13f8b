//! Structured test meshes, random fields and a small Stokes solver.

pub mod meshes;
pub mod stokes;

use mesh::Vec3;

/// Pseudorandom number in -1..1 that depends on `seed` and `index` alone (splitmix64).
pub fn noise(seed: u64, index: usize) -> f64 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15_u64.wrapping_mul(index as u64 + 1));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) as f64 / 2f64.powi(63) - 1.0
}

/// Array of pseudorandom numbers.
pub fn noise_vector(seed: u64, len: usize) -> Vec<f64> {
    (0..len).map(|i| noise(seed, i)).collect()
}

/// Nodal vectors with pseudorandom components.
pub fn noise_field(seed: u64, n_nodes: usize) -> Vec<Vec3> {
    nodal(&noise_vector(seed, 3 * n_nodes))
}

/// Dot product of two arrays.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Interleaved components of nodal vectors.
pub fn interleaved(field: &[Vec3]) -> Vec<f64> {
    field.iter().flat_map(|&v| <[f64; 3]>::from(v)).collect()
}

/// Nodal vectors from interleaved components.
pub fn nodal(values: &[f64]) -> Vec<Vec3> {
    let (vectors, _) = values.as_chunks::<3>();
    vectors.iter().map(|&v| v.into()).collect()
}
