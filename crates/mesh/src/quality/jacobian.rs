//! The Jacobian determinant of a 10-node tet: exact Bernstein form, guaranteed bounds, volume.
//!
//! The geometry map `x(l) = sum_ij l_i l_j P_ij` (barycentric `l`, control points `P_ii = x_i`,
//! `P_ij = 2 m_ij - (x_i + x_j)/2`) has linear derivatives, so `det J` is a cubic. Its 20 Bernstein coefficients
//! bound it (convex hull) and are values of it at the vertices. Johnen, Remacle & Geuzaine, J. Comput. Phys. 233 (2013).

use nalgebra::Matrix3;

use crate::{TET_EDGES, Vec3};

/// Number of cubic Bernstein polynomials on a tet.
const N: usize = 20;

/// Exponents `(a_0, a_1, a_2, a_3)` of the cubic Bernstein polynomials; the four vertices come first.
const EXPONENTS: [[u8; 4]; N] = exponents();

/// Inverse of [`EXPONENTS`]: index of the polynomial from `a_1, a_2, a_3`.
const INDEX: [[[u8; 4]; 4]; 4] = index();

/// How sharp the lower bound is made, in units of six times the straight volume.
///
/// One per cent tells a Jacobian of 0.2 (where remeshing is due) from one of 0.19; nothing is decided more finely.
const SHARPNESS: f64 = 0.01;

/// Pieces a cell is cut into at most before the bound is taken as it stands.
///
/// The gap between bound and value falls with the square of a piece's size, and the pieces around one minimum are
/// few: only cells that are hopeless anyhow need this many. What is returned is a bound all the same.
const MAX_PIECES: usize = 4096;

const fn exponents() -> [[u8; 4]; N] {
    let mut all = [[0; 4]; N];
    let mut v = 0;
    while v < 4 {
        all[v][v] = 3;
        v += 1;
    }
    let mut n = 4;
    let mut code = 0;
    while code < 64 {
        let (b, c, d) = (code / 16, code / 4 % 4, code % 4);
        let at_vertex = b == 3 || c == 3 || d == 3 || b + c + d == 0;
        if b + c + d <= 3 && !at_vertex {
            all[n] = [3 - b - c - d, b, c, d];
            n += 1;
        }
        code += 1;
    }
    all
}

const fn index() -> [[[u8; 4]; 4]; 4] {
    let mut all = [[[0; 4]; 4]; 4];
    let mut n = 0;
    while n < N {
        let [_, b, c, d] = EXPONENTS[n];
        all[b as usize][c as usize][d as usize] = n as u8;
        n += 1;
    }
    all
}

/// The 20 Bernstein coefficients of `det J` over a 10-node tet, the values at the four vertices first.
///
/// `det J` is taken with respect to reference coordinates (vertices 0, e1, e2, e3): six times the volume when straight.
pub(crate) fn bernstein_coefficients(nodes: &[Vec3; 10]) -> [f64; N] {
    let mut control = [[Vec3::zeros(); 4]; 4];
    for i in 0..4 {
        control[i][i] = nodes[i];
    }
    for (k, [i, j]) in TET_EDGES.into_iter().enumerate() {
        let p = 2.0 * nodes[4 + k] - 0.5 * (nodes[i] + nodes[j]);
        control[i][j] = p;
        control[j][i] = p;
    }
    // dx/dxi_k = sum_j l_j 2 (P_kj - P_0j)
    let slope = |k: usize, j: usize| 2.0 * (control[k][j] - control[0][j]);
    let mut sum = [0.0; N];
    for i in 0..4 {
        for j in 0..4 {
            let cross = slope(1, i).cross(&slope(2, j));
            for k in 0..4 {
                let mut exponent = [0; 4];
                for v in [i, j, k] {
                    exponent[v] += 1;
                }
                let [_, b, c, d] = exponent;
                sum[INDEX[b][c][d] as usize] += cross.dot(&slope(3, k));
            }
        }
    }
    // The number of arrangements of a monomial: 3! / (a_0! a_1! a_2! a_3!), where a! = 1, 1, 2, 6.
    for (coefficient, exponent) in sum.iter_mut().zip(EXPONENTS) {
        let repeats: f64 = exponent
            .iter()
            .map(|&a| [1.0, 1.0, 2.0, 6.0][a as usize])
            .product();
        *coefficient *= repeats / 6.0;
    }
    sum
}

/// The volume of a 10-node tet, exactly: the mean of the Bernstein coefficients over six.
pub(crate) fn curved_volume(nodes: &[Vec3; 10]) -> f64 {
    bernstein_coefficients(nodes).iter().sum::<f64>() / (6.0 * N as f64)
}

