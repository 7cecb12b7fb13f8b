//! What a weak form knows at a quadrature point of a cell or a boundary facet.

use mesh::{Facet, TetMesh, Vec3};

use crate::FemError;
use crate::geometry::{CellNodes, MapAt};
use crate::quadrature::{CellPoint, FacetPoint};
use crate::quantity::{Nodal, Quantity, gradient_in_cell};
use crate::surface::{facet_cell_point, facet_nodes, position_and_normal};

/// Lagrange functions of a tetrahedron with `N` nodes: 4 linear or 10 quadratic ones.
pub struct Lagrange<const N: usize>;

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Lagrange<4> {}
    impl Sealed for super::Lagrange<10> {}
}

/// The spaces that [`TaylorHood`](crate::TaylorHood) has: `Lagrange<4>` and `Lagrange<10>`.
pub trait Space<const N: usize>: sealed::Sealed {
    /// Number of nodes of a mesh: vertices (linear) or points (quadratic).
    fn n_nodes(mesh: &TetMesh) -> usize;

    /// Values of the functions of a cell.
    fn values<'a>(point: &PointValues<'a>) -> &'a [f64; N];

    /// Physical gradients of the functions of a cell.
    fn gradients(point: &PointValues<'_>) -> [Vec3; N];
}

impl Space<4> for Lagrange<4> {
    fn n_nodes(mesh: &TetMesh) -> usize {
        mesh.n_vertices()
    }

    #[inline]
    fn values<'a>(point: &PointValues<'a>) -> &'a [f64; 4] {
        point.linear()
    }

    #[inline]
    fn gradients(point: &PointValues<'_>) -> [Vec3; 4] {
        point.linear_gradients()
    }
}

impl Space<10> for Lagrange<10> {
    fn n_nodes(mesh: &TetMesh) -> usize {
        mesh.n_points()
    }

    #[inline]
    fn values<'a>(point: &PointValues<'a>) -> &'a [f64; 10] {
        point.quadratic()
    }

    #[inline]
    fn gradients(point: &PointValues<'_>) -> [Vec3; 10] {
        point.quadratic_gradients()
    }
}

/// Value and physical gradient of a test or trial function at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Basis {
    /// Value.
    pub value: f64,
    /// Gradient.
    pub gradient: Vec3,
}

/// Weight and shape functions at a quadrature point of a cell, for weak forms.
///
/// The nodes have the order of the mesh: four vertices, then the midside nodes of
/// [`mesh::TET_EDGES`].
pub struct PointValues<'a> {
    /// Number of the cell.
    pub cell: usize,
    /// Quadrature weight times the Jacobian determinant (on a facet: times the surface element).
    pub weight: f64,
    mesh: &'a TetMesh,
    nodes: &'a [u32; 10],
    positions: &'a CellNodes,
    point: &'a CellPoint,
    map: MapAt,
}

impl<'a> PointValues<'a> {
    #[inline(always)]
    pub(crate) fn new(
        mesh: &'a TetMesh,
        cell: usize,
        positions: &'a CellNodes,
        point: &'a CellPoint,
        map: MapAt,
    ) -> Self {
        Self {
            cell,
            weight: map.measure,
            mesh,
            nodes: &mesh.cells()[cell],
            positions,
            point,
            map,
        }
    }

