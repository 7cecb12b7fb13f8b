//! Triangles that fill a meridian domain: graded, with edges that know the curve they are on.

use std::collections::BTreeMap;

use crate::AxisymmetricError;
use crate::curve::Curve;
use crate::delaunay::{Delaunay, OUTER, circumcentre};
use crate::meridian::{Meridian, Point, Side};
use crate::shape::is_sound;

/// A conforming triangulation, its boundary edges on the true curves.
pub(crate) struct MeridianMesh {
    pub points: Vec<Point>,
    /// Corners, counter-clockwise.
    pub triangles: Vec<[usize; 3]>,
    /// Edges of each triangle, edge `e` from its corner `e` to the next.
    pub edges: Vec<[usize; 3]>,
    /// The two ends of each edge, the smaller number first.
    pub ends: Vec<[usize; 2]>,
    /// What each edge of the boundary is on.
    pub boundary: Vec<Option<BoundaryEdge>>,
}

/// An edge of the boundary: the part of its curve between two parameters, which belong to its two ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoundaryEdge {
    pub curve: Curve,
    pub parameters: [f64; 2],
}

/// Triangles whose circumradius is larger than this part of the size wanted are refined: 0.58 is that of the equilateral one.
const WIDEST: f64 = 0.75;

/// Sweeps of smoothing: more change the mesh little.
const SWEEPS: usize = 4;

/// Triangles allowed; a meridian plane that needs more has gaps out of proportion.
const MOST_TRIANGLES: usize = 20_000;

/// Tries with elements a quarter smaller each time.
const TRIES: i32 = 6;

impl MeridianMesh {
    /// Fills `meridian`; edges are about `growth` times as long as they are far from the nearest body's focus.
    ///
    /// # Errors
    /// [`AxisymmetricError::MeshFailed`] or [`AxisymmetricError::TooManyTriangles`].
    pub fn generate(meridian: &Meridian, growth: f64) -> Result<Self, AxisymmetricError> {
        (0..TRIES)
            .find_map(|k| Self::attempt(meridian, growth * 0.75_f64.powi(k)).transpose())
            .unwrap_or(Err(AxisymmetricError::MeshFailed))
    }

    /// `None` where an edge of the boundary is missing or bends through its triangle.
    fn attempt(meridian: &Meridian, growth: f64) -> Result<Option<Self>, AxisymmetricError> {
        let size = |x: &Point| meridian.size(x, growth);
        let rim = Rim::divide(meridian, &size)?;
        let mut inner = rim.refine(meridian, &size)?;
        for _ in 0..SWEEPS {
            inner = rim.smooth(&inner, &size);
        }
        let Some(mut triangles) = rim.triangulate(&inner).filled(&rim) else {
            return Ok(None);
        };
        let mut points = rim.points.clone();
        points.extend(inner);
        // two edges of one smooth curve in a triangle would flatten it where they meet
        for t in 0..triangles.len() {
            let corners = triangles[t];
            let walls = (0..3).filter(|&e| rim.is_wall(corners[e], corners[(e + 1) % 3]));
            if walls.count() < 2 {
                continue;
            }
            let [a, b, c] = corners;
            let middle = points.len();
            points.push((points[a] + points[b] + points[c]) / 3.0);
            triangles[t] = [a, b, middle];
            triangles.extend([[b, c, middle], [c, a, middle]]);
        }
        let mesh = Self::connect(points, triangles, &rim);
        Ok(is_sound(&mesh)?.then_some(mesh))
    }

    fn connect(points: Vec<Point>, triangles: Vec<[usize; 3]>, rim: &Rim) -> Self {
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
        let boundary = ends.iter().map(|&[a, b]| rim.edge(a, b)).collect();
        Self {
            points,
            triangles,
            edges,
            ends,
            boundary,
        }
    }
}

impl BoundaryEdge {
    pub fn side(&self) -> Side {
        self.curve.side()
    }

    /// The point at part `s` of the edge, from its first end to its second.
    pub fn point(&self, s: f64) -> Point {
        let [from, to] = self.parameters;
        self.curve.point(from * (1.0 - s) + to * s)
    }
}

/// The divided boundary: a closed polygon, the domain to its left.
struct Rim {
    points: Vec<Point>,
    /// Edge `i` runs from point `i` to the next, cyclically.
    edges: Vec<BoundaryEdge>,
    centre: Point,
    radius: f64,
}

impl Rim {
    fn divide(
        meridian: &Meridian,
        size: &impl Fn(&Point) -> f64,
    ) -> Result<Self, AxisymmetricError> {
        let (mut points, mut edges) = (Vec::new(), Vec::new());
        for curve in meridian.boundary() {
            let least = if curve.bends() { 4 } else { 1 };
            let places = curve.divide(least, size);
            for pair in places.windows(2) {
                points.push(curve.point(pair[0]));
                edges.push(BoundaryEdge {
                    curve,
                    parameters: [pair[0], pair[1]],
                });
            }
            too_many(points.len())?;
        }
        let (least, most) = points
            .iter()
            .fold((points[0], points[0]), |(least, most), x| {
                (least.inf(x), most.sup(x))
            });
        Ok(Self {
            points,
            edges,
            centre: 0.5 * (least + most),
            radius: (most - least).norm(),
        })
    }

    fn next(&self, i: usize) -> usize {
        (i + 1) % self.points.len()
    }