/// `det(x1 - x0, x2 - x0, x3 - x0)`: six times the volume of a straight tet.
pub(crate) fn straight_jacobian([a, b, c, d]: [Vec3; 4]) -> f64 {
    Matrix3::from_columns(&[b - a, c - a, d - a]).determinant()
}

/// A guaranteed lower bound of `det J` over a 10-node tet, divided by `|6 V|` of its straight tet.
///
/// At most 1 % of `6 V` below the true minimum (unless the cell is past repair), because pieces whose bound is
/// not sharp are bisected (de Casteljau). Positive: the map is locally one-to-one everywhere in the cell.
/// A straight cell has 1; a cell with no straight volume or with a NaN has minus infinity.
pub fn scaled_jacobian_bound(nodes: &[Vec3; 10]) -> f64 {
    let scale = straight_jacobian([nodes[0], nodes[1], nodes[2], nodes[3]]).abs();
    let net = bernstein_coefficients(nodes);
    // `min` passes over NaN, a sum does not.
    if scale > 0.0 && net.iter().sum::<f64>().is_finite() {
        lower_bound(net, SHARPNESS * scale) / scale
    } else {
        f64::NEG_INFINITY
    }
}

/// A lower bound of the cubic, less than `sharpness` below its minimum.
fn lower_bound(net: [f64; N], sharpness: f64) -> f64 {
    let at_vertices = |net: &[f64; N]| net[..4].iter().copied().fold(f64::INFINITY, f64::min);
    let bound = |net: &[f64; N]| net.iter().copied().fold(f64::INFINITY, f64::min);
    // The smallest value seen bounds the minimum from above; pieces that cannot undercut it by much are done.
    let mut seen = at_vertices(&net);
    let mut done = f64::INFINITY;
    let mut pieces = vec![(net, 0)];
    let mut made = 1;
    while let Some((net, depth)) = pieces.pop() {
        let low = bound(&net);
        if low >= seen - sharpness || made >= MAX_PIECES {
            done = done.min(low);
            continue;
        }
        // Six bisections, one an edge, shrink a tet in all directions.
        let [p, q] = TET_EDGES[depth % 6];
        for (from, to) in [(p, q), (q, p)] {
            let half = halve(&net, from, to);
            seen = seen.min(at_vertices(&half));
            pieces.push((half, depth + 1));
            made += 1;
        }
    }
    done
}

/// The coefficients over the half of a tet that keeps vertex `from`, where the midpoint of edge `from`-`to` replaces `to`.
fn halve(net: &[f64; N], from: usize, to: usize) -> [f64; N] {
    // Replacing l_to by (l_from + l_to)/2 in each of the `n` arguments `to` of the blossom: binomial weights.
    const BINOMIAL: [[f64; 4]; 4] = [
        [1.0, 0.0, 0.0, 0.0],
        [0.5, 0.5, 0.0, 0.0],
        [0.25, 0.5, 0.25, 0.0],
        [0.125, 0.375, 0.375, 0.125],
    ];
    let mut half = [0.0; N];
    for (value, exponent) in half.iter_mut().zip(EXPONENTS) {
        let n = exponent[to] as usize;
        for moved in 0..=n {
            let mut source = exponent.map(usize::from);
            source[to] -= moved;
            source[from] += moved;
            let [_, b, c, d] = source;
            *value += BINOMIAL[n][moved] * net[INDEX[b][c][d] as usize];
        }
    }
    half
}

#[cfg(test)]
mod tests {
    use super::*;

    fn straight(corners: [Vec3; 4]) -> [Vec3; 10] {
        let mut nodes = [Vec3::zeros(); 10];
        nodes[..4].copy_from_slice(&corners);
        for (k, [i, j]) in TET_EDGES.into_iter().enumerate() {
            nodes[4 + k] = 0.5 * (corners[i] + corners[j]);
        }
        nodes
    }

    fn reference() -> [Vec3; 10] {
        straight([Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()])
    }

    /// `det J` at barycentric `l` from the shape functions of the 10-node tet, independent of the Bernstein form.
    fn jacobian_at(nodes: &[Vec3; 10], l: [f64; 4]) -> f64 {
        let mut slopes = [Vec3::zeros(); 4];
        for i in 0..4 {
            slopes[i] += (4.0 * l[i] - 1.0) * nodes[i];
        }
        for (k, [i, j]) in TET_EDGES.into_iter().enumerate() {
            slopes[i] += 4.0 * l[j] * nodes[4 + k];
            slopes[j] += 4.0 * l[i] * nodes[4 + k];
        }
        let columns = [1, 2, 3].map(|k| slopes[k] - slopes[0]);
        Matrix3::from_columns(&columns).determinant()
    }

