//! The geometry map from the reference triangle to a triangle of the mesh with curved edges.

use nalgebra::{DMatrix, Matrix2};

use crate::AxisymmetricError;
use crate::curve::Point;
use crate::element::{Lagrange, Table};
use crate::mesh::MeridianMesh;
use crate::quadrature::{RulePoint, triangle_rule};

/// The geometry map of a triangle at one quadrature point.
#[derive(Clone, Copy)]
pub(crate) struct MapPoint {
    /// Position along the axis.
    pub axial: f64,
    /// Distance from the axis.
    pub radius: f64,
    /// Volume weight: `2 π r` times the Jacobian determinant and the quadrature weight.
    pub measure: f64,
    /// Transposed inverse of the Jacobian: maps the gradients of [`Table`] to derivatives along the
    /// axis (first row) and away from it (second row).
    pub inverse: Matrix2<f64>,
}

impl MapPoint {
    /// The map at a point of a triangle from the position and its derivatives with respect to the
    /// two reference coordinates.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`] if the Jacobian is not positive or the point is off
    /// the open half-plane.
    pub fn new(
        triangle: usize,
        at: Point,
        by: [Point; 2],
        point: &RulePoint,
    ) -> Result<Self, AxisymmetricError> {
        let determinant = by[0].perp(&by[1]);
        if !(determinant > 0.0 && at.y > 0.0) {
            return Err(AxisymmetricError::InvertedTriangle {
                triangle,
                at: [at.x, at.y],
                jacobian: determinant,
            });
        }
        Ok(Self {
            axial: at.x,
            radius: at.y,
            measure: 2.0 * std::f64::consts::PI * at.y * determinant * point.weight,
            inverse: Matrix2::new(by[1].y, -by[0].y, -by[1].x, by[0].x) / determinant,
        })
    }

    /// Derivatives along the axis and away from it of a value with these reference derivatives.
    pub fn derivatives(&self, by: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|d| self.inverse[(d, 0)] * by[0] + self.inverse[(d, 1)] * by[1])
    }
}

/// Whether the Jacobian is positive in all curved elements, checked with geometry of order four.
///
/// Geometries of other orders differ from this one much less than from the straight triangle.
///
/// # Errors
/// [`AxisymmetricError::NoNodalBasis`], which does not happen for this order.
pub(crate) fn is_valid(mesh: &MeridianMesh) -> Result<bool, AxisymmetricError> {
    const ORDER: usize = 4;
    let element = Lagrange::new(ORDER)?;
    let rule = triangle_rule(2 * ORDER);
    let table = element.tabulate(&rule);
    let mut curved = (0..mesh.triangles.len()).filter(|&t| mesh.is_curved(t));
    Ok(curved.all(|t| map_points(t, &node_positions(mesh, t, &element), &table, &rule).is_ok()))
}

/// Positions of an element's nodes by blending.
///
/// The curved edges displace the nodes of the straight triangle by amounts that decay towards the
/// interior.
///
/// For an edge from corner `a` to corner `b`, let `d(s)` be the vector from chord to curve at the
/// fraction `s = (1 + λ_b - λ_a) / 2` of the edge. A node is displaced by
/// `λ_a λ_b / (s (1 - s)) d(s)` (Szabo & Babuska 1991, 6.1). The nodal interpolant of this map has
/// the derivative bounds needed for optimal convergence (Lenoir 1986).
pub(crate) fn node_positions(
    mesh: &MeridianMesh,
    triangle: usize,
    element: &Lagrange,
) -> Vec<Point> {
    let numbers = mesh.triangles[triangle];
    let corners = numbers.map(|v| mesh.points[v]);
    let mut positions: Vec<Point> = element
        .nodes
        .iter()
        .map(|l| corners[0] * l[0] + corners[1] * l[1] + corners[2] * l[2])
        .collect();
    for (e, &edge) in mesh.edges[triangle].iter().enumerate() {
        let Some(boundary) = mesh.boundary[edge].filter(|b| b.curve.is_curved()) else {
            continue;
        };
        let (a, b) = (e, (e + 1) % 3);
        let forward = mesh.ends[edge][0] == numbers[a];
        for (position, l) in positions.iter_mut().zip(&element.nodes) {
            let s = 0.5 * (1.0 + l[b] - l[a]);
            // corners are not displaced
            if s * (1.0 - s) < 1e-12 {
                continue;
            }
            let on_curve = boundary.point(if forward { s } else { 1.0 - s });
            let on_chord = corners[a] * (1.0 - s) + corners[b] * s;
            *position += (on_curve - on_chord) * (l[a] * l[b] / (s * (1.0 - s)));
        }
    }
    positions
}

/// The geometry map of a triangle at all points of a rule.
///
/// # Errors
/// [`AxisymmetricError::InvertedTriangle`] if the Jacobian is not positive or a point is off the
/// open half-plane.
pub(crate) fn map_points(
    triangle: usize,
    positions: &[Point],
    table: &Table,
    rule: &[RulePoint],
) -> Result<Vec<MapPoint>, AxisymmetricError> {
    let coordinates = DMatrix::from_fn(2, positions.len(), |d, i| positions[i][d]);
    let at = &coordinates * &table.values;
    let by = table.gradients.each_ref().map(|g| &coordinates * g);
    rule.iter()
        .enumerate()
        .map(|(q, point)| {
            let column = |values: &DMatrix<f64>| Point::new(values[(0, q)], values[(1, q)]);
            MapPoint::new(triangle, column(&at), [0, 1].map(|k| column(&by[k])), point)
        })
        .collect()
}