    /// Values of the ten quadratic (P2) functions.
    #[inline(always)]
    pub fn quadratic(&self) -> &'a [f64; 10] {
        &self.point.shape
    }

    /// Physical gradients of the ten quadratic functions. Cost: 90 multiplications.
    #[inline(always)]
    pub fn quadratic_gradients(&self) -> [Vec3; 10] {
        self.map.gradients(self.point)
    }

    /// Values of the four linear (P1) functions, which are the barycentric coordinates.
    #[inline(always)]
    pub fn linear(&self) -> &'a [f64; 4] {
        &self.point.barycentric
    }

    /// Physical gradients of the four linear functions.
    #[inline(always)]
    pub fn linear_gradients(&self) -> [Vec3; 4] {
        self.map.vertex_gradients()
    }

    /// Position of the point.
    #[inline(always)]
    pub fn position(&self) -> Vec3 {
        let terms = self.positions.iter().zip(self.quadratic());
        terms.map(|(x, &value)| x * value).sum()
    }

    /// Region of the cell, an index into [`mesh::Regions::names`]; none if no region is named.
    pub fn region(&self) -> Option<u16> {
        self.mesh.regions().of_cells.get(self.cell).copied()
    }

    /// Value of a field with one nodal value per point (quadratic) or per vertex (linear).
    ///
    /// The length of `nodal` tells which; for any other length the value is NaN, which integrals
    /// and matrices refuse as an error.
    #[inline(always)]
    pub fn value<T: Nodal>(&self, nodal: &[T]) -> T {
        let mut sum = T::zero();
        self.add_value(nodal, &mut sum);
        sum
    }

    /// Adds the value of a field to `sum`.
    #[inline(always)]
    pub(crate) fn add_value<T: Nodal>(&self, nodal: &[T], sum: &mut T) {
        let mut add = |values: &[f64]| {
            for (&node, &value) in self.nodes.iter().zip(values) {
                sum.add_scaled(value, &nodal[node as usize]);
            }
        };
        match nodal.len() {
            n if n == self.mesh.n_points() => add(self.quadratic()),
            n if n == self.mesh.n_vertices() => add(self.linear()),
            _ => *sum = T::from_components(|_| f64::NAN),
        }
    }

    /// Physical gradient `∂u_c/∂x_k` of a field, as [`PointValues::value`] takes it.
    #[inline(always)]
    pub fn gradient<T: Nodal>(&self, nodal: &[T]) -> T::Gradient {
        let nodes = self.nodes;
        match nodal.len() {
            n if n == self.mesh.n_points() => {
                gradient_in_cell(nodes, nodal, &self.quadratic_gradients())
            }
            n if n == self.mesh.n_vertices() => {
                gradient_in_cell(&nodes[..4], nodal, &self.linear_gradients())
            }
            _ => {
                let mut sum = T::Gradient::zero();
                T::from_components(|_| f64::NAN).add_gradient(&Vec3::repeat(1.0), &mut sum);
                sum
            }
        }
    }

    /// Adds `weight * integrand(v_i, u_j)` to every entry `(i, j)` of an element matrix.
    ///
    /// `v_i` are the test functions (rows) and `u_j` the trial functions (columns): the ten
    /// quadratic or the four linear functions of the cell, by the shape of the matrix.
    #[inline(always)]
    pub fn add<E: Quantity, const R: usize, const C: usize>(
        &self,
        matrix: &mut [[E; C]; R],
        integrand: impl Fn(&Basis, &Basis) -> E,
    ) where
        Lagrange<R>: Space<R>,
        Lagrange<C>: Space<C>,
    {
        let (test, trial) = (self.basis::<R>(), self.basis::<C>());
        for (i, row) in matrix.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                entry.add_scaled(self.weight, &integrand(&test(i), &trial(j)));
            }
        }
    }

    /// Adds `weight * integrand(v_i)` to every entry of an element vector, for the test functions
    /// `v_i`.
    #[inline(always)]
    pub fn add_load<T: Quantity, const N: usize>(
        &self,
        load: &mut [T; N],
        integrand: impl Fn(&Basis) -> T,
    ) where
        Lagrange<N>: Space<N>,
    {
        let test = self.basis::<N>();
        for (i, entry) in load.iter_mut().enumerate() {
            entry.add_scaled(self.weight, &integrand(&test(i)));
        }
    }

    /// The functions of the cell by number, in two arrays: one that is not used costs nothing.
    #[inline(always)]
    fn basis<const N: usize>(&self) -> impl Fn(usize) -> Basis + use<N>
    where
        Lagrange<N>: Space<N>,
    {
        let values = *<Lagrange<N> as Space<N>>::values(self);
        let gradients = <Lagrange<N> as Space<N>>::gradients(self);
        move |i| Basis {
            value: values[i],
            gradient: gradients[i],
        }
    }
}

/// Weight, normal and shape functions at a quadrature point of a boundary facet.
#[non_exhaustive]
pub struct FacetValues<'a> {
    /// Shape functions of the adjacent cell; its `weight` includes the surface element.
    pub point: PointValues<'a>,
    /// Unit normal of the curved facet, out of the fluid.
    pub normal: Vec3,
    /// Tag of the facet, an index into [`TetMesh::tags`].
    pub tag: u16,
}

/// Calls `f` at the points of a rule on a facet.
pub(crate) fn for_each_facet_point(
    mesh: &TetMesh,
    facet: &Facet,
    rule: &[FacetPoint],
    mut f: impl FnMut(&FacetValues<'_>),
) -> Result<(), FemError> {
    let cell = facet.cell as usize;
    let (positions, surface) = (mesh.cell_points(cell), facet_nodes(mesh, facet));
    for point in rule {
        let at = facet_cell_point(facet, &mesh.cells()[cell], point);
        let map = MapAt::new(cell, &positions, &at)?;
        let (_, normal) = position_and_normal(&surface, point);
        let area = normal.norm();
        let point = PointValues {
            weight: area * point.weight,
            ..PointValues::new(mesh, cell, &positions, &at, map)
        };
        f(&FacetValues {
            point,
            normal: normal / area,
            tag: facet.tag,
        });
    }
    Ok(())
}
