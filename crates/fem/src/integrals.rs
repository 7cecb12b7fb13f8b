//! Integrals over cells and boundary facets, and load vectors.

use mesh::{TetMesh, Vec3};

use crate::FemError;
use crate::error::check_finite_in_cell;
use crate::geometry::MapAt;
use crate::point_values::{FacetValues, Lagrange, PointValues, Space, for_each_facet_point};
use crate::quadrature::{CellPoint, cell_rule, degree_6, facet_rule};
use crate::quantity::Quantity;
use crate::sum::{accumulate_items, sum_over};
use crate::surface::tagged_facets;

/// Integral of a function over the fluid, given at the quadrature points without the weight.
///
/// The result is a number, a vector or a matrix, or an array of several integrals. `degree` is that
/// of [`TaylorHood::assemble`](crate::TaylorHood::assemble). Bitwise the same for any number of
/// threads.
///
/// ```
/// use mesh::{LinearTets, TetMesh};
/// let mesh = TetMesh::straight(LinearTets::cube(2))?;
/// // The volume and ∫ x y over the unit cube.
/// let integrals = fem::integrate(&mesh, 2, |point| {
///     let x = point.position();
///     [1.0, x.x * x.y]
/// })?;
/// assert!((integrals[0] - 1.0).abs() < 1e-14 && (integrals[1] - 0.25).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`FemError::Degree`]; [`FemError::NotFiniteInCell`]; [`FemError::InvertedCell`].
pub fn integrate<T: Quantity>(
    mesh: &TetMesh,
    degree: usize,
    integrand: impl Fn(&PointValues<'_>) -> T + Sync,
) -> Result<T, FemError> {
    let rule = cell_rule(degree)?;
    sum_points(
        mesh,
        |_| rule,
        |point| {
            let mut weighted = T::zero();
            weighted.add_scaled(point.weight, &integrand(point));
            weighted
        },
    )
}

/// Integral of a function over the boundary facets with `tag`, given without the weight.
///
/// ```
/// use mesh::{LinearTets, TetMesh};
/// let mesh = TetMesh::straight(LinearTets::cube(2))?;
/// // The flux of the field x through the side x = 1 of the unit cube, with the normal outwards.
/// let flux = fem::integrate_facets(&mesh, mesh.tag("x1")?, 1, |facet| {
///     facet.point.position().dot(&facet.normal)
/// })?;
/// assert!((flux - 1.0).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`FemError::EmptyTag`], and those of [`integrate`].
pub fn integrate_facets<T: Quantity>(
    mesh: &TetMesh,
    tag: u16,
    degree: usize,
    integrand: impl Fn(&FacetValues<'_>) -> T + Sync,
) -> Result<T, FemError> {
    let (rule, facets) = (facet_rule(degree)?, tagged_facets(mesh, tag)?);
    sum_over(facets.len(), |k| {
        let mut sum = T::zero();
        for_each_facet_point(mesh, facets[k], rule, |at| {
            sum.add_scaled(at.point.weight, &integrand(at));
        })?;
        let cell = facets[k].cell as usize;
        check_finite_in_cell("the integrand", cell, &mesh.cell_points(cell), [&sum])?;
        Ok(sum)
    })
}

/// Load vector of a linear form, given by its integrand at the quadrature points.
///
/// `form(point, load)` adds weight times integrand to the element vector, by
/// [`PointValues::add_load`] or entry by entry. The length of the element vector `[T; N]` chooses
/// the test functions: 10 quadratic or 4 linear ones. The result has one entry of type `T` (a
/// number, a vector) per point or per vertex.
///
/// ```
/// use mesh::{LinearTets, TetMesh};
/// let mesh = TetMesh::straight(LinearTets::cube(2))?;
/// // ∫ x v for linear v, which sum to one: ∫ x = 1/2.
/// let load = fem::assemble_load(&mesh, 2, |point, load: &mut [f64; 4]| {
///     let x = point.position().x;
///     point.add_load(load, |v| x * v.value);
/// })?;
/// assert_eq!(load.len(), mesh.n_vertices());
/// assert!((load.iter().sum::<f64>() - 0.5).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Those of [`integrate`].
pub fn assemble_load<T: Quantity, const N: usize>(
    mesh: &TetMesh,
    degree: usize,
    form: impl Fn(&PointValues<'_>, &mut [T; N]) + Sync,
) -> Result<Vec<T>, FemError>
where
    Lagrange<N>: Space<N>,
{
    load_by_rule(mesh, cell_rule(degree)?, form)
}

/// Load vector of a linear form on the boundary facets with `tag`, such as a Neumann condition.
///
/// The arguments and the result are those of [`assemble_load`]; the entries of nodes away from the
/// facets are zero, unless the form has gradients of test functions.
///
/// # Errors
/// [`FemError::EmptyTag`], and those of [`integrate`].
pub fn assemble_facet_load<T: Quantity, const N: usize>(
    mesh: &TetMesh,
    tag: u16,
    degree: usize,
    form: impl Fn(&FacetValues<'_>, &mut [T; N]) + Sync,
) -> Result<Vec<T>, FemError>
where
    Lagrange<N>: Space<N>,
{
    let (rule, facets) = (facet_rule(degree)?, tagged_facets(mesh, tag)?);
    let cells = facets.iter().map(|facet| facet.cell as usize).collect();
    accumulate_loads(mesh, cells, |k, load| {
        for_each_facet_point(mesh, facets[k], rule, |at| form(at, load))
    })
}

/// Load vector `f_i = ∫ f N_i` of a body force on the quadratic elements.
///
/// `force` returns the force per volume at a position, a number or a vector. Quadrature: 24 points
/// per cell, degree 6, so a force of degree 4 is integrated exactly on affine cells. Shape of the
/// result: `n_points`. Bitwise the same for any number of threads.
///
/// # Errors
/// A force that is not finite; [`FemError::InvertedCell`].
pub fn load_vector<T: Quantity>(
    mesh: &TetMesh,
    force: impl Fn(Vec3) -> T + Sync,
) -> Result<Vec<T>, FemError> {
    load_by_rule(mesh, degree_6(), |point, load: &mut [T; 10]| {
        let mut weighted = T::zero();
        weighted.add_scaled(point.weight, &force(point.position()));
        for (value, &shape) in load.iter_mut().zip(point.quadratic()) {
            value.add_scaled(shape, &weighted);
        }
    })
}

/// Load vector of a form with a given rule.
fn load_by_rule<T: Quantity, const N: usize>(
    mesh: &TetMesh,
    rule: &[CellPoint],
    form: impl Fn(&PointValues<'_>, &mut [T; N]) + Sync,
) -> Result<Vec<T>, FemError>
where
    Lagrange<N>: Space<N>,
{
    accumulate_loads(mesh, (0..mesh.n_cells()).collect(), |cell, load| {
        for_each_point(mesh, cell, rule, |point| form(point, load))
    })
}

/// Adds the element vectors that `compute(k)` adds for cell `cells[k]`, in ascending order.
fn accumulate_loads<T: Quantity, const N: usize>(
    mesh: &TetMesh,
    cells: Vec<usize>,
    compute: impl Fn(usize, &mut [T; N]) -> Result<(), FemError> + Sync,
) -> Result<Vec<T>, FemError>
where
    Lagrange<N>: Space<N>,
{
    let mut loads = vec![T::zero(); <Lagrange<N> as Space<N>>::n_nodes(mesh)];
    let cell_load = |k: usize| {
        let mut load = [T::zero(); N];
        compute(k, &mut load)?;
        check_finite_in_cell("the load", cells[k], &mesh.cell_points(cells[k]), &load)?;
        Ok(load)
    };
    accumulate_items(cells.len(), cell_load, |k, load| {
        for (&node, value) in mesh.cells()[cells[k]].iter().zip(&load) {
            loads[node as usize].add_scaled(1.0, value);
        }
    })?;
    Ok(loads)
}

/// Sum of `term` over the quadrature points of all cells; cells with an empty rule are left out.
pub(crate) fn sum_points<T: Quantity>(
    mesh: &TetMesh,
    rule: impl Fn(usize) -> &'static [CellPoint] + Sync,
    term: impl Fn(&PointValues<'_>) -> T + Sync,
) -> Result<T, FemError> {
    sum_over(mesh.n_cells(), |cell| {
        let mut sum = T::zero();
        for_each_point(mesh, cell, rule(cell), |point| {
            sum.add_scaled(1.0, &term(point));
        })?;
        check_finite_in_cell("the integrand", cell, &mesh.cell_points(cell), [&sum])?;
        Ok(sum)
    })
}

/// Calls `f` at the points of a rule in a cell.
#[inline(always)]
fn for_each_point(
    mesh: &TetMesh,
    cell: usize,
    rule: &[CellPoint],
    mut f: impl FnMut(&PointValues<'_>),
) -> Result<(), FemError> {
    let positions = mesh.cell_points(cell);
    for point in rule {
        let map = MapAt::new(cell, &positions, point)?;
        f(&PointValues::new(mesh, cell, &positions, point, map));
    }
    Ok(())
}
