//! The Taylor-Hood basis on the reference tetrahedron: quadratic velocities, linear pressures, and
//! their integrals for affine cells.
//!
//! The node order is that of the mesh: four vertices, then the midside nodes of [`TET_EDGES`]. With
//! the barycentric coordinates `l` the quadratic functions are `N_i = l_i (2 l_i - 1)` at vertices
//! and `N_ij = 4 l_i l_j` at midside nodes; the linear (pressure) functions are `ψ_i = l_i`.
//! Integrals use `∫ l_a^p l_b^q ... / |T| = 3! p! q! ... / (3 + p + q + ...)!`.

use mesh::{TET_EDGES, Vec3};

/// Values of the ten quadratic shape functions at barycentric coordinates `l`.
pub(crate) fn shape_functions(l: [f64; 4]) -> [f64; 10] {
    let mut n = [0.0; 10];
    for i in 0..4 {
        n[i] = l[i] * (2.0 * l[i] - 1.0);
    }
    for (k, [i, j]) in TET_EDGES.into_iter().enumerate() {
        n[4 + k] = 4.0 * l[i] * l[j];
    }
    n
}

/// Gradients of the ten shape functions in the reference coordinates `ξ_k = l_{k+1}`.
///
/// The first barycentric coordinate is `l_0 = 1 - sum_k ξ_k`.
pub(crate) fn shape_gradients(l: [f64; 4]) -> [Vec3; 10] {
    let by_reference = |d: [f64; 4]| Vec3::new(d[1] - d[0], d[2] - d[0], d[3] - d[0]);
    let mut gradients = [Vec3::zeros(); 10];
    for i in 0..4 {
        let mut d = [0.0; 4];
        d[i] = 4.0 * l[i] - 1.0;
        gradients[i] = by_reference(d);
    }
    for (k, [i, j]) in TET_EDGES.into_iter().enumerate() {
        let mut d = [0.0; 4];
        d[i] = 4.0 * l[j];
        d[j] = 4.0 * l[i];
        gradients[4 + k] = by_reference(d);
    }
    gradients
}

/// Gradients of the four barycentric coordinates in reference coordinates.
pub(crate) fn vertex_gradients() -> [Vec3; 4] {
    [-Vec3::repeat(1.0), Vec3::x(), Vec3::y(), Vec3::z()]
}

/// Table `S` of the stiffness matrix of an affine cell, `K_ij = sum_e S[i][e][j] g_e`.
///
/// `g_e = g_ab = |T| ∇l_a · ∇l_b` is the weight of the edge `e = (a, b)` of [`TET_EDGES`]. With
/// `C_ijab = ∫ ∂_a N_i ∂_b N_j / |T|` the stiffness is `K_ij = sum_ab C_ijab g_ab`. The barycentric
/// gradients sum to zero, so `g_aa = -sum_(b≠a) g_ab`, six weights remain, and
/// `S = C_ijab + C_ijba - C_ijaa - C_ijbb`.
pub(crate) const STIFFNESS_BY_EDGE: [[[f64; 10]; 6]; 10] = stiffness_by_edge();

/// Mass matrix of an affine cell of unit volume, `∫ N_i N_j / |T|`.
pub(crate) const QUADRATIC_MASS: [[f64; 10]; 10] = quadratic_mass();

/// `∫ l_m l_n / |T|`.
pub(crate) const fn linear_mass(m: usize, n: usize) -> f64 {
    if m == n { 2.0 / 20.0 } else { 1.0 / 20.0 }
}

/// Coefficients `D` in `∂N_i/∂l_a = sum_m D[i][a][m] l_m`.
///
/// The constant -1 in the derivative of a vertex function is written as `-sum_m l_m`.
const fn derivative_coefficients() -> [[[f64; 4]; 4]; 10] {
    let mut d = [[[0.0; 4]; 4]; 10];
    let mut i = 0;
    while i < 4 {
        d[i][i] = [-1.0; 4];
        d[i][i][i] = 3.0;
        i += 1;
    }
    let mut k = 0;
    while k < 6 {
        let [a, b] = TET_EDGES[k];
        d[4 + k][a][b] = 4.0;
        d[4 + k][b][a] = 4.0;
        k += 1;
    }
    d
}

/// `∫ f g / |T|` of two linear functions given by their vertex values.
const fn linear_product(f: [f64; 4], g: [f64; 4]) -> f64 {
    let mut sum = 0.0;
    let mut m = 0;
    while m < 4 {
        let mut n = 0;
        while n < 4 {
            sum += f[m] * g[n] * linear_mass(m, n);
            n += 1;
        }
        m += 1;
    }
    sum
}

