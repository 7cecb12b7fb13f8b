//! Generation of graded triangle meshes by Delaunay refinement.

use crate::AxisymmetricError;
use crate::curve::Point;
use crate::delaunay::{Delaunay, OUTER_CORNERS, circumcentre};
use crate::geometry_map::is_valid;
use crate::meridian::Meridian;
use crate::mesh::{BoundaryPolygon, MeridianMesh, check_triangle_count};

/// Circumradius relative to the target edge length above which a triangle is refined.
///
/// It is 0.58 for the equilateral triangle.
const MAX_CIRCUMRADIUS: f64 = 0.75;

/// Number of smoothing sweeps; more change the mesh little.
const SWEEPS: usize = 4;

/// Number of attempts, each with elements smaller by a quarter.
const ATTEMPTS: i32 = 6;

/// Triangulates `meridian`.
///
/// Far from the bodies, edges are about `growth` times as long as their distance from the focus of
/// the nearest body.
///
/// # Errors
/// [`AxisymmetricError::MeshFailed`] or [`AxisymmetricError::TooManyTriangles`].
pub(crate) fn generate(
    meridian: &Meridian,
    growth: f64,
) -> Result<MeridianMesh, AxisymmetricError> {
    (0..ATTEMPTS)
        .find_map(|k| attempt(meridian, growth * 0.75_f64.powi(k)).transpose())
        .unwrap_or(Err(AxisymmetricError::MeshFailed))
}

/// One attempt: `None` if a boundary edge is missing or a curved edge inverts its triangle.
fn attempt(meridian: &Meridian, growth: f64) -> Result<Option<MeridianMesh>, AxisymmetricError> {
    let size = |x: &Point| meridian.size(x, growth);
    let polygon = BoundaryPolygon::divide(meridian, &size)?;
    let mut inner = refine(&polygon, meridian, &size)?;
    for _ in 0..SWEEPS {
        inner = smooth(&polygon, &inner, &size);
    }
    let Some(mut triangles) = domain_triangles(&triangulate(&polygon, &inner), &polygon) else {
        return Ok(None);
    };
    let mut points = polygon.points.clone();
    points.extend(inner);
    // a triangle with two edges on one smooth curve would be flat at their common corner
    for t in 0..triangles.len() {
        let corners = triangles[t];
        let off_axis = (0..3).filter(|&e| polygon.is_off_axis(corners[e], corners[(e + 1) % 3]));
        if off_axis.count() < 2 {
            continue;
        }
        let [a, b, c] = corners;
        let middle = points.len();
        points.push((points[a] + points[b] + points[c]) / 3.0);
        triangles[t] = [a, b, middle];
        triangles.extend([[b, c, middle], [c, a, middle]]);
    }
    let mesh = MeridianMesh::connect(points, triangles, &polygon);
    Ok(is_valid(&mesh)?.then_some(mesh))
}

/// The Delaunay triangulation of the outer triangle, the boundary points and the inner points.
fn triangulate(polygon: &BoundaryPolygon, inner: &[Point]) -> Delaunay {
    let mut mesh = Delaunay::around(polygon.centre, polygon.radius);
    let mut created = Vec::new();
    for x in polygon.points.iter().chain(inner) {
        mesh.insert(*x, &mut created);
    }
    mesh
}

/// Inner points: circumcentres of triangles that are too large, the worst first (Chew 1989).
///
/// Circumcentres that encroach on the boundary are not inserted.
fn refine(
    polygon: &BoundaryPolygon,
    meridian: &Meridian,
    size: &impl Fn(&Point) -> f64,
) -> Result<Vec<Point>, AxisymmetricError> {
    let mut mesh = triangulate(polygon, &[]);
    // circumradius over the target size; zero for triangles that must not be refined
    let excess = |mesh: &Delaunay, t: usize| -> f64 {
        let corners = mesh.triangles[t];
        if corners.iter().any(|&v| v < OUTER_CORNERS)
            || polygon.is_in_body(&corners.map(|v| v - OUTER_CORNERS))
        {
            return 0.0;
        }
        let corners = corners.map(|v| mesh.points[v]);
        let centre = circumcentre(corners);
        let inside = centre.iter().all(|c| c.is_finite()) && meridian.contains(&centre);
        if !inside || polygon.is_encroached_by(&centre) {
            return 0.0;
        }
        // f64::max replaces NaN by zero
        ((centre - corners[0]).norm() / size(&centre)).max(0.0)
    };
    let mut excesses: Vec<f64> = (0..mesh.triangles.len())
        .map(|t| excess(&mesh, t))
        .collect();
    let mut created = Vec::new();
    loop {
        let worst = (0..excesses.len()).max_by(|&a, &b| excesses[a].total_cmp(&excesses[b]));
        let Some(worst) = worst.filter(|&t| excesses[t] > MAX_CIRCUMRADIUS) else {
            return Ok(mesh.points[OUTER_CORNERS + polygon.points.len()..].to_vec());
        };
        let centre = circumcentre(mesh.triangles[worst].map(|v| mesh.points[v]));
        if mesh.insert(centre, &mut created).is_none() {
            excesses[worst] = 0.0;
            continue;
        }
        check_triangle_count(mesh.triangles.len())?;
        excesses.resize(mesh.triangles.len(), 0.0);
        for &t in &created {
            excesses[t] = excess(&mesh, t);
        }
    }
}

/// Inner points moved to the weighted mean of the centroids of their triangles.
///
/// The weight is the triangle's area in units of the square of the target size.
fn smooth(polygon: &BoundaryPolygon, inner: &[Point], size: &impl Fn(&Point) -> f64) -> Vec<Point> {
    let mesh = triangulate(polygon, inner);
    let first = OUTER_CORNERS + polygon.points.len();
    let mut sums = vec![(Point::zeros(), 0.0); inner.len()];
    for corners in &mesh.triangles {
        if corners.iter().any(|&v| v < OUTER_CORNERS) {
            continue;
        }
        let [a, b, c] = corners.map(|v| mesh.points[v]);
        let centre = (a + b + c) / 3.0;
        let target = size(&centre);
        let weight = (b - a).perp(&(c - a)) / (target * target);
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
            let valid = new.iter().all(|c| c.is_finite()) && !polygon.is_encroached_by(&new);
            if valid { new } else { *old }
        })
        .collect()
}

/// The triangles of the domain, with corners numbered without the outer three points.
///
/// `None` if an edge of the boundary is missing.
fn domain_triangles(mesh: &Delaunay, polygon: &BoundaryPolygon) -> Option<Vec<[usize; 3]>> {
    let inside = mesh
        .triangles
        .iter()
        .filter(|t| t.iter().all(|&v| v >= OUTER_CORNERS));
    let triangles: Vec<[usize; 3]> = inside
        .map(|t| t.map(|v| v - OUTER_CORNERS))
        .filter(|t| !polygon.is_in_body(t))
        .collect();
    let mut found = vec![false; polygon.points.len()];
    for t in &triangles {
        for e in 0..3 {
            let (a, b) = (t[e], t[(e + 1) % 3]);
            // boundary and triangles have the same orientation
            if a < found.len() && polygon.next(a) == b {
                found[a] = true;
            }
        }
    }
    found.iter().all(|&f| f).then_some(triangles)
}
