//! Bilinear forms of callers: on cells, on boundary facets, and matrices with several components.

use std::borrow::Cow;
use std::marker::PhantomData;

use linalg::Csr;
use mesh::TetMesh;
use sprs::{CsMatI, TriMatI};

use crate::assemble::{Form, matrix_on_pattern};
use crate::error::check_finite_in_cell;
use crate::geometry::{Affine, CellNodes};
use crate::point_values::{FacetValues, Lagrange, PointValues, Space, for_each_facet_point};
use crate::quadrature::{CellPoint, cell_rule, facet_rule};
use crate::quantity::Quantity;
use crate::sum::accumulate_items;
use crate::surface::tagged_facets;
use crate::{FemError, TaylorHood};

/// A form that is integrated by quadrature on all cells.
pub(crate) struct ByQuadrature<F, E> {
    form: F,
    affine: &'static [CellPoint],
    curved: &'static [CellPoint],
    entry: PhantomData<fn() -> E>,
}

impl<F, E> ByQuadrature<F, E> {
    /// The form that `form` adds, with the rules of affine and of curved cells.
    pub fn new(form: F, affine: &'static [CellPoint], curved: &'static [CellPoint]) -> Self {
        Self {
            form,
            affine,
            curved,
            entry: PhantomData,
        }
    }
}

impl<const R: usize, const C: usize, E, F> Form<R, C> for ByQuadrature<F, E>
where
    E: Quantity,
    F: Fn(&PointValues<'_>, &mut [[E; C]; R]) + Sync,
{
    type Entry = E;
    type AffineData = ();
    const IS_CLOSED: bool = false;

    fn affine_data(&self, _: usize, _: &Affine) {}

    fn affine_row((): &(), _: usize) -> [E; C] {
        [E::zero(); C]
    }

    fn rule(&self, is_affine: bool) -> &'static [CellPoint] {
        if is_affine { self.affine } else { self.curved }
    }

    fn add(&self, point: &PointValues<'_>, matrix: &mut [[E; C]; R]) {
        (self.form)(point, matrix);
    }

    fn finish(
        &self,
        cell: usize,
        nodes: &CellNodes,
        matrix: &mut [[E; C]; R],
    ) -> Result<(), FemError> {
        check_finite_in_cell("the element matrix", cell, nodes, matrix.as_flattened())
    }
}

