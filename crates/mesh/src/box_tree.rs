//! Trees of axis-parallel boxes: which boxes meet a given one, and which object is nearest.

use crate::Vec3;

/// Largest number of boxes in a leaf: below it, testing them costs less than dividing them.
const MAX_BOXES_IN_LEAF: usize = 4;

/// An axis-parallel box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingBox {
    /// Smallest coordinates.
    pub min: Vec3,
    /// Largest coordinates.
    pub max: Vec3,
}

impl BoundingBox {
    /// The smallest box around some points; without points it is empty and meets no other.
    pub fn around<'a>(points: impl IntoIterator<Item = &'a Vec3>) -> Self {
        let empty = Self {
            min: Vec3::repeat(f64::INFINITY),
            max: Vec3::repeat(f64::NEG_INFINITY),
        };
        points.into_iter().fold(empty, |all, x| Self {
            min: all.min.inf(x),
            max: all.max.sup(x),
        })
    }

    /// Whether two boxes have a common point, on their boundaries too.
    pub fn meets(&self, other: &Self) -> bool {
        (0..3).all(|k| self.min[k] <= other.max[k] && other.min[k] <= self.max[k])
    }

    /// Distance of a point; zero inside.
    pub fn distance(&self, x: &Vec3) -> f64 {
        (self.min - x)
            .sup(&(x - self.max))
            .sup(&Vec3::zeros())
            .norm()
    }

    /// Largest `x · direction` of its points.
    pub fn support(&self, direction: &Vec3) -> f64 {
        let largest = |k: usize| (self.min[k] * direction[k]).max(self.max[k] * direction[k]);
        largest(0) + largest(1) + largest(2)
    }

    fn union(&self, other: &Self) -> Self {
        Self {
            min: self.min.inf(&other.min),
            max: self.max.sup(&other.max),
        }
    }

    fn centre(&self) -> Vec3 {
        0.5 * (self.min + self.max)
    }
}

/// A binary tree of boxes, each of which has a number.
///
/// Cost: `O(n log n)` to build; queries visit `O(log n)` nodes where boxes overlap little.
///
/// ```
/// use mesh::{BoundingBox, BoxTree, Vec3};
/// let points: Vec<Vec3> = (0..100).map(|k| Vec3::new(f64::from(k), 0.0, 0.0)).collect();
/// let tree = BoxTree::new(points.iter().map(|x| BoundingBox::around([x])).enumerate());
/// let x = Vec3::new(41.8, 3.0, 0.0);
/// let distance = |k: usize, _| Some(((points[k] - x).norm(), ()));
/// let nearest = tree.best(f64::INFINITY, |around| around.distance(&x), distance);
/// assert_eq!(nearest.map(|(k, _, ())| k), Some(42));
/// ```
#[derive(Clone, Debug, Default)]
pub struct BoxTree {
    /// The root first; children stand after their parents.
    nodes: Vec<Node>,
    /// The boxes with their numbers, those of a leaf one after the other.
    boxes: Vec<(usize, BoundingBox)>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    around: BoundingBox,
    children: Children,
}

#[derive(Clone, Copy, Debug)]
enum Children {
    Nodes([usize; 2]),
    /// First one, and the one after the last.
    Boxes([usize; 2]),
}

impl BoxTree {
    /// The tree of numbered boxes.
    pub fn new(boxes: impl IntoIterator<Item = (usize, BoundingBox)>) -> Self {
        let mut tree = Self {
            nodes: Vec::new(),
            boxes: boxes.into_iter().collect(),
        };
        if !tree.boxes.is_empty() {
            tree.divide(0, tree.boxes.len());
        }
        tree
    }

    /// Adds the node of a range of boxes and those below it; returns its number.
    fn divide(&mut self, first: usize, end: usize) -> usize {
        let range = &mut self.boxes[first..end];
        let around = range.iter().fold(range[0].1, |all, (_, of)| all.union(of));
        let node = self.nodes.len();
        self.nodes.push(Node {
            around,
            children: Children::Boxes([first, end]),
        });
        if range.len() > MAX_BOXES_IN_LEAF {
            let centres: Vec<Vec3> = range.iter().map(|(_, of)| of.centre()).collect();
            let BoundingBox { min, max } = BoundingBox::around(&centres);
            let axis = (max - min).imax();
            let middle = range.len() / 2;
            // Equal centres are ordered by number, so that the tree does not depend on the sort.
            range.select_nth_unstable_by(middle, |(a, of_a), (b, of_b)| {
                let [of_a, of_b] = [of_a, of_b].map(|of| of.centre()[axis]);
                of_a.total_cmp(&of_b).then(a.cmp(b))
            });
            let children = [
                self.divide(first, first + middle),
                self.divide(first + middle, end),
            ];
            self.nodes[node].children = Children::Nodes(children);
        }
        node
    }

