//! An edge length everywhere, from edge lengths at given points.

use super::input::{demand, finite, length};
use crate::GenerateError;
use mesh::{BoundingBox, Vec3};

/// Largest number of points in a leaf; for so few, comparing all is faster than branching.
const LEAF: usize = 8;

/// Edge length everywhere, from edge lengths `h_i` at points `x_i`.
///
/// `h(x) = min_i (h_i + g |x - x_i|)`: the largest field that is at most `h_i` at each `x_i` and
/// grows by no more than `g` per unit of length. For [`generate_sized`](crate::generate_sized). A
/// tree of bounding boxes with their smallest lengths skips most of the points.
pub struct SizeMap {
    /// Points with their lengths; the points of each tree node are contiguous.
    points: Vec<(Vec3, f64)>,
    /// Nodes of a complete binary tree; the children of node `k` are `2 k + 1` and `2 k + 2`.
    nodes: Vec<Node>,
    growth: f64,
}

/// Bounding box and smallest length of some of the points.
#[derive(Clone, Copy)]
struct Node {
    around: BoundingBox,
    smallest: f64,
}

impl Node {
    fn new(points: &[(Vec3, f64)]) -> Self {
        let lengths = points.iter().map(|(_, h)| *h);
        Self {
            around: BoundingBox::around(points.iter().map(|(x, _)| x)),
            smallest: lengths.fold(f64::INFINITY, f64::min),
        }
    }

    /// Lower bound of the length that the points of the node allow at `x`.
    fn bound(&self, x: &Vec3, growth: f64) -> f64 {
        self.smallest + growth * self.around.distance(x)
    }
}

impl SizeMap {
    /// Builds the tree over the points, each given with its edge length.
    ///
    /// Cost: O(n log² n).
    ///
    /// # Errors
    /// [`GenerateError::BadParameter`] if there is no point, a coordinate is not finite, a length
    /// is not positive, or `growth` is negative.
    pub fn new(mut points: Vec<(Vec3, f64)>, growth: f64) -> Result<Self, GenerateError> {
        let count = points.len() as f64;
        let at_least_one = "it must be at least one";
        demand(
            count > 0.0,
            "number of points of the size map",
            count,
            at_least_one,
        )?;
        let is_growth = growth >= 0.0 && growth.is_finite();
        let not_negative = "it must be zero or positive";
        demand(is_growth, "growth of the size map", growth, not_negative)?;
        for (x, h) in &points {
            length("length in the size map", *h)?;
            finite("coordinate in the size map", *x)?;
        }
        let mut nodes = Vec::new();
        divide(&mut points, 0, &mut nodes);
        Ok(Self {
            points,
            nodes,
            growth,
        })
    }

    /// Edge length at `x`.
    pub fn at(&self, x: Vec3) -> f64 {
        let mut best = f64::INFINITY;
        self.search(0, &self.points, &x, &mut best);
        best
    }

    fn search(&self, node: usize, points: &[(Vec3, f64)], x: &Vec3, best: &mut f64) {
        if points.len() <= LEAF {
            for (y, h) in points {
                *best = best.min(h + self.growth * (x - y).norm());
            }
            return;
        }
        let (left, right) = points.split_at(points.len() / 2);
        let children = [(2 * node + 1, left), (2 * node + 2, right)];
        let mut bounds = children.map(|(child, part)| {
            let bound = self.nodes[child].bound(x, self.growth);
            (bound, child, part)
        });
        if bounds[1].0 < bounds[0].0 {
            bounds.swap(0, 1);
        }
        for (bound, child, part) in bounds {
            if bound < *best {
                self.search(child, part, x, best);
            }
        }
    }
}

/// Divides the points in halves along the longest side of their box, down to the leaves.
fn divide(points: &mut [(Vec3, f64)], node: usize, nodes: &mut Vec<Node>) {
    let own = Node::new(points);
    if nodes.len() <= node {
        nodes.resize(node + 1, own);
    }
    nodes[node] = own;
    if points.len() <= LEAF {
        return;
    }
    let axis = (own.around.max - own.around.min).imax();
    let half = points.len() / 2;
    points.select_nth_unstable_by(half, |a, b| a.0[axis].total_cmp(&b.0[axis]));
    let (left, right) = points.split_at_mut(half);
    divide(left, 2 * node + 1, nodes);
    divide(right, 2 * node + 2, nodes);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points on a spiral, with lengths that vary strongly.
    fn spiral(n: usize) -> Vec<(Vec3, f64)> {
        (0..n)
            .map(|i| {
                let t = i as f64;
                let x = Vec3::new((0.7 * t).cos(), (0.7 * t).sin(), 0.01 * t) * (1.0 + 0.02 * t);
                (x, 0.05 + 0.4 * (1.3 * t).sin().abs())
            })
            .collect()
    }

    #[test]
    fn tree_search_finds_the_minimum_over_all_points() {
        let points = spiral(333);
        for growth in [0.0, 0.3, 2.0] {
            let map = SizeMap::new(points.clone(), growth).unwrap();
            for k in 0..200 {
                let t = f64::from(k);
                let x = Vec3::new((2.1 * t).sin(), (1.7 * t).cos(), (0.9 * t).sin()) * (0.05 * t);
                let all = points
                    .iter()
                    .map(|(y, h)| h + growth * (x - y).norm())
                    .fold(f64::INFINITY, f64::min);
                assert_eq!(map.at(x), all);
            }
        }
    }

    #[test]
    fn bad_lengths_coordinates_and_growth_are_refused() {
        let at = |h: f64| vec![(Vec3::zeros(), h)];
        for points in [vec![], at(0.0), at(f64::NAN), at(f64::INFINITY)] {
            assert!(SizeMap::new(points, 0.3).is_err());
        }
        assert!(SizeMap::new(vec![(Vec3::x() / 0.0, 1.0)], 0.3).is_err());
        assert!(SizeMap::new(at(1.0), f64::NAN).is_err());
    }
}
