//! Essential (Dirichlet) boundary conditions by elimination.

use linalg::{Csr, OMITTED, submatrix};
use mesh::TetMesh;
use rayon::prelude::*;
use sprs::CsMatI;

use crate::error::{FemError, check_length};
use crate::quantity::Nodal;
use crate::surface::tagged_facets;

/// Nodes with prescribed values, and the reduction of systems to the free nodes.
///
/// Let the nodes consist of free nodes `F` and prescribed nodes `D`. A system `A u = f` with given
/// values on `D` reduces to
///
/// ```text
/// A_FF u_F = f_F - (A u_D)_F
/// ```
///
/// where the lift `u_D` has the given values on `D` and zeros on `F`. [`lift`](Self::lift) makes
/// the lift of a field, [`rhs`](Self::rhs) the right-hand side,
/// [`restrict_matrix`](Self::restrict_matrix) the matrix `A_FF`, and [`expand`](Self::expand)
/// writes the solution into a nodal field. [`reduce`](Self::reduce) does all but the last for a
/// matrix over all nodes.
///
/// Nodal values are numbers, 3-vectors or arrays of any number of components ([`Nodal`]). All
/// components of a prescribed node are prescribed; to prescribe some of them, let the "nodes" be
/// the dofs of an [`interleaved`](crate::interleaved) matrix, with numbers as values.
///
/// Rigid bodies with unknown velocities are another kind of constraint, a static condensation of
/// nodal velocities to rigid motions. The crate `rigid` implements it, and symmetry planes, without
/// this type.
///
/// ```
/// use fem::{DirichletCondition, TaylorHood};
/// use mesh::{LinearTets, TetMesh};
/// let mesh = TetMesh::straight(LinearTets::cube(2))?;
/// let condition = DirichletCondition::on_boundary(&mesh);
/// assert_eq!(condition.n_free(), 27); // of 125 nodes
/// let stiffness = TaylorHood::new(&mesh)?.stiffness(&mesh)?;
/// assert_eq!(condition.restrict_matrix(&stiffness, 1)?.shape(), (27, 27));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct DirichletCondition {
    /// Free nodes in ascending order.
    free: Vec<u32>,
    /// For each node its number among the free nodes; [`OMITTED`] for a prescribed node.
    numbers: Vec<u32>,
}

impl DirichletCondition {
    /// Condition on the nodes that are marked as prescribed: all points, or the vertices alone for
    /// linear elements.
    pub fn new(prescribed: &[bool]) -> Self {
        let mut numbers = vec![OMITTED; prescribed.len()];
        let mut free = Vec::new();
        for (node, _) in prescribed.iter().enumerate().filter(|(_, is)| !**is) {
            numbers[node] = free.len() as u32;
            free.push(node as u32);
        }
        Self { free, numbers }
    }

    /// Condition on all nodes of the boundary facets of a mesh.
    pub fn on_boundary(mesh: &TetMesh) -> Self {
        let mut prescribed = vec![false; mesh.n_points()];
        for node in mesh.facets().iter().flat_map(|facet| facet.nodes) {
            prescribed[node as usize] = true;
        }
        Self::new(&prescribed)
    }

    /// Condition on all nodes of the boundary facets with one of these tags.
    ///
    /// # Errors
    /// [`FemError::EmptyTag`].
    pub fn on_tags(mesh: &TetMesh, tags: &[u16]) -> Result<Self, FemError> {
        let mut prescribed = vec![false; mesh.n_points()];
        for &tag in tags {
            for node in tagged_facets(mesh, tag)?.into_iter().flat_map(|f| f.nodes) {
                prescribed[node as usize] = true;
            }
        }
        Ok(Self::new(&prescribed))
    }

    /// Number of free nodes.
    pub fn n_free(&self) -> usize {
        self.free.len()
    }

    /// Free nodes in ascending order.
    pub fn free_nodes(&self) -> &[u32] {
        &self.free
    }

    /// Sets a field to zero at the free nodes, which makes it the lift of its boundary values.
    ///
    /// # Errors
    /// [`FemError::Length`] if the field has another number of nodes.
    pub fn lift<T: Nodal>(&self, field: &mut [T]) -> Result<(), FemError> {
        self.check_nodes("the field", field.len())?;
        for &node in &self.free {
            field[node as usize] = T::zero();
        }
        Ok(())
    }

