//! Delaunay triangulation of points in the plane, by insertion with exact predicates.

use robust::{Coord, incircle, orient2d};

use crate::curve::Point;

const NONE: usize = usize::MAX;

/// An incremental Delaunay triangulation.
///
/// Its first [`OUTER_CORNERS`] points are the corners of a triangle that contains all others.
pub(crate) struct Delaunay {
    pub points: Vec<Point>,
    /// Corners, counter-clockwise.
    pub triangles: Vec<[usize; 3]>,
    /// The neighbour across the edge opposite to each corner, or [`NONE`].
    neighbours: Vec<[usize; 3]>,
    /// The triangle where the search for the next point starts.
    last: usize,
}

/// Number of corners of the outer triangle.
pub(crate) const OUTER_CORNERS: usize = 3;

/// Size of the outer triangle relative to the radius of the point set.
///
/// Large enough that boundary edges are kept even where the hull bulges outwards by only a
/// thousandth.
const OUTER_SIZE: f64 = 1e5;

impl Delaunay {
    /// The outer triangle alone, for points within `radius` of `centre`.
    pub fn around(centre: Point, radius: f64) -> Self {
        let far = OUTER_SIZE * radius;
        let points = [(-2.0, -1.0), (2.0, -1.0), (0.0, 3.0)]
            .map(|(x, y)| centre + far * Point::new(x, y))
            .to_vec();
        Self {
            points,
            triangles: vec![[0, 1, 2]],
            neighbours: vec![[NONE; 3]],
            last: 0,
        }
    }

    /// Inserts a point and returns its index, or `None` if the point exists already.
    ///
    /// Replaces the triangles whose circumcircles contain the point (Bowyer 1981, Watson 1981) and
    /// stores the indices of the new triangles in `created`.
    pub fn insert(&mut self, x: Point, created: &mut Vec<usize>) -> Option<usize> {
        created.clear();
        let start = self.locate(&x);
        if self.triangles[start].iter().any(|&v| self.points[v] == x) {
            return None;
        }
        let mut cavity = vec![start];
        // boundary edges of the cavity with the triangles outside
        let mut cavity_boundary = Vec::new();
        let mut next = 0;
        while next < cavity.len() {
            let triangle = cavity[next];
            next += 1;
            for corner in 0..3 {
                let across = self.neighbours[triangle][corner];
                if cavity.contains(&across) {
                    continue;
                }
                if across != NONE && self.in_circle(across, &x) {
                    cavity.push(across);
                    continue;
                }
                let corners = self.triangles[triangle];
                cavity_boundary.push((
                    corners[(corner + 1) % 3],
                    corners[(corner + 2) % 3],
                    across,
                ));
            }
        }
        let new = self.points.len();
        self.points.push(x);
        for &(from, to, across) in &cavity_boundary {
            let triangle = cavity.pop().unwrap_or_else(|| {
                self.triangles.push([0; 3]);
                self.neighbours.push([NONE; 3]);
                self.triangles.len() - 1
            });
            if across != NONE {
                let theirs = self.triangles[across];
                let side =
                    (0..3).find(|&c| theirs[(c + 1) % 3] == to && theirs[(c + 2) % 3] == from);
                if let Some(side) = side {
                    self.neighbours[across][side] = triangle;
                }
            }
            self.triangles[triangle] = [from, to, new];
            self.neighbours[triangle] = [NONE, NONE, across];
            created.push(triangle);
        }
        // neighbours around the new point: each triangle ends where the next begins
        for &triangle in created.iter() {
            let [from, to, _] = self.triangles[triangle];
            for &other in created.iter() {
                if self.triangles[other][0] == to {
                    self.neighbours[triangle][0] = other;
                }
                if self.triangles[other][1] == from {
                    self.neighbours[triangle][1] = other;
                }
            }
        }
        self.last = created[0];
        Some(new)
    }

