//! Lagrange elements of arbitrary order on the triangle.

use nalgebra::DMatrix;

use crate::AxisymmetricError;
use crate::quadrature::{RulePoint, lobatto};

/// The nodal basis of degree `order`.
///
/// Nodes are numbered: corners, then edges in their direction, then the interior.
pub(crate) struct Lagrange {
    order: usize,
    /// Barycentric coordinates of the nodes.
    pub nodes: Vec<[f64; 3]>,
    /// Exponents of the Bernstein polynomials, one for each node.
    exponents: Vec<[usize; 3]>,
    /// Bernstein coefficients of the nodal basis functions, one function per row.
    coefficients: DMatrix<f64>,
}

/// Basis functions at the points of a rule: one function per row, one point per column.
pub(crate) struct Table {
    pub values: DMatrix<f64>,
    /// Derivatives with respect to the second and the third barycentric coordinate.
    ///
    /// The first coordinate is eliminated by `λ_1 = 1 - λ_2 - λ_3`.
    pub gradients: [DMatrix<f64>; 2],
}

impl Lagrange {
    /// The basis whose nodes have the triangle's symmetries and are Lobatto points on its edges
    /// (Blyth & Pozrikidis, IMA J. Appl. Math. 71, 2006).
    ///
    /// # Errors
    /// [`AxisymmetricError::NoNodalBasis`] if the matrix of nodal values is singular, which does
    /// not happen for orders below twenty.
    pub fn new(order: usize) -> Result<Self, AxisymmetricError> {
        let v = lobatto(order);
        // barycentric coordinates of the node with exponents i, j, k
        let node = |i: usize, j: usize, k: usize| {
            [
                (1.0 + 2.0 * v[i] - v[j] - v[k]) / 3.0,
                (1.0 + 2.0 * v[j] - v[k] - v[i]) / 3.0,
                (1.0 + 2.0 * v[k] - v[i] - v[j]) / 3.0,
            ]
        };
        let (n, inner) = (order, 1..order);
        let mut exponents = vec![[n, 0, 0], [0, n, 0], [0, 0, n]];
        exponents.extend(inner.clone().map(|m| [n - m, m, 0]));
        exponents.extend(inner.clone().map(|m| [0, n - m, m]));
        exponents.extend(inner.clone().map(|m| [m, 0, n - m]));
        for j in inner.clone() {
            exponents.extend((1..n - j).map(|k| [n - j - k, j, k]));
        }
        let nodes: Vec<[f64; 3]> = exponents.iter().map(|&[i, j, k]| node(i, j, k)).collect();
        let at_nodes = DMatrix::from_fn(nodes.len(), nodes.len(), |b, x| {
            bernstein(&exponents[b], &nodes[x])
        });
        let coefficients = at_nodes
            .try_inverse()
            .ok_or(AxisymmetricError::NoNodalBasis { order })?;
        Ok(Self {
            order,
            nodes,
            exponents,
            coefficients,
        })
    }

    pub fn order(&self) -> usize {
        self.order
    }

    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Number of nodes inside each edge, corners excluded.
    pub fn n_edge_nodes(&self) -> usize {
        self.order - 1
    }

    /// Number of nodes on corners and edges, which are numbered first.
    pub fn n_shared_nodes(&self) -> usize {
        3 * self.order
    }

    /// Number of nodes in the interior.
    pub fn n_inner_nodes(&self) -> usize {
        self.len() - 3 * self.order
    }

    /// Values and derivatives of the basis functions at `points`.
    pub fn tabulate(&self, points: &[RulePoint]) -> Table {
        let table = |f: &dyn Fn(&[usize; 3], &[f64; 3]) -> f64| {
            let bernstein_values = DMatrix::from_fn(self.len(), points.len(), |b, q| {
                f(&self.exponents[b], &points[q].barycentric)
            });
            &self.coefficients * bernstein_values
        };
        let derivative = |exponents: &[usize; 3], x: &[f64; 3], by: usize| {
            if exponents[by] == 0 {
                return 0.0;
            }
            let mut lower = *exponents;
            lower[by] -= 1;
            self.order as f64 * bernstein(&lower, x)
        };
        Table {
            values: table(&bernstein),
            gradients: [1, 2].map(|by| {
                table(&move |e: &[usize; 3], x: &[f64; 3]| {
                    derivative(e, x, by) - derivative(e, x, 0)
                })
            }),
        }
    }
}

/// The Bernstein polynomial `n! / (i! j! k!) λ_1^i λ_2^j λ_3^k` with `n = i + j + k`.
fn bernstein(exponents: &[usize; 3], x: &[f64; 3]) -> f64 {
    let mut value = 1.0;
    let mut n = 0;
    for (&e, &l) in exponents.iter().zip(x) {
        for m in 1..=e {
            n += 1;
            value *= l * n as f64 / m as f64;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::triangle_rule;

    #[test]
    fn interpolates_polynomials_and_their_derivatives_exactly() {
        let rule = triangle_rule(4);
        for order in 1..=10 {
            let element = Lagrange::new(order).expect("low order");
            assert_eq!(element.len(), (order + 1) * (order + 2) / 2);
            let table = element.tabulate(&rule);
            let d = order as i32;
            let at = |x: &[f64; 3]| (x[1] - 0.3 * x[2]).powi(d);
            for (q, point) in rule.iter().enumerate() {
                let [mut value, mut by_x, mut by_y, mut sum] = [0.0; 4];
                for (i, node) in element.nodes.iter().enumerate() {
                    value += at(node) * table.values[(i, q)];
                    by_x += at(node) * table.gradients[0][(i, q)];
                    by_y += at(node) * table.gradients[1][(i, q)];
                    sum += table.values[(i, q)];
                }
                let x = &point.barycentric;
                let slope = order as f64 * (x[1] - 0.3 * x[2]).powi(d - 1);
                assert!((value - at(x)).abs() < 1e-11, "order {order}");
                assert!((by_x - slope).abs() < 1e-9 && (by_y + 0.3 * slope).abs() < 1e-9);
                assert!((sum - 1.0).abs() < 1e-11);
            }
        }
    }

    #[test]
    fn nodes_are_in_the_triangle_and_lobatto_points_on_edges() {
        let element = Lagrange::new(6).expect("low order");
        assert!(
            element
                .nodes
                .iter()
                .flatten()
                .all(|l| (-1e-15..=1.0 + 1e-15).contains(l))
        );
        let edge = &element.nodes[3..3 + element.n_edge_nodes()];
        for (node, v) in edge.iter().zip(&lobatto(6)[1..]) {
            assert!((node[1] - v).abs() < 1e-15 && node[2].abs() < 1e-15);
        }
        assert_eq!(element.n_inner_nodes(), 10);
    }
}
