//! The map from the reference triangle to a triangle of the mesh, which may bend along curves.

use nalgebra::{DMatrix, Matrix2};

use crate::AxisymmetricError;
use crate::element::{Lagrange, Table};
use crate::meridian::Point;
use crate::mesh::MeridianMesh;
use crate::rule::{RulePoint, triangle_rule};

/// A triangle's map at one quadrature point.
#[derive(Clone, Copy)]
pub(crate) struct MapPoint {
    /// Distance from the axis.
    pub radius: f64,
    /// $2 \pi r$ times area and quadrature weight.
    pub measure: f64,
    /// Rows: derivatives along the axis and away from it, by the gradients of [`Table`].
    pub inverse: Matrix2<f64>,
}

/// Whether an element bends, which asks for more quadrature points.
pub(crate) fn bends(mesh: &MeridianMesh, triangle: usize) -> bool {
    mesh.edges[triangle]
        .iter()
        .any(|&edge| mesh.boundary[edge].is_some_and(|b| b.curve.bends()))
}

/// Whether no bent element folds over; those of other orders than the one looked at differ from it by far less than they bend.
///
/// # Errors
/// None.
pub(crate) fn is_sound(mesh: &MeridianMesh) -> Result<bool, AxisymmetricError> {
    const ORDER: usize = 4;
    let element = Lagrange::new(ORDER)?;
    let rule = triangle_rule(2 * ORDER);
    let table = element.tabulate(&rule);
    let mut bent = (0..mesh.triangles.len()).filter(|&t| bends(mesh, t));
    Ok(bent.all(|t| map_points(t, &node_places(mesh, t, &element), &table, &rule).is_ok()))
}

/// Where the nodes of an element are: on the straight triangle, moved by what its edges bend, which fades out inwards.
///
/// With `s` the place along an edge from corner `a` to `b` and $d(s)$ the way from its chord to its curve, a node moves by
/// $\lambda_a \lambda_b / (s (1 - s))\, d(s)$, $s = (1 + \lambda_b - \lambda_a) / 2$ (Szabo & Babuska 1991, 6.1). Nodal interpolation of this
/// map has the derivatives that optimal convergence asks for (Lenoir 1986).
pub(crate) fn node_places(mesh: &MeridianMesh, triangle: usize, element: &Lagrange) -> Vec<Point> {
    let numbers = mesh.triangles[triangle];
    let corners = numbers.map(|v| mesh.points[v]);
    let mut places: Vec<Point> = element
        .nodes
        .iter()
        .map(|l| corners[0] * l[0] + corners[1] * l[1] + corners[2] * l[2])
        .collect();
    for (e, &edge) in mesh.edges[triangle].iter().enumerate() {
        let Some(boundary) = mesh.boundary[edge].filter(|b| b.curve.bends()) else {
            continue;
        };
        let (a, b) = (e, (e + 1) % 3);
        let forward = mesh.ends[edge][0] == numbers[a];
        for (place, l) in places.iter_mut().zip(&element.nodes) {
            let s = 0.5 * (1.0 + l[b] - l[a]);
            // corners stay
            if s * (1.0 - s) < 1e-12 {
                continue;
            }
            let on_curve = boundary.point(if forward { s } else { 1.0 - s });
            let on_chord = corners[a] * (1.0 - s) + corners[b] * s;
            *place += (on_curve - on_chord) * (l[a] * l[b] / (s * (1.0 - s)));
        }
    }
    places
}

/// The map at all points of a rule.
///
/// # Errors
/// [`AxisymmetricError::InvertedTriangle`] where it folds over or leaves the half-plane.
pub(crate) fn map_points(
    triangle: usize,
    places: &[Point],
    table: &Table,
    rule: &[RulePoint],
) -> Result<Vec<MapPoint>, AxisymmetricError> {
    let coordinates = DMatrix::from_fn(2, places.len(), |d, i| places[i][d]);
    let at = &coordinates * &table.values;
    let by = table.gradients.each_ref().map(|g| &coordinates * g);
    rule.iter()
        .enumerate()
        .map(|(q, point)| {
            // columns: derivatives of the place by the two reference coordinates
            let jacobian = Matrix2::new(by[0][(0, q)], by[1][(0, q)], by[0][(1, q)], by[1][(1, q)]);
            let (determinant, radius) = (jacobian.determinant(), at[(1, q)]);
            match jacobian.try_inverse() {
                Some(inverse) if determinant > 0.0 && radius > 0.0 => Ok(MapPoint {
                    radius,
                    measure: 2.0 * std::f64::consts::PI * radius * determinant * point.weight,
                    inverse: inverse.transpose(),
                }),
                _ => Err(AxisymmetricError::InvertedTriangle {
                    triangle,
                    at: [at[(0, q)], radius],
                    jacobian: determinant,
                }),
            }
        })
        .collect()
}