    /// A triangle that contains `x`, found by walking towards it.
    ///
    /// The walk terminates because the triangulation is Delaunay.
    fn locate(&self, x: &Point) -> usize {
        let mut at = self.last;
        'walk: loop {
            let corners = self.triangles[at];
            for corner in 0..3 {
                let [a, b] = [corners[(corner + 1) % 3], corners[(corner + 2) % 3]];
                let across = self.neighbours[at][corner];
                if across != NONE && self.orientation(a, b, x) < 0.0 {
                    at = across;
                    continue 'walk;
                }
            }
            return at;
        }
    }

    /// Positive if `x` is on the left of the line from point `a` to point `b`.
    fn orientation(&self, a: usize, b: usize, x: &Point) -> f64 {
        orient2d(coord(&self.points[a]), coord(&self.points[b]), coord(x))
    }

    /// Whether `x` is inside the circumcircle of a triangle.
    fn in_circle(&self, triangle: usize, x: &Point) -> bool {
        let [a, b, c] = self.triangles[triangle].map(|v| coord(&self.points[v]));
        incircle(a, b, c, coord(x)) > 0.0
    }
}

fn coord(x: &Point) -> Coord<f64> {
    Coord { x: x.x, y: x.y }
}

/// Centre of the circle through three points; not finite if they are collinear.
pub(crate) fn circumcentre([a, b, c]: [Point; 3]) -> Point {
    let (u, v) = (b - a, c - a);
    let twice_cross = 2.0 * u.perp(&v);
    let (uu, vv) = (u.norm_squared(), v.norm_squared());
    a + Point::new(v.y * uu - u.y * vv, u.x * vv - v.x * uu) / twice_cross
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square grid, which has many collinear and cocircular points.
    fn grid(n: usize) -> Delaunay {
        let mut mesh = Delaunay::around(Point::new(0.5, 0.5), 1.0);
        let mut created = Vec::new();
        for k in 0..n * n {
            // in an order without locality
            let k = k * 7 % (n * n);
            let x = Point::new((k % n) as f64, (k / n) as f64) / (n - 1) as f64;
            assert!(mesh.insert(x, &mut created).is_some());
        }
        mesh
    }

    #[test]
    fn triangles_of_a_grid_cover_the_square_once() {
        let n = 20;
        let mut mesh = grid(n);
        let mut created = Vec::new();
        assert_eq!(mesh.insert(Point::zeros(), &mut created), None);
        let inner = mesh
            .triangles
            .iter()
            .filter(|t| t.iter().all(|&v| v >= OUTER_CORNERS));
        let areas: Vec<f64> = inner
            .map(|t| {
                let [a, b, c] = t.map(|v| mesh.points[v]);
                0.5 * (b - a).perp(&(c - a))
            })
            .collect();
        assert!(areas.iter().all(|&a| a > 0.0));
        assert!((areas.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(areas.len(), 2 * (n - 1) * (n - 1));
    }

    #[test]
    fn neighbours_are_mutual_and_circumcircles_are_empty() {
        let mesh = grid(12);
        for (t, corners) in mesh.triangles.iter().enumerate() {
            for (c, &across) in mesh.neighbours[t].iter().enumerate() {
                if across == NONE {
                    continue;
                }
                let edge = [corners[(c + 1) % 3], corners[(c + 2) % 3]];
                let theirs = mesh.triangles[across];
                assert!(edge.iter().all(|v| theirs.contains(v)));
                assert!(mesh.neighbours[across].contains(&t));
                let opposite = theirs.iter().find(|v| !edge.contains(v)).unwrap();
                assert!(!mesh.in_circle(t, &mesh.points[*opposite]));
            }
        }
    }

    #[test]
    fn circumcentre_is_equidistant_from_the_corners() {
        let corners = [(0.0, 0.0), (3.0, 1.0), (1.0, 2.0)].map(|(x, y)| Point::new(x, y));
        let centre = circumcentre(corners);
        let radii = corners.map(|c| (c - centre).norm());
        assert!(radii.iter().all(|r| (r - radii[0]).abs() < 1e-14));
    }
}