    /// A cell with every midside node pulled aside by up to `size`, different for each.
    fn bent(size: f64) -> [Vec3; 10] {
        let mut nodes = reference();
        for (k, node) in nodes.iter_mut().enumerate().skip(4) {
            let t = k as f64;
            *node += size * Vec3::new((2.1 * t).sin(), (3.7 * t).cos(), (5.3 * t).sin());
        }
        nodes
    }

    fn samples() -> impl Iterator<Item = [f64; 4]> {
        let n = 24;
        (0..=n).flat_map(move |i| {
            (0..=n - i).flat_map(move |j| {
                (0..=n - i - j)
                    .map(move |k| [n - i - j - k, i, j, k].map(|c| f64::from(c) / f64::from(n)))
            })
        })
    }

    #[test]
    fn straight_cell_has_scaled_jacobian_one_and_its_volume() {
        let cell = reference();
        assert!((scaled_jacobian_bound(&cell) - 1.0).abs() < 1e-14);
        assert!((curved_volume(&cell) - 1.0 / 6.0).abs() < 1e-15);
    }

    #[test]
    fn bernstein_form_reproduces_the_determinant() {
        let cell = bent(0.2);
        let net = bernstein_coefficients(&cell);
        for l in samples() {
            let value: f64 = (0..N)
                .map(|n| {
                    let weight: f64 = (0..4)
                        .map(|v| {
                            l[v].powi(i32::from(EXPONENTS[n][v]))
                                / [1.0, 1.0, 2.0, 6.0][EXPONENTS[n][v] as usize]
                        })
                        .product();
                    6.0 * weight * net[n]
                })
                .sum();
            assert!((value - jacobian_at(&cell, l)).abs() < 1e-13);
        }
    }

    #[test]
    fn bound_is_below_the_minimum_and_within_its_sharpness() {
        for size in [0.02, 0.05, 0.1, 0.15, 0.3] {
            let cell = bent(size);
            let sampled = samples()
                .map(|l| jacobian_at(&cell, l))
                .fold(f64::INFINITY, f64::min);
            let bound = scaled_jacobian_bound(&cell);
            // Both are rounded: 1e-13 is some hundred roundings of numbers of size one.
            assert!(bound <= sampled + 1e-13, "{bound} {sampled}");
            // |grad det J| < 100 for these cells, samples are 1/24 apart, and a minimum is flat inside or on a vertex.
            let minimum_at_least = sampled - 0.5 * 400.0 * size * (1.0 / 24.0_f64).powi(2);
            assert!(bound >= minimum_at_least - SHARPNESS, "{bound} {sampled}");
        }
    }

    #[test]
    fn valid_cell_with_a_negative_coefficient_is_not_refused() {
        // (u, v, w) -> (u - c v^2, v - c u^2, w) has det J = 1 - 4 c^2 u v: smallest 1 - c^2 at u = v = 1/2, but
        // 1 - 4 c^2 / 3 among the coefficients. The straight tet has det J = 1 - c^2 too.
        let c = 0.8_f64.sqrt();
        let cell = reference().map(|p| Vec3::new(p.x - c * p.y * p.y, p.y - c * p.x * p.x, p.z));
        let smallest = bernstein_coefficients(&cell)
            .into_iter()
            .fold(1.0, f64::min);
        assert!((smallest - (1.0 - 4.0 * 0.8 / 3.0)).abs() < 1e-14);
        let bound = scaled_jacobian_bound(&cell);
        assert!(bound > 1.0 - SHARPNESS && bound < 1.0 + 1e-14, "{bound}");
    }

    #[test]
    fn folded_cell_is_refused() {
        let mut cell = reference();
        // The midside node of edge 01 beyond vertex 1: J at vertex 1 along the edge is 4 (x1 - m) - (x1 - x0) < 0.
        cell[4] = Vec3::new(1.1, 0.0, 0.0);
        assert!(scaled_jacobian_bound(&cell) < 0.0);
    }

    #[test]
    fn hopeless_cells_give_minus_infinity_or_a_negative_number() {
        let flat = straight([Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::x() + Vec3::y()]);
        assert_eq!(scaled_jacobian_bound(&flat), f64::NEG_INFINITY);
        let mut nan = reference();
        nan[7].x = f64::NAN;
        assert_eq!(scaled_jacobian_bound(&nan), f64::NEG_INFINITY);
        let mirrored = straight([Vec3::zeros(), Vec3::y(), Vec3::x(), Vec3::z()]);
        assert!(scaled_jacobian_bound(&mirrored) < 0.0);
    }
}