impl TaylorHood {
    /// Matrix of a bilinear form, given by its integrand at the quadrature points.
    ///
    /// `form(point, matrix)` adds weight times integrand to the element matrix, by
    /// [`PointValues::add`] or entry by entry. The type of the element matrix, `[[E; C]; R]`,
    /// chooses the spaces of the test functions (`R` rows) and of the trial functions (`C`
    /// columns): 10 for quadratic (P2) and 4 for linear (P1) functions. Its entries choose those of
    /// the sparse matrix:
    ///
    /// | `E` | matrix | for example |
    /// |---|---|---|
    /// | `f64` | [`Csr`] | `∫ ∇u · ∇v` |
    /// | `Vec3` | [`linalg::Csr3`] | `-∫ q ∇·u` with `R = 4`, `C = 10` |
    /// | `Matrix3<f64>` | blocks `[[f64; 3]; 3]` by rows | `∫ 2 D(u):D(v)` |
    /// | `[f64; N]`, `[[f64; M]; N]` | the same | several fields |
    ///
    /// Row `i` of a block belongs to component `i` of the test function. [`interleaved`] makes a
    /// [`Csr`] of a matrix of blocks.
    ///
    /// `degree` is that up to which polynomials in reference coordinates are integrated exactly;
    /// the next rule of degree 2, 5, 6 or 8 (4, 14, 24, 46 points) is used. On curved cells the
    /// Jacobian determinant adds a degree of three at most. The form need not be symmetric. The
    /// matrix has the pattern of all cells and covers all nodes. It is bitwise the same for any
    /// number of threads. Cost: that of `form` at all points; temporary memory 1 MB per thread and
    /// 20 bytes per cell.
    ///
    /// ```
    /// use fem::TaylorHood;
    /// use mesh::{LinearTets, TetMesh, Vec3};
    /// let mesh = TetMesh::straight(LinearTets::cube(2))?;
    /// let space = TaylorHood::new(&mesh)?;
    /// // ∫ (∇u · ∇v + v w · ∇u), on quadratic elements; for v = 1 and u = x it is ∫ w_x = 2.
    /// let wind = Vec3::new(2.0, 1.0, 0.0);
    /// let matrix = space.assemble(&mesh, 4, |point, matrix: &mut [[f64; 10]; 10]| {
    ///     point.add(matrix, |v, u| v.gradient.dot(&u.gradient) + v.value * wind.dot(&u.gradient));
    /// })?;
    /// let sum: f64 = matrix.iter().map(|(a, (_, j))| a * mesh.points()[j as usize].x).sum();
    /// assert!((sum - 2.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`FemError::Degree`] above 8; [`FemError::NotFiniteInCell`] for an integrand that is not
    /// finite; [`FemError::OtherMesh`], [`FemError::InvertedCell`].
    pub fn assemble<E: Quantity, const R: usize, const C: usize>(
        &self,
        mesh: &TetMesh,
        degree: usize,
        form: impl Fn(&PointValues<'_>, &mut [[E; C]; R]) + Sync,
    ) -> Result<CsMatI<E::Stored, u32, usize>, FemError>
    where
        Lagrange<R>: Space<R>,
        Lagrange<C>: Space<C>,
    {
        let rule = cell_rule(degree)?;
        let (starts, columns) = self.pattern_of::<R, C>();
        let values = self.assemble_form(mesh, &starts, &ByQuadrature::new(form, rule, rule))?;
        let shape = (starts.len() - 1, <Lagrange<C> as Space<C>>::n_nodes(mesh));
        Ok(matrix_on_pattern(shape, &starts, &columns, values))
    }

    /// Matrix of a bilinear form on the boundary facets with `tag`, such as a Robin condition.
    ///
    /// `form` adds weight times integrand, as for [`TaylorHood::assemble`]; its point has the
    /// functions of the adjacent cell, with their full gradients, and the unit normal out of the
    /// fluid. The matrix has the pattern of that of [`TaylorHood::assemble`], with zeros away from
    /// the facets, so that the two add entry by entry. Rules: degree 6 or 8 (12, 16 points).
    ///
    /// # Errors
    /// [`FemError::EmptyTag`], and those of [`TaylorHood::assemble`].
    pub fn assemble_facets<E: Quantity, const R: usize, const C: usize>(
        &self,
        mesh: &TetMesh,
        tag: u16,
        degree: usize,
        form: impl Fn(&FacetValues<'_>, &mut [[E; C]; R]) + Sync,
    ) -> Result<CsMatI<E::Stored, u32, usize>, FemError>
    where
        Lagrange<R>: Space<R>,
        Lagrange<C>: Space<C>,
    {
        self.check(mesh)?;
        let (rule, facets) = (facet_rule(degree)?, tagged_facets(mesh, tag)?);
        let (starts, columns) = self.pattern_of::<R, C>();
        let mut values = vec![E::stored_zero(); columns.len()];
        let facet_matrix = |k: usize| {
            let mut matrix = [[E::zero(); C]; R];
            for_each_facet_point(mesh, facets[k], rule, |at| form(at, &mut matrix))?;
            let cell = facets[k].cell as usize;
            let nodes = mesh.cell_points(cell);
            check_finite_in_cell("the facet matrix", cell, &nodes, matrix.as_flattened())?;
            Ok(matrix)
        };
        accumulate_items(facets.len(), facet_matrix, |k, matrix| {
            let cell = facets[k].cell as usize;
            for (&row, contributions) in mesh.cells()[cell].iter().zip(&matrix) {
                let row = row as usize;
                let positions = self.pattern.positions_in_row(row, cell);
                let values = &mut values[starts[row]..];
                for (contribution, &position) in contributions.iter().zip(positions) {
                    contribution.add_to(&mut values[position as usize]);
                }
            }
        })?;
        let shape = (starts.len() - 1, <Lagrange<C> as Space<C>>::n_nodes(mesh));
        Ok(matrix_on_pattern(shape, &starts, &columns, values))
    }

    /// Row starts and columns of matrices with `R` test and `C` trial functions per cell.
    fn pattern_of<const R: usize, const C: usize>(&self) -> (Cow<'_, [usize]>, Cow<'_, [u32]>) {
        let (starts, columns) = (&self.pattern.row_starts, &self.pattern.columns);
        match (R, C) {
            (4, 4) => (
                (&self.vertex_row_starts).into(),
                (&self.vertex_columns).into(),
            ),
            (4, _) => {
                let starts = &starts[..=self.n_vertices()];
                let columns = &columns[..starts[self.n_vertices()]];
                (starts.into(), columns.into())
            }
            (_, 4) => {
                let (starts, columns) = self
                    .pattern
                    .leading_columns(self.n_vertices(), self.n_points());
                (starts.into(), columns.into())
            }
            _ => (starts.into(), columns.into()),
        }
    }
}

/// Matrix of numbers from a matrix of blocks with `N` rows and `M` columns.
///
/// Row `N i + c` and column `M j + d` hold entry `(c, d)` of block `(i, j)`, so the components of a
/// node are consecutive, as [`DirichletCondition`](crate::DirichletCondition) and the solvers of
/// `linalg` expect them. Cost: one pass over the matrix.
///
/// ```
/// use fem::sprs::CsMatI;
/// let blocks = CsMatI::<[[f64; 2]; 2], u32, usize>::new((1, 1), vec![0, 1], vec![0], vec![
///     [[1.0, 2.0], [3.0, 4.0]],
/// ]);
/// assert_eq!(fem::interleaved(&blocks)?.data(), [1.0, 2.0, 3.0, 4.0]);
/// # Ok::<(), fem::FemError>(())
/// ```
///
/// # Errors
/// [`FemError::TooLarge`] if the result has 2^32 rows or columns or more.
pub fn interleaved<const M: usize, const N: usize>(
    blocks: &CsMatI<[[f64; M]; N], u32, usize>,
) -> Result<Csr, FemError> {
    let shape = (
        N.saturating_mul(blocks.rows()),
        M.saturating_mul(blocks.cols()),
    );
    let (found, limit) = (shape.0.max(shape.1), u32::MAX as usize);
    if found > limit {
        return Err(FemError::TooLarge {
            what: "the number of rows or columns",
            found,
            limit,
        });
    }
    if !blocks.is_csr() {
        let mut triplets = TriMatI::new(shape);
        for (block, (i, j)) in blocks {
            for c in 0..N {
                for d in 0..M {
                    triplets.add_triplet(N * i as usize + c, M * j as usize + d, block[c][d]);
                }
            }
        }
        return Ok(triplets.to_csr());
    }
    let starts = blocks.indptr();
    let (columns, blocks) = (blocks.indices(), blocks.data());
    Ok(interleaved_rows(
        shape,
        &starts.to_proper(),
        columns,
        blocks,
    ))
}

/// Matrix of numbers from rows of blocks.
pub(crate) fn interleaved_rows<const M: usize, const N: usize>(
    shape: (usize, usize),
    starts: &[usize],
    columns: &[u32],
    blocks: &[[[f64; M]; N]],
) -> Csr {
    let mut row_starts = Vec::with_capacity(N * (starts.len() - 1) + 1);
    row_starts.push(0);
    let mut scalar_columns = Vec::with_capacity(N * M * columns.len());
    let mut scalars = Vec::with_capacity(N * M * columns.len());
    for row in starts.windows(2) {
        let row = row[0]..row[1];
        for c in 0..N {
            for (&column, block) in columns[row.clone()].iter().zip(&blocks[row.clone()]) {
                let first = M as u32 * column;
                scalar_columns.extend(std::array::from_fn::<_, M, _>(|d| first + d as u32));
                scalars.extend(block[c]);
            }
            row_starts.push(scalars.len());
        }
    }
    Csr::new(shape, row_starts, scalar_columns, scalars)
}