    /// Right-hand side `f_F - (A u_D)_F` of the free nodes, with interleaved components.
    ///
    /// `image` is `A u_D`, the product of the matrix over all nodes and the lift.
    ///
    /// # Errors
    /// [`FemError::Length`] if an array has another number of nodes.
    pub fn rhs<T: Nodal>(&self, load: &[T], image: &[T]) -> Result<Vec<f64>, FemError> {
        self.check_nodes("the load", load.len())?;
        self.check_nodes("the product of matrix and lift", image.len())?;
        Ok(self.gather(|node| {
            let mut value = load[node];
            value.add_scaled(-1.0, &image[node]);
            value
        }))
    }

    /// Values of a field at the free nodes, with interleaved components.
    ///
    /// # Errors
    /// [`FemError::Length`] if the field has another number of nodes.
    pub fn restrict<T: Nodal>(&self, field: &[T]) -> Result<Vec<f64>, FemError> {
        self.check_nodes("the field", field.len())?;
        Ok(self.gather(|node| field[node]))
    }

    /// Writes values at the free nodes into a field and keeps its prescribed values.
    ///
    /// Shape: `values` `n_free` times the number of components, which are interleaved.
    ///
    /// # Errors
    /// [`FemError::Length`] if an array has the wrong length.
    pub fn expand<T: Nodal>(&self, values: &[f64], field: &mut [T]) -> Result<(), FemError> {
        self.check_nodes("the field", field.len())?;
        let n = T::COMPONENTS;
        let expected = n * self.free.len();
        check_length("the values at free nodes", values.len(), expected)?;
        for (k, &node) in self.free.iter().enumerate() {
            field[node as usize] = T::from_components(|c| values[n * k + c]);
        }
        Ok(())
    }

    /// Matrix `A_FF` and right-hand side `f_F - (A u_D)_F` of the free nodes.
    ///
    /// `field` has the prescribed values at the prescribed nodes; its values at free nodes do not
    /// matter. `matrix` has as many rows per node as the field has components. After the solution,
    /// [`expand`](Self::expand) writes it into `field`.
    ///
    /// ```
    /// use fem::{DirichletCondition, TaylorHood, interpolate, load_vector};
    /// use linalg::{CsrOperator, Identity, KrylovParams, cg};
    /// use mesh::{LinearTets, TetMesh};
    /// // -Δu = -2 in the unit cube with the solution u = x^2.
    /// let mesh = TetMesh::straight(LinearTets::cube(2))?;
    /// let stiffness = TaylorHood::new(&mesh)?.stiffness(&mesh)?;
    /// let condition = DirichletCondition::on_boundary(&mesh);
    /// let exact = interpolate::<f64, 10>(&mesh, |x| x.x * x.x)?;
    /// let mut u = exact.clone();
    /// let (a, b) = condition.reduce(&stiffness, &load_vector(&mesh, |_| -2.0)?, &u)?;
    /// let mut solution = vec![0.0; b.len()];
    /// let a = CsrOperator::new(a)?;
    /// cg(&a, &mut Identity(b.len()), &b, &mut solution, &KrylovParams::default())?;
    /// condition.expand(&solution, &mut u)?;
    /// assert!(u.iter().zip(&exact).all(|(u, exact)| (u - exact).abs() < 1e-7));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`restrict_matrix`](Self::restrict_matrix) and [`rhs`](Self::rhs).
    pub fn reduce<T: Nodal>(
        &self,
        matrix: &Csr,
        load: &[T],
        field: &[T],
    ) -> Result<(Csr, Vec<f64>), FemError> {
        let mut lift = field.to_vec();
        self.lift(&mut lift)?;
        let reduced = self.restrict_matrix(matrix, T::COMPONENTS)?;
        let lift: Vec<f64> = lift.iter().flat_map(T::components).copied().collect();
        let (starts, columns, values) = (matrix.indptr(), matrix.indices(), matrix.data());
        let product = |row: usize| -> f64 {
            let range = starts.outer_inds_sz(row);
            range.map(|k| values[k] * lift[columns[k] as usize]).sum()
        };
        let row = |node: usize| T::from_components(|c| product(T::COMPONENTS * node + c));
        let image: Vec<T> = (0..self.numbers.len()).into_par_iter().map(row).collect();
        Ok((reduced, self.rhs(load, &image)?))
    }