    /// The edge of the boundary between two points, its ends in the order given.
    fn edge(&self, a: usize, b: usize) -> Option<BoundaryEdge> {
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

    fn is_wall(&self, a: usize, b: usize) -> bool {
        self.edge(a, b)
            .is_some_and(|edge| edge.side() != Side::Axis)
    }

    fn triangulate(&self, inner: &[Point]) -> Delaunay {
        let mut mesh = Delaunay::around(self.centre, self.radius);
        let mut made = Vec::new();
        for x in self.points.iter().chain(inner) {
            mesh.insert(*x, &mut made);
        }
        mesh
    }

    /// Whether a point would come too near to an edge of the boundary: into the circle that has it as diameter.
    fn encroaches(&self, x: &Point) -> bool {
        (0..self.points.len()).any(|i| {
            let [a, b] = [self.points[i], self.points[self.next(i)]];
            (x - a).dot(&(x - b)) <= 0.0
        })
    }

    /// The body that all corners of a triangle are on, which then is inside that body.
    fn is_in_body(&self, corners: &[usize; 3]) -> bool {
        let n = self.points.len();
        // both ends of a body's curve belong to the axis' edges too: a point is on the curve that begins or ends there
        let sides = |v: usize| [self.edges[v].side(), self.edges[(v + n - 1) % n].side()];
        if corners.iter().any(|&v| v >= n) {
            return false;
        }
        sides(corners[0]).iter().any(|side| {
            matches!(side, Side::Body(_)) && corners.iter().all(|&v| sides(v).contains(side))
        })
    }

    /// Inserts circumcentres of triangles that are too large, the worst first (Chew 1989), where they do not encroach on the boundary.
    fn refine(
        &self,
        meridian: &Meridian,
        size: &impl Fn(&Point) -> f64,
    ) -> Result<Vec<Point>, AxisymmetricError> {
        let mut mesh = self.triangulate(&[]);
        let excess = |mesh: &Delaunay, t: usize| -> f64 {
            let corners = mesh.triangles[t];
            if corners.iter().any(|&v| v < OUTER) || self.is_in_body(&corners.map(|v| v - OUTER)) {
                return 0.0;
            }
            let corners = corners.map(|v| mesh.points[v]);
            let centre = circumcentre(corners);
            let sound = centre.iter().all(|c| c.is_finite()) && meridian.holds(&centre);
            if !sound || self.encroaches(&centre) {
                return 0.0;
            }
            // max takes zero for a NaN
            ((centre - corners[0]).norm() / size(&centre)).max(0.0)
        };
        let mut excesses: Vec<f64> = (0..mesh.triangles.len())
            .map(|t| excess(&mesh, t))
            .collect();
        let mut made = Vec::new();
        loop {
            let worst = (0..excesses.len()).max_by(|&a, &b| excesses[a].total_cmp(&excesses[b]));
            let Some(worst) = worst.filter(|&t| excesses[t] > WIDEST) else {
                return Ok(mesh.points[OUTER + self.points.len()..].to_vec());
            };
            let centre = circumcentre(mesh.triangles[worst].map(|v| mesh.points[v]));
            if mesh.insert(centre, &mut made).is_none() {
                excesses[worst] = 0.0;
                continue;
            }
            too_many(mesh.triangles.len())?;
            excesses.resize(mesh.triangles.len(), 0.0);
            for &t in &made {
                excesses[t] = excess(&mesh, t);
            }
        }
    }

    /// Moves inner points to the mean of the centres of their triangles, weighed by area in units of the size wanted.
    fn smooth(&self, inner: &[Point], size: &impl Fn(&Point) -> f64) -> Vec<Point> {
        let mesh = self.triangulate(inner);
        let first = OUTER + self.points.len();
        let mut sums = vec![(Point::zeros(), 0.0); inner.len()];
        for corners in &mesh.triangles {
            if corners.iter().any(|&v| v < OUTER) {
                continue;
            }
            let [a, b, c] = corners.map(|v| mesh.points[v]);
            let centre = (a + b + c) / 3.0;
            let wanted = size(&centre);
            let weight = (b - a).perp(&(c - a)) / (wanted * wanted);
            for &v in corners.iter().filter(|&&v| v >= first) {
                sums[v - first].0 += weight * centre;
                sums[v - first].1 += weight;
            }
        }
        inner
            .iter()
            .zip(sums)
            .map(|(old, (sum, weight))| {
                let new = sum / weight;
                let sound = new.iter().all(|c| c.is_finite()) && !self.encroaches(&new);
                if sound { new } else { *old }
            })
            .collect()
    }
}

impl Delaunay {
    /// The triangles in the domain, corners numbered without the outer three; `None` if an edge of the boundary is missing.
    fn filled(&self, rim: &Rim) -> Option<Vec<[usize; 3]>> {
        let inside = self
            .triangles
            .iter()
            .filter(|t| t.iter().all(|&v| v >= OUTER));
        let triangles: Vec<[usize; 3]> = inside
            .map(|t| t.map(|v| v - OUTER))
            .filter(|t| !rim.is_in_body(t))
            .collect();
        let mut met = vec![false; rim.points.len()];
        for t in &triangles {
            for e in 0..3 {
                let (a, b) = (t[e], t[(e + 1) % 3]);
                // seen from inside, the boundary runs as the triangle does
                if a < met.len() && rim.next(a) == b {
                    met[a] = true;
                }
            }
        }
        met.iter().all(|&m| m).then_some(triangles)
    }
}

fn too_many(found: usize) -> Result<(), AxisymmetricError> {
    if found <= MOST_TRIANGLES {
        return Ok(());
    }
    Err(AxisymmetricError::TooManyTriangles {
        found,
        limit: MOST_TRIANGLES,
    })
}