const fn stiffness_by_edge() -> [[[f64; 10]; 6]; 10] {
    let d = derivative_coefficients();
    let mut s = [[[0.0; 10]; 6]; 10];
    let mut i = 0;
    while i < 10 {
        let mut e = 0;
        while e < 6 {
            let [a, b] = TET_EDGES[e];
            let mut j = 0;
            while j < 10 {
                s[i][e][j] = linear_product(d[i][a], d[j][b]) + linear_product(d[i][b], d[j][a])
                    - linear_product(d[i][a], d[j][a])
                    - linear_product(d[i][b], d[j][b]);
                j += 1;
            }
            e += 1;
        }
        i += 1;
    }
    s
}

/// Vertices between which a node lies; a vertex counts as lying between itself and itself.
const fn parents(node: usize) -> [usize; 2] {
    if node < 4 {
        [node, node]
    } else {
        TET_EDGES[node - 4]
    }
}

const fn quadratic_mass() -> [[f64; 10]; 10] {
    let mut m = [[0.0; 10]; 10];
    let mut i = 0;
    while i < 10 {
        let mut j = 0;
        while j < 10 {
            let ([a, b], [c, d]) = (parents(i), parents(j));
            let shares_vertex = a == c || a == d || b == c || b == d;
            // 420 = 7! / (3! 2) is the common denominator of the integrals of these quartic
            // products.
            m[i][j] = match (i < 4, j < 4) {
                (true, true) if i == j => 6.0,
                (true, true) => 1.0,
                (false, false) if i == j => 32.0,
                (false, false) if shares_vertex => 16.0,
                (false, false) => 8.0,
                _ if shares_vertex => -4.0,
                _ => -6.0,
            } / 420.0;
            j += 1;
        }
        i += 1;
    }
    m
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::degree_6;

    const INNER_POINT: [f64; 4] = [0.15, 0.37, 0.28, 0.2];

    /// Barycentric coordinates of node `i`.
    fn node(i: usize) -> [f64; 4] {
        let mut l = [0.0; 4];
        for v in parents(i) {
            l[v] += 0.5;
        }
        l
    }

    #[test]
    fn shape_functions_are_one_at_their_node_and_zero_at_the_others() {
        for i in 0..10 {
            let n = shape_functions(node(i));
            for j in 0..10 {
                assert_eq!(n[j], if i == j { 1.0 } else { 0.0 });
            }
        }
    }

    #[test]
    fn shape_functions_sum_to_one_and_their_gradients_to_zero() {
        let sum: f64 = shape_functions(INNER_POINT).iter().sum();
        assert!((sum - 1.0).abs() < 1e-15);
        let sum: Vec3 = shape_gradients(INNER_POINT).iter().sum();
        assert!(sum.norm() < 1e-15);
    }

    #[test]
    fn shape_gradients_are_the_derivatives() {
        // Central differences of quadratics are exact up to rounding errors of size eps / step.
        let step = 1e-3;
        let gradients = shape_gradients(INNER_POINT);
        for k in 0..3 {
            let shifted = |sign: f64| {
                let mut l = INNER_POINT;
                l[k + 1] += sign * step;
                l[0] -= sign * step;
                shape_functions(l)
            };
            let (ahead, behind) = (shifted(1.0), shifted(-1.0));
            for i in 0..10 {
                let difference = (ahead[i] - behind[i]) / (2.0 * step);
                assert!((difference - gradients[i][k]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn linear_functions_equal_their_quadratic_interpolants() {
        // ψ_a = N_a + half the sum of the midside functions of the edges at a.
        let n = shape_functions(INNER_POINT);
        for a in 0..4 {
            let mut sum = n[a];
            for (k, edge) in TET_EDGES.iter().enumerate() {
                if edge.contains(&a) {
                    sum += 0.5 * n[4 + k];
                }
            }
            assert!((sum - INNER_POINT[a]).abs() < 1e-15);
        }
    }

    #[test]
    fn tables_equal_quadrature() {
        // On the reference tetrahedron |T| = 1/6, and ∇l is `vertex_gradients`.
        let gradients = vertex_gradients();
        let weights = TET_EDGES.map(|[a, b]| gradients[a].dot(&gradients[b]) / 6.0);
        for i in 0..10 {
            for j in 0..10 {
                let stiffness: f64 = (0..6)
                    .map(|e| STIFFNESS_BY_EDGE[i][e][j] * weights[e])
                    .sum();
                let (mut expected, mut mass) = (0.0, 0.0);
                for q in degree_6() {
                    expected += q.weight * q.gradients[i].dot(&q.gradients[j]);
                    mass += q.weight * q.shape[i] * q.shape[j];
                }
                assert!((stiffness - expected).abs() < 1e-15);
                assert!((QUADRATIC_MASS[i][j] / 6.0 - mass).abs() < 1e-15);
            }
        }
    }
}