    /// Rows and columns `A_FF` of the free nodes, for a matrix with `components` rows per node.
    ///
    /// A matrix of blocks has one row per node, so `components` is 1. Cost: two passes over the
    /// rows, in parallel.
    ///
    /// # Errors
    /// [`FemError::Length`] if the matrix has another shape, [`FemError::Linalg`] if it is not
    /// stored by rows.
    pub fn restrict_matrix<T: Copy + Default + Send + Sync>(
        &self,
        matrix: &CsMatI<T, u32, usize>,
        components: usize,
    ) -> Result<CsMatI<T, u32, usize>, FemError> {
        let n = components.saturating_mul(self.numbers.len());
        check_length("a column of the matrix", matrix.rows(), n)?;
        check_length("a row of the matrix", matrix.cols(), n)?;
        if components == 1 {
            let numbers = &self.numbers;
            return Ok(submatrix(matrix, &self.free, numbers, self.free.len())?);
        }
        let per_node = components as u32;
        let expanded = |node: u32| (0..per_node).map(move |c| per_node * node + c);
        let rows: Vec<u32> = self.free.iter().flat_map(|&node| expanded(node)).collect();
        let mut numbers = vec![OMITTED; n];
        for (number, &row) in rows.iter().enumerate() {
            numbers[row as usize] = number as u32;
        }
        Ok(submatrix(matrix, &rows, &numbers, rows.len())?)
    }

    /// Interpolation between the free vertices and the free nodes, of
    /// [`TaylorHood::vertex_interpolation`](crate::TaylorHood::vertex_interpolation).
    ///
    /// The first prolongation of a multigrid method for [`restrict_matrix`](Self::restrict_matrix)
    /// with one component (`linalg::Prolongation::scalar`). Columns of free vertices remain, in
    /// ascending order, because prescribed values do not change.
    ///
    /// ```
    /// use fem::{DirichletCondition, TaylorHood};
    /// use linalg::{CsrOperator, KrylovParams, MultigridParams, Prolongation, ScalarMultigrid, cg};
    /// use mesh::{LinearTets, TetMesh};
    /// let mesh = TetMesh::straight(LinearTets::cube(4))?;
    /// let (space, condition) = (TaylorHood::new(&mesh)?, DirichletCondition::on_boundary(&mesh));
    /// let a = CsrOperator::new(condition.restrict_matrix(&space.stiffness(&mesh)?, 1)?)?;
    /// let p = condition.restrict_prolongation(&space.vertex_interpolation(&mesh)?)?;
    /// assert_eq!(p.shape(), (343, 27));
    /// let params = MultigridParams::default();
    /// let p = Prolongation::scalar(p)?;
    /// let mut multigrid = ScalarMultigrid::with_prolongation(&a, &p, None, &params)?;
    /// let mut u = vec![0.0; 343];
    /// let found = cg(&a, &mut multigrid, &vec![1.0; 343], &mut u, &KrylovParams::default())?;
    /// assert!(found.iterations < 20);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`FemError::Length`] if the matrix has another number of rows or more columns than nodes,
    /// [`FemError::Linalg`] if it is not stored by rows.
    pub fn restrict_prolongation(&self, interpolation: &Csr) -> Result<Csr, FemError> {
        let (n, vertices) = (self.numbers.len(), interpolation.cols());
        check_length("a column of the interpolation", interpolation.rows(), n)?;
        check_length("a row of the interpolation", vertices.max(n), n)?;
        let n_free_vertices = self
            .free
            .partition_point(|&node| (node as usize) < vertices);
        let numbers = &self.numbers[..vertices];
        Ok(submatrix(
            interpolation,
            &self.free,
            numbers,
            n_free_vertices,
        )?)
    }

