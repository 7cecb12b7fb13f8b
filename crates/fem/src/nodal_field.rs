//! Nodal fields: interpolation of functions, and values at points.

use mesh::{PointLocator, TetMesh, Vec3};
use rayon::prelude::*;

use crate::FemError;
use crate::error::{check_finite_in_cell, check_length};
use crate::geometry::MapAt;
use crate::point_values::{Lagrange, PointValues, Space};
use crate::quadrature::CellPoint;
use crate::quantity::{Nodal, Quantity, is_finite};

/// Nodal values of the interpolant of a function: `N = 10` quadratic, one value per point of the
/// mesh; `N = 4` linear, one value per vertex.
///
/// ```
/// use mesh::{LinearTets, TetMesh};
/// let mesh = TetMesh::straight(LinearTets::cube(1))?;
/// let temperature = fem::interpolate::<_, 10>(&mesh, |x| x.x * x.y)?;
/// assert_eq!(temperature.len(), mesh.n_points());
/// assert_eq!(fem::interpolate::<_, 4>(&mesh, |x| x)?.len(), mesh.n_vertices());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`FemError::NotFinite`] with the number of the node.
pub fn interpolate<T: Nodal, const N: usize>(
    mesh: &TetMesh,
    function: impl Fn(Vec3) -> T,
) -> Result<Vec<T>, FemError>
where
    Lagrange<N>: Space<N>,
{
    let points = &mesh.points()[..<Lagrange<N> as Space<N>>::n_nodes(mesh)];
    let values: Vec<T> = points.iter().map(|&x| function(x)).collect();
    let what = "the interpolated function";
    check_field(what, &values)?;
    Ok(values)
}

/// Values and gradients `∂u_c/∂x_k` of a nodal field at points.
///
/// Shape: `field` `n_points` (quadratic) or `n_vertices` (linear). Points outside by less than a
/// fiftieth of a cell belong to it, as for [`PointLocator`]. Cost: a hierarchy of boxes, about a
/// microsecond per cell, and a few microseconds per point, in parallel.
///
/// ```
/// use mesh::{LinearTets, TetMesh, Vec3};
/// let mesh = TetMesh::straight(LinearTets::cube(2))?;
/// let field = fem::interpolate::<_, 10>(&mesh, |x| x.x * x.y)?;
/// let (value, gradient) = fem::evaluate(&mesh, &field, &[Vec3::new(0.3, 0.7, 0.2)])?[0];
/// assert!((value - 0.21).abs() < 1e-12);
/// assert!((gradient - Vec3::new(0.7, 0.3, 0.0)).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// A field of another length or not finite, or so large that it overflows;
/// [`FemError::OutsideMesh`]; [`FemError::InvertedCell`].
pub fn evaluate<T: Nodal>(
    mesh: &TetMesh,
    field: &[T],
    points: &[Vec3],
) -> Result<Vec<(T, T::Gradient)>, FemError> {
    check_nodal(mesh, "the field", field)?;
    let locator = PointLocator::new(mesh);
    let value = |(index, x): (usize, &Vec3)| {
        let at = (*x).into();
        let outside = FemError::OutsideMesh { index, at };
        let found = locator.locate(x).ok_or(outside)?;
        let (positions, point) = (
            mesh.cell_points(found.cell),
            CellPoint::new(found.barycentric, 1.0),
        );
        let map = MapAt::new(found.cell, &positions, &point)?;
        let at = PointValues::new(mesh, found.cell, &positions, &point, map);
        let (value, gradient) = (at.value(field), at.gradient(field));
        check_finite_in_cell("the field", found.cell, &positions, [&value])?;
        check_finite_in_cell("the gradient", found.cell, &positions, [&gradient])?;
        Ok((value, gradient))
    };
    let values: Vec<_> = points.par_iter().enumerate().map(value).collect();
    values.into_iter().collect()
}

/// Gradients `∂u_c/∂x_k` of a nodal field at the vertices, means over their cells weighted by
/// volume.
///
/// Those of quadratic fields are of second order, also on the boundary.
///
/// ```
/// use mesh::{LinearTets, TetMesh, Vec3};
/// let mesh = TetMesh::straight(LinearTets::cube(2))?;
/// let field = fem::interpolate::<_, 10>(&mesh, |x| x.x * x.y)?;
/// let gradients = fem::vertex_gradients(&mesh, &field)?;
/// for (gradient, x) in gradients.iter().zip(mesh.points()) {
///     assert!((gradient - Vec3::new(x.y, x.x, 0.0)).norm() < 1e-12);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// A field of another length or not finite; [`FemError::InvertedCell`].
pub fn vertex_gradients<T: Nodal>(
    mesh: &TetMesh,
    field: &[T],
) -> Result<Vec<T::Gradient>, FemError> {
    check_nodal(mesh, "the field", field)?;
    let at_vertex = |vertex: usize| {
        let mut barycentric = [0.0; 4];
        barycentric[vertex] = 1.0;
        CellPoint::new(barycentric, 1.0)
    };
    let points = [0, 1, 2, 3].map(at_vertex);
    let mut sums = vec![T::Gradient::zero(); mesh.n_vertices()];
    let mut volumes = vec![0.0; mesh.n_vertices()];
    for (cell, nodes) in mesh.cells().iter().enumerate() {
        let positions = mesh.cell_points(cell);
        for (node, point) in nodes.iter().zip(&points) {
            let map = MapAt::new(cell, &positions, point)?;
            let at = PointValues::new(mesh, cell, &positions, point, map);
            sums[*node as usize].add_scaled(at.weight, &at.gradient(field));
            volumes[*node as usize] += at.weight;
        }
    }
    let means = sums.iter().zip(volumes).map(|(sum, volume)| {
        let mut mean = T::Gradient::zero();
        mean.add_scaled(1.0 / volume, sum);
        mean
    });
    let means: Vec<T::Gradient> = means.collect();
    match means.iter().position(|mean| !is_finite([mean])) {
        Some(index) => Err(FemError::NotFinite {
            what: "the gradient at a vertex",
            index,
        }),
        None => Ok(means),
    }
}

/// Checks that a field has one finite value per point or per vertex.
pub(crate) fn check_nodal<T: Nodal>(
    mesh: &TetMesh,
    what: &'static str,
    field: &[T],
) -> Result<(), FemError> {
    if field.len() != mesh.n_vertices() {
        check_length(what, field.len(), mesh.n_points())?;
    }
    check_field(what, field)
}

fn check_field<T: Nodal>(what: &'static str, field: &[T]) -> Result<(), FemError> {
    match field.iter().position(|value| !is_finite([value])) {
        Some(index) => Err(FemError::NotFinite { what, index }),
        None => Ok(()),
    }
}
