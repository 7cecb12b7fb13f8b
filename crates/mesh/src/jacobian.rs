//! The Jacobian determinant of a 10-node tet: exact Bernstein form, guaranteed bounds, volume.
//!
//! The geometry map is `x(l) = sum_ij l_i l_j P_ij` with barycentric coordinates `l` and control
//! points `P_ii = x_i`, `P_ij = 2 m_ij - (x_i + x_j)/2`. Its derivatives are linear, so `det J` is
//! a cubic. The 20 Bernstein coefficients of this cubic bound it (convex-hull property), and those
//! of the vertices are its values there (Johnen, Remacle & Geuzaine, J. Comput. Phys. 233, 2013).

use nalgebra::Matrix3;

use crate::{TET_EDGES, Vec3};

/// Number of cubic Bernstein polynomials on a tet.
const N: usize = 20;

/// Exponents `(a_0, a_1, a_2, a_3)` of the cubic Bernstein polynomials, those of the vertices
/// first.
const EXPONENTS: [[u8; 4]; N] = exponents();

/// Inverse of [`EXPONENTS`]: index of the polynomial with given `a_1, a_2, a_3`.
const INDEX: [[[u8; 4]; 4]; 4] = index();

/// Accuracy of the lower bound, in units of six times the straight volume.
///
/// One per cent distinguishes a scaled Jacobian of 0.2 (the remeshing threshold) from 0.19; no
/// decision needs more.
const SHARPNESS: f64 = 0.01;

/// Largest number of pieces into which a cell is divided to sharpen its bound.
///
/// The gap between bound and value falls with the square of a piece's size, and only the few pieces
/// around the minimum are divided: only badly inverted cells reach this limit. The result is a
/// lower bound in any case.
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

/// The 20 Bernstein coefficients of `det J` over a 10-node tet.
///
/// The first four are the values of `det J` at the vertices.
///
/// `det J` is the determinant with respect to the reference coordinates (vertices 0, e1, e2, e3);
/// in a straight tet it is six times the volume.
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
    // Divide by the multinomial coefficient 3! / (a_0! a_1! a_2! a_3!), where a! = 1, 1, 2, 6.
    for (coefficient, exponent) in sum.iter_mut().zip(EXPONENTS) {
        let repeats: f64 = exponent
            .iter()
            .map(|&a| [1.0, 1.0, 2.0, 6.0][a as usize])
            .product();
        *coefficient *= repeats / 6.0;
    }
    sum
}

/// Exact volume of a 10-node tet: one sixth of the mean of the Bernstein coefficients.
pub(crate) fn curved_volume(nodes: &[Vec3; 10]) -> f64 {
    bernstein_coefficients(nodes).iter().sum::<f64>() / (6.0 * N as f64)
}

/// Six times the signed volume of a straight tet: `det(x1 - x0, x2 - x0, x3 - x0)`.
pub(crate) fn straight_jacobian([a, b, c, d]: [Vec3; 4]) -> f64 {
    Matrix3::from_columns(&[b - a, c - a, d - a]).determinant()
}

/// Scaled Jacobian of a straight tet: 1, 0 if it is flat, -1 if it is inverted.
///
/// Minus infinity, the worst value, for coordinates that are NaN.
pub(crate) fn scaled_jacobian_of_straight_tet(corners: [Vec3; 4]) -> f64 {
    let jacobian = straight_jacobian(corners);
    if jacobian > 0.0 {
        1.0
    } else if jacobian < 0.0 {
        -1.0
    } else if jacobian == 0.0 {
        0.0
    } else {
        f64::NEG_INFINITY
    }
}

/// Guaranteed lower bound of `det J` over a 10-node tet, divided by `|6 V|` of its straight tet.
///
/// Pieces whose bound is not sharp enough are bisected (de Casteljau) until the bound is at most
/// 1 % of `6 V` below the true minimum, except in badly inverted cells. If the bound is positive,
/// the map is locally one-to-one everywhere in the cell. The value is 1 for a straight cell, and
/// minus infinity for a cell with a NaN or whose straight tet has no volume.
pub fn scaled_jacobian_bound(nodes: &[Vec3; 10]) -> f64 {
    let scale = straight_jacobian([nodes[0], nodes[1], nodes[2], nodes[3]]).abs();
    let net = bernstein_coefficients(nodes);
    // `f64::min` ignores NaN, a sum does not.
    if scale > 0.0 && net.iter().sum::<f64>().is_finite() {
        lower_bound(net, SHARPNESS * scale) / scale
    } else {
        f64::NEG_INFINITY
    }
}

/// Lower bound of the cubic with coefficients `net`, less than `sharpness` below its minimum.
fn lower_bound(net: [f64; N], sharpness: f64) -> f64 {
    let at_vertices = |net: &[f64; N]| net[..4].iter().copied().fold(f64::INFINITY, f64::min);
    let bound = |net: &[f64; N]| net.iter().copied().fold(f64::INFINITY, f64::min);
    // The smallest value seen is an upper bound of the minimum. A piece is finished when its lower
    // bound is within `sharpness` of that.
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
        // Six bisections, one per edge, shrink a tet in all directions.
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

/// Coefficients over one half of a tet: vertex `to` moves to the midpoint of the edge `from`-`to`.
fn halve(net: &[f64; N], from: usize, to: usize) -> [f64; N] {
    // In the blossom each of the `n` arguments `to` becomes the mean of `from` and `to`, which
    // gives binomial weights.
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

    /// `det J` at barycentric `l` by the shape functions of the 10-node tet, without the Bernstein
    /// form.
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

    /// A cell whose midside nodes are displaced by up to `size`, each differently.
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
            // Both are rounded: 1e-13 allows for some hundred roundings of numbers of size one.
            assert!(bound <= sampled + 1e-13, "{bound} {sampled}");
            // The second derivatives of det J are below 400 `size` in these cells and the samples
            // are 1/24 apart; a minimum is either stationary or at a vertex, which is sampled.
            let minimum_at_least = sampled - 0.5 * 400.0 * size * (1.0 / 24.0_f64).powi(2);
            assert!(bound >= minimum_at_least - SHARPNESS, "{bound} {sampled}");
        }
    }

    #[test]
    fn valid_cell_with_a_negative_coefficient_is_not_refused() {
        // (u, v, w) -> (u - c v^2, v - c u^2, w) has det J = 1 - 4 c^2 u v. Its minimum is 1 - c^2,
        // at u = v = 1/2, but its smallest coefficient is 1 - 4 c^2 / 3. The straight tet has det J
        // = 1 - c^2 too.
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
        // The midside node m of edge 01 lies beyond vertex 1: the tangent of the edge at vertex 1,
        // 4 (x1 - m) - (x1 - x0), points backwards.
        cell[4] = Vec3::new(1.1, 0.0, 0.0);
        assert!(scaled_jacobian_bound(&cell) < 0.0);
    }

    #[test]
    fn flat_cells_and_nan_give_minus_infinity_and_inverted_cells_a_negative_bound() {
        let flat = straight([Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::x() + Vec3::y()]);
        assert_eq!(scaled_jacobian_bound(&flat), f64::NEG_INFINITY);
        let mut nan = reference();
        nan[7].x = f64::NAN;
        assert_eq!(scaled_jacobian_bound(&nan), f64::NEG_INFINITY);
        let inverted = straight([Vec3::zeros(), Vec3::y(), Vec3::x(), Vec3::z()]);
        assert!(scaled_jacobian_bound(&inverted) < 0.0);
    }
}
