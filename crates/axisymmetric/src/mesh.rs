//! The triangle mesh of a meridian domain and the polygon of its boundary edges.

use std::collections::BTreeMap;

use crate::AxisymmetricError;
use crate::curve::{BoundaryPart, Curve, MIN_CURVED_EDGES, Point};
use crate::meridian::Meridian;

/// Largest number of triangles; a meridian plane that needs more has gaps that are too narrow.
const MAX_TRIANGLES: usize = 20_000;

/// An edge of the boundary: the part of a curve between two parameters, one for each end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoundaryEdge {
    pub curve: Curve,
    pub parameters: [f64; 2],
}

impl BoundaryEdge {
    pub fn part(&self) -> BoundaryPart {
        self.curve.part()
    }

    /// The point of the curve at fraction `s` of the edge, from its first end to its second.
    pub fn point(&self, s: f64) -> Point {
        let [from, to] = self.parameters;
        self.curve.point(from * (1.0 - s) + to * s)
    }
}

/// The divided boundary: a closed polygon with the domain on its left.
pub(crate) struct BoundaryPolygon {
    pub points: Vec<Point>,
    /// Edge `i` runs from point `i` to the next, cyclically.
    edges: Vec<BoundaryEdge>,
    /// Centre of the bounding box.
    pub centre: Point,
    /// Diagonal of the bounding box.
    pub radius: f64,
}

impl BoundaryPolygon {
    /// Divides the boundary into edges of about length `size`.
    ///
    /// # Errors
    /// [`AxisymmetricError::TooManyTriangles`] if there are more edges than triangles supported.
    pub fn divide(
        meridian: &Meridian,
        size: &impl Fn(&Point) -> f64,
    ) -> Result<Self, AxisymmetricError> {
        let (mut points, mut edges) = (Vec::new(), Vec::new());
        for (curve, division) in meridian.boundary() {
            let min_edges = if curve.is_curved() {
                MIN_CURVED_EDGES
            } else {
                1
            };
            let parameters = division.unwrap_or_else(|| curve.divide(min_edges, size));
            for pair in parameters.windows(2) {
                points.push(curve.point(pair[0]));
                edges.push(BoundaryEdge {
                    curve,
                    parameters: [pair[0], pair[1]],
                });
            }
            check_triangle_count(points.len())?;
        }
        let (lower, upper) = points
            .iter()
            .fold((points[0], points[0]), |(lower, upper), x| {
                (lower.inf(x), upper.sup(x))
            });
        Ok(Self {
            points,
            edges,
            centre: 0.5 * (lower + upper),
            radius: (upper - lower).norm(),
        })
    }

    /// Index of the point after point `i`.
    pub fn next(&self, i: usize) -> usize {
        (i + 1) % self.points.len()
    }

    /// The boundary edge between points `a` and `b`, oriented from `a` to `b`.
    pub fn edge(&self, a: usize, b: usize) -> Option<BoundaryEdge> {
        let n = self.points.len();
        if a >= n || b >= n {
            return None;
        }
        if self.next(a) == b {
            return Some(self.edges[a]);
        }
        (self.next(b) == a).then(|| {
            let BoundaryEdge {
                curve,
                parameters: [from, to],
            } = self.edges[b];
            BoundaryEdge {
                curve,
                parameters: [to, from],
            }
        })
    }

    /// Whether points `a` and `b` are joined by an edge that is not on the axis.
    pub fn is_off_axis(&self, a: usize, b: usize) -> bool {
        self.edge(a, b)
            .is_some_and(|edge| edge.part() != BoundaryPart::Axis)
    }

    /// Whether a point encroaches on a boundary edge: lies in the circle with it as diameter.
    pub fn is_encroached_by(&self, x: &Point) -> bool {
        (0..self.points.len()).any(|i| {
            let [a, b] = [self.points[i], self.points[self.next(i)]];
            (x - a).dot(&(x - b)) <= 0.0
        })
    }

    /// Whether all corners of a triangle are on the same body or outline of a collar; the triangle
    /// is then inside it.
    pub fn is_in_body(&self, corners: &[usize; 3]) -> bool {
        let n = self.points.len();
        // a pole belongs to a body and to the axis: to the curves that end and begin there
        let parts = |v: usize| [self.edges[v].part(), self.edges[(v + n - 1) % n].part()];
        if corners.iter().any(|&v| v >= n) {
            return false;
        }
        parts(corners[0]).iter().any(|part| {
            matches!(part, BoundaryPart::Body(_) | BoundaryPart::Interface(_))
                && corners.iter().all(|&v| parts(v).contains(part))
        })
    }
}

/// Fails with [`AxisymmetricError::TooManyTriangles`] above the largest number supported.
pub(crate) fn check_triangle_count(found: usize) -> Result<(), AxisymmetricError> {
    if found <= MAX_TRIANGLES {
        return Ok(());
    }
    Err(AxisymmetricError::TooManyTriangles {
        found,
        limit: MAX_TRIANGLES,
    })
}

/// A conforming triangulation with the curve on which each boundary edge lies.
pub(crate) struct MeridianMesh {
    pub points: Vec<Point>,
    /// Corners, counter-clockwise.
    pub triangles: Vec<[usize; 3]>,
    /// Edges of each triangle: edge `e` runs from its corner `e` to the next.
    pub edges: Vec<[usize; 3]>,
    /// The two ends of each edge, the smaller index first.
    pub ends: Vec<[usize; 2]>,
    /// The boundary curve of each edge; `None` in the interior.
    pub boundary: Vec<Option<BoundaryEdge>>,
}

impl MeridianMesh {
    /// Numbers the edges of a triangulation whose first points are those of `polygon`.
    pub fn connect(
        points: Vec<Point>,
        triangles: Vec<[usize; 3]>,
        polygon: &BoundaryPolygon,
    ) -> Self {
        let mut numbers = BTreeMap::new();
        let mut ends = Vec::new();
        let edges = triangles
            .iter()
            .map(|corners| {
                [0, 1, 2].map(|e| {
                    let pair = [corners[e], corners[(e + 1) % 3]];
                    let key = [pair[0].min(pair[1]), pair[0].max(pair[1])];
                    *numbers.entry(key).or_insert_with(|| {
                        ends.push(key);
                        ends.len() - 1
                    })
                })
            })
            .collect();
        let boundary = ends.iter().map(|&[a, b]| polygon.edge(a, b)).collect();
        Self {
            points,
            triangles,
            edges,
            ends,
            boundary,
        }
    }

    /// Whether a triangle has a curved edge.
    pub fn is_curved(&self, triangle: usize) -> bool {
        self.edges[triangle]
            .iter()
            .any(|&edge| self.boundary[edge].is_some_and(|b| b.curve.is_curved()))
    }
}