    /// Calls `visit` with the number of each box that meets a given one, in no particular order.
    pub fn visit_meeting(&self, other: &BoundingBox, mut visit: impl FnMut(usize)) {
        let mut stack = Vec::from_iter((!self.nodes.is_empty()).then_some(0));
        while let Some(node) = stack.pop() {
            let node = &self.nodes[node];
            if !node.around.meets(other) {
                continue;
            }
            match node.children {
                Children::Nodes(children) => stack.extend(children),
                Children::Boxes([first, end]) => (self.boxes[first..end].iter())
                    .filter(|(_, of)| of.meets(other))
                    .for_each(|(number, _)| visit(*number)),
            }
        }
    }

    /// The object of the smallest cost below `limit`: its number, its cost and what `cost` found.
    ///
    /// `bound` is a lower bound of the costs of all objects in a box. `cost` gets the number of an
    /// object and the smallest cost so far, and may return nothing for an object that does not
    /// improve on it. Of equal costs that of the smallest number counts.
    pub fn best<T>(
        &self,
        limit: f64,
        bound: impl Fn(&BoundingBox) -> f64,
        mut cost: impl FnMut(usize, f64) -> Option<(f64, T)>,
    ) -> Option<(usize, f64, T)> {
        let mut best: Option<(usize, f64, T)> = None;
        let mut stack = Vec::from_iter(self.nodes.first().map(|root| (bound(&root.around), 0)));
        while let Some((lowest, node)) = stack.pop() {
            if lowest > best.as_ref().map_or(limit, |found| found.1) {
                continue;
            }
            match self.nodes[node].children {
                Children::Nodes(children) => {
                    let [a, b] = children.map(|child| (bound(&self.nodes[child].around), child));
                    // The child that promises more is visited first.
                    stack.extend(if a.0 <= b.0 { [b, a] } else { [a, b] });
                }
                Children::Boxes([first, end]) => {
                    for &(number, _) in &self.boxes[first..end] {
                        let smallest = best.as_ref().map_or(limit, |found| found.1);
                        let Some((of_object, found)) = cost(number, smallest) else {
                            continue;
                        };
                        let is_better = match &best {
                            None => of_object < limit,
                            Some((k, least, _)) => {
                                of_object < *least || (of_object == *least && number < *k)
                            }
                        };
                        if is_better {
                            best = Some((number, of_object, found));
                        }
                    }
                }
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn boxes() -> impl Strategy<Value = Vec<BoundingBox>> {
        let coordinates = || prop::array::uniform3(-4.0..4.0_f64).prop_map(Vec3::from);
        let pairs = prop::collection::vec((coordinates(), coordinates()), 0..60);
        pairs.prop_map(|pairs| {
            let around = |(a, b): &(Vec3, Vec3)| BoundingBox::around([a, &(0.8 * a + 0.2 * b)]);
            pairs.iter().map(around).collect()
        })
    }

    proptest! {
        #[test]
        fn queries_find_what_a_test_of_all_boxes_finds(
            boxes in boxes(),
            x in prop::array::uniform3(-5.0..5.0_f64).prop_map(Vec3::from),
        ) {
            let tree = BoxTree::new(boxes.iter().copied().enumerate());
            for other in &boxes {
                let mut found = Vec::new();
                tree.visit_meeting(other, |k| found.push(k));
                found.sort_unstable();
                let all = (0..boxes.len()).filter(|&k| boxes[k].meets(other));
                prop_assert_eq!(found, all.collect::<Vec<_>>());
            }
            let distances: Vec<f64> = boxes.iter().map(|of| of.distance(&x)).collect();
            let nearest = (0..boxes.len()).min_by(|&a, &b| distances[a].total_cmp(&distances[b]));
            let found = tree.best(f64::INFINITY, |of| of.distance(&x), |k, _| Some((distances[k], k)));
            prop_assert_eq!(found.map(|(k, _, _)| k), nearest);
            let farthest = boxes.iter().map(|of| of.support(&x)).fold(f64::NEG_INFINITY, f64::max);
            let found = tree.best(f64::INFINITY, |of| -of.support(&x), |k, _| Some((-boxes[k].support(&x), ())));
            prop_assert_eq!(found.map_or(f64::NEG_INFINITY, |(_, cost, ())| -cost), farthest);
        }
    }

    #[test]
    fn an_empty_tree_finds_nothing() {
        let tree = BoxTree::new([]);
        tree.visit_meeting(&BoundingBox::around([&Vec3::zeros()]), |_| panic!("no box"));
        assert!(
            tree.best(f64::INFINITY, |_| 0.0, |_, _| Some((0.0, ())))
                .is_none()
        );
    }
}
