//! Closest points of all patches or curves, by a bounding volume hierarchy.

use mesh::{BoundingBox, BoxTree, Vec3};

use super::patch::{Curve, Patch};

/// The closest point of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foot {
    /// Triangle on which the point is.
    pub triangle: usize,
    /// Barycentric coordinates in the triangle.
    pub at: [f64; 3],
    pub point: Vec3,
    pub distance: f64,
}

/// The hierarchy of boxes around the patches.
#[derive(Clone)]
pub(super) struct PatchTree(BoxTree);

impl PatchTree {
    pub fn new(patches: &[Patch]) -> Self {
        let boxes = patches.iter().map(|patch| {
            let hull: Vec<Vec3> = patch.hull().collect();
            BoundingBox::around(&hull)
        });
        Self(BoxTree::new(boxes.enumerate()))
    }

    /// The closest point to `x` within `limit` of those patches that are wanted.
    pub fn closest(
        &self,
        patches: &[Patch],
        x: &Vec3,
        limit: f64,
        is_wanted: impl Fn(usize) -> bool,
    ) -> Option<Foot> {
        let best = self.0.best(
            limit,
            |around| around.distance(x),
            |triangle, best| {
                let patch = &patches[triangle];
                if !is_wanted(triangle) {
                    return None;
                }
                let (at, point) = closest_of_triangle(&patch.corners, x);
                let distance = (point - x).norm();
                if distance - patch.bulge >= best {
                    return None;
                }
                if patch.bulge == 0.0 {
                    return Some((distance, (at, point)));
                }
                let (at, point) = patch.closest(x, at);
                Some(((point - x).norm(), (at, point)))
            },
        );
        best.map(|(triangle, distance, (at, point))| Foot {
            triangle,
            at,
            point,
            distance,
        })
    }
}

impl PatchTree {
    /// The point of the hulls of all patches that is farthest in a direction, a unit vector.
    pub fn farthest(&self, patches: &[Patch], direction: &Vec3) -> Vec3 {
        let best = self.0.best(
            f64::INFINITY,
            |around| -around.support(direction),
            |triangle, _| {
                let points = patches[triangle].hull().map(|x| (-x.dot(direction), x));
                points.min_by(|x, y| x.0.total_cmp(&y.0))
            },
        );
        best.map_or(Vec3::zeros(), |(_, _, point)| point)
    }
}

/// The hierarchy of boxes around curves.
#[derive(Clone)]
pub(super) struct CurveTree {
    tree: BoxTree,
    curves: Vec<Curve>,
}

impl CurveTree {
    pub fn new(curves: Vec<Curve>) -> Self {
        let boxes = (curves.iter()).map(|curve| BoundingBox::around(&curve.points));
        let tree = BoxTree::new(boxes.enumerate());
        Self { tree, curves }
    }

    /// The closest point to `x`; `None` without curves.
    pub fn closest(&self, x: &Vec3) -> Option<Vec3> {
        let best = self.tree.best(
            f64::INFINITY,
            |around| around.distance(x),
            |number, _| {
                let curve = &self.curves[number];
                let [a, .., b] = curve.points;
                let chord = b - a;
                let start = (x - a).dot(&chord) / chord.norm_squared();
                let (_, point) = curve.closest(x, start);
                Some(((point - x).norm(), point))
            },
        );
        best.map(|(_, _, point)| point)
    }
}

/// Barycentric coordinates of the closest point of a flat triangle, and the point (Ericson 2005,
/// 5.1.5).
fn closest_of_triangle(&[a, b, c]: &[Vec3; 3], x: &Vec3) -> ([f64; 3], Vec3) {
    let (ab, ac) = (b - a, c - a);
    let [(d1, d2), (d3, d4), (d5, d6)] =
        [x - a, x - b, x - c].map(|arm| (ab.dot(&arm), ac.dot(&arm)));
    let at = |b0: f64, b1: f64, b2: f64| ([b0, b1, b2], b0 * a + b1 * b + b2 * c);
    if d1 <= 0.0 && d2 <= 0.0 {
        return at(1.0, 0.0, 0.0);
    }
    if d3 >= 0.0 && d4 <= d3 {
        return at(0.0, 1.0, 0.0);
    }
    if d6 >= 0.0 && d5 <= d6 {
        return at(0.0, 0.0, 1.0);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return at(1.0 - t, t, 0.0);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return at(1.0 - t, 0.0, t);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return at(0.0, 1.0 - t, t);
    }
    let sum = va + vb + vc;
    let (v, w) = (vb / sum, vc / sum);
    at(1.0 - v - w, v, w)
}