    /// Columns of the free nodes of a discrete divergence or another mixed matrix, all rows.
    ///
    /// # Errors
    /// [`FemError::Length`] if the divergence has another number of columns, [`FemError::Linalg`]
    /// if it is not stored by rows.
    pub fn restrict_divergence<T: Copy + Default + Send + Sync>(
        &self,
        divergence: &CsMatI<T, u32, usize>,
    ) -> Result<CsMatI<T, u32, usize>, FemError> {
        self.check_nodes("a row of the divergence", divergence.cols())?;
        let rows: Vec<u32> = (0..divergence.rows() as u32).collect();
        let numbers = &self.numbers;
        Ok(submatrix(divergence, &rows, numbers, self.free.len())?)
    }

    fn gather<T: Nodal>(&self, value: impl Fn(usize) -> T) -> Vec<f64> {
        let mut values = Vec::with_capacity(T::COMPONENTS * self.free.len());
        for &node in &self.free {
            values.extend_from_slice(value(node as usize).components());
        }
        values
    }

    fn check_nodes(&self, what: &'static str, found: usize) -> Result<(), FemError> {
        check_length(what, found, self.numbers.len())
    }
}

#[cfg(test)]
mod tests {
    use mesh::Vec3;

    use super::*;

    /// Five nodes, of which the second and the fourth are prescribed.
    fn condition() -> DirichletCondition {
        DirichletCondition::new(&[false, true, false, true, false])
    }

    #[test]
    fn expansion_inverts_restriction_and_keeps_prescribed_values() {
        let condition = condition();
        let field: Vec<Vec3> = (0..5).map(|i| Vec3::new(f64::from(i), 1.0, 2.0)).collect();
        let values = condition.restrict(&field).unwrap();
        assert_eq!(values, [0.0, 1.0, 2.0, 2.0, 1.0, 2.0, 4.0, 1.0, 2.0]);
        let mut lift = field.clone();
        condition.lift(&mut lift).unwrap();
        let zero = Vec3::zeros();
        assert_eq!(lift, [zero, field[1], zero, field[3], zero]);
        condition.expand(&values, &mut lift).unwrap();
        assert_eq!(lift, field);
    }

    /// `A_FF u_F = f_F - (A u_D)_F` for a matrix with one and with three rows per node.
    #[test]
    fn the_reduced_system_has_the_solution_of_the_whole() {
        let condition = condition();
        for components in [1, 3] {
            let n = 5 * components;
            let entry = |i: usize, j: usize| ((3 * i + 7 * j) % 11) as f64;
            let columns = (0..n).flat_map(|_| 0..n as u32).collect();
            let values = (0..n)
                .flat_map(|i| (0..n).map(move |j| entry(i, j)))
                .collect();
            let matrix = Csr::new((n, n), (0..=n).map(|i| i * n).collect(), columns, values);
            let product = |matrix: &Csr, u: &[f64]| -> Vec<f64> {
                let rows = matrix.outer_iterator();
                rows.map(|row| row.iter().map(|(j, a)| a * u[j]).sum())
                    .collect()
            };
            // A u for nodal vectors: each component by the scalar matrix, or all by the full one.
            let image = |matrix: &Csr, u: &[f64]| -> Vec<f64> {
                if components == 3 {
                    return product(matrix, u);
                }
                let mut result = vec![0.0; u.len()];
                for c in 0..3 {
                    let component: Vec<f64> = u.iter().skip(c).step_by(3).copied().collect();
                    for (i, value) in product(matrix, &component).into_iter().enumerate() {
                        result[3 * i + c] = value;
                    }
                }
                result
            };
            let nodal = |values: &[f64]| -> Vec<Vec3> {
                values
                    .as_chunks::<3>()
                    .0
                    .iter()
                    .map(|&v| v.into())
                    .collect()
            };
            let flat = |field: &[Vec3]| -> Vec<f64> {
                field.iter().flat_map(|&v| <[f64; 3]>::from(v)).collect()
            };
            let u: Vec<f64> = (0..15).map(|i| f64::from(i) - 4.0).collect();
            let load = nodal(&image(&matrix, &u));
            let mut lift = nodal(&u);
            condition.lift(&mut lift).unwrap();
            let image_of_lift = nodal(&image(&matrix, &flat(&lift)));
            let rhs = condition.rhs(&load, &image_of_lift).unwrap();
            let reduced = condition.restrict_matrix(&matrix, components).unwrap();
            // Integers, so that sums are exact.
            let free = condition.restrict(&nodal(&u)).unwrap();
            assert_eq!(image(&reduced, &free), rhs);
        }
    }
}
