//! Values of flows at points, and the flow of one order on the elements of another.

use nalgebra::DMatrix;

use super::flow_system::{Fields, FlowSystem};
use crate::AxisymmetricError;
use crate::curve::Point;
use crate::element::Lagrange;
use crate::quadrature::RulePoint;

/// A point in a triangle, with the values of the basis functions there.
pub(crate) struct Place {
    triangle: usize,
    weights: Vec<f64>,
}

/// Finds points in a mesh.
pub(crate) struct Locator<'a> {
    triangles: Vec<LocatedTriangle>,
    element: &'a Lagrange,
}

struct LocatedTriangle {
    nodes: Vec<Point>,
    /// Bounds of the triangle, enlarged.
    bounds: [Point; 2],
}

/// Smallest barycentric coordinate of a point in a mesh of the same domain: the curved edges of
/// both are polynomials that differ.
const MIN_BARYCENTRIC: f64 = -0.02;

impl Locator<'_> {
    /// The place of a point: of the triangle in which it is deepest.
    ///
    /// # Errors
    /// [`AxisymmetricError::OutsideMesh`].
    pub fn locate(&self, x: &Point) -> Result<Place, AxisymmetricError> {
        let inside = |triangle: &LocatedTriangle| {
            let [low, high] = &triangle.bounds;
            (0..2).all(|d| low[d] <= x[d] && x[d] <= high[d])
        };
        let candidates = (self.triangles.iter().enumerate()).filter(|(_, t)| inside(t));
        let depth = |l: &[f64; 3]| l[0].min(l[1]).min(l[2]);
        let deepest = candidates
            .filter_map(|(t, triangle)| Some((t, self.barycentric(triangle, x)?)))
            .max_by(|(_, a), (_, b)| depth(a).total_cmp(&depth(b)));
        match deepest {
            Some((triangle, l)) if depth(&l) >= MIN_BARYCENTRIC => Ok(Place {
                triangle,
                weights: self.weights(&l).iter().copied().collect(),
            }),
            _ => Err(AxisymmetricError::OutsideMesh { at: [x.x, x.y] }),
        }
    }

    fn weights(&self, l: &[f64; 3]) -> DMatrix<f64> {
        self.element.tabulate(&[at_point(l)]).values
    }

    /// Barycentric coordinates by Newton's method, those of the straight triangle at first; `None`
    /// if it does not converge.
    fn barycentric(&self, triangle: &LocatedTriangle, x: &Point) -> Option<[f64; 3]> {
        /// Three are enough for curved triangles next to which the point is.
        const STEPS: usize = 8;
        let nodes = &triangle.nodes;
        let size = (nodes[1] - nodes[0]).norm();
        let sides = [nodes[1] - nodes[0], nodes[2] - nodes[0]];
        let first = nalgebra::Matrix2::from_columns(&sides).try_inverse()? * (x - nodes[0]);
        let mut l = [1.0 - first.x - first.y, first.x, first.y];
        for _ in 0..STEPS {
            // far outside polynomials of high degree are of no use
            if l.iter().any(|l| *l < -1.0) {
                return None;
            }
            let table = self.element.tabulate(&[at_point(&l)]);
            let sum = |values: &DMatrix<f64>| -> Point {
                (nodes.iter().zip(values.iter())).map(|(x, n)| x * *n).sum()
            };
            let residual = x - sum(&table.values);
            if residual.norm() <= 1e-14 * size {
                break;
            }
            let columns = table.gradients.each_ref().map(sum);
            let step = nalgebra::Matrix2::from_columns(&columns).try_inverse()? * residual;
            l = [l[0] - step.x - step.y, l[1] + step.x, l[2] + step.y];
        }
        l.iter().all(|l| l.is_finite()).then_some(l)
    }
}

fn at_point(barycentric: &[f64; 3]) -> RulePoint {
    RulePoint {
        barycentric: *barycentric,
        weight: 0.0,
    }
}

impl FlowSystem {
    /// The value at a place of a field at the velocity nodes.
    pub fn value(&self, place: &Place, field: &[Point]) -> Point {
        let nodes = self.spaces[0].nodes[place.triangle].iter();
        nodes
            .zip(&place.weights)
            .map(|(&node, weight)| *weight * field[node as usize])
            .sum()
    }

    /// Finds points in the mesh whose velocity nodes have these positions.
    pub fn locator<'a>(&'a self, positions: &[Point]) -> Locator<'a> {
        let triangles = self.spaces[0].nodes.iter().map(|nodes| {
            let nodes: Vec<Point> = nodes.iter().map(|&n| positions[n as usize]).collect();
            let infinite = Point::repeat(f64::INFINITY);
            let [low, high] = (nodes.iter()).fold([infinite, -infinite], |[low, high], x| {
                [low.inf(x), high.sup(x)]
            });
            // an edge bends beyond its nodes by less than its height
            let margin = 0.1 * (high - low);
            LocatedTriangle {
                nodes,
                bounds: [low - margin, high + margin],
            }
        });
        Locator {
            triangles: triangles.collect(),
            element: &self.velocity,
        }
    }

    /// The flow of another order on the same mesh, interpolated.
    pub fn interpolated(&self, from: &Self, fields: &Fields) -> Fields {
        let mut result = self.rest();
        result.motions.clone_from(&fields.motions);
        let points = |nodes: &[[f64; 3]]| -> Vec<_> { nodes.iter().map(at_point).collect() };
        let velocity = from.velocity.tabulate(&points(&self.velocity.nodes)).values;
        let pressure = from.pressure.tabulate(&points(&self.pressure.nodes)).values;
        for t in 0..self.mesh.triangles.len() {
            for (q, &node) in self.spaces[0].nodes[t].iter().enumerate() {
                result.velocity[node as usize] = (from.spaces[0].nodes[t].iter().enumerate())
                    .map(|(i, &old)| velocity[(i, q)] * fields.velocity[old as usize])
                    .sum();
            }
            for (q, &node) in self.spaces[1].nodes[t].iter().enumerate() {
                result.pressure[node as usize] = (from.spaces[1].nodes[t].iter().enumerate())
                    .map(|(i, &old)| pressure[(i, q)] * fields.pressure[old as usize])
                    .sum();
            }
        }
        let level = result.pressure[0];
        result.pressure.iter_mut().for_each(|p| *p -= level);
        result
    }
}
