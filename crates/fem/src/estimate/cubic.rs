//! The equations of Stokes flow in cubic velocities and quadratic pressures.

use std::borrow::Cow;

use mesh::{Facet, TET_EDGES, TetMesh, Vec3};
use pulp::Arch;
use rayon::prelude::*;

use super::bubbles::{BUBBLES_PER_CELL, rule, signs};
use super::cubic_cell::{Cell, CellValues, CoarseRows, CoarseValues, Gradient, Product};
use super::cubic_tables::{AffineCell, AffineMap, CurvedCell, Vectors};
use super::facet_geometry::gradient_of;
use super::surplus::SurplusSpace;
use super::surplus_part::SurplusPart;
use super::varying_viscosity::{StressOf, VaryingViscosity};
use crate::error::{FemError, check_array, check_length, check_vectors};
use crate::geometry::{Affine, MapAt};
use crate::quantity::gradient_in_cell;
use crate::sum::{CELLS_PER_TASK, accumulate, sum_over};

/// Extension of the Taylor-Hood equations on a mesh by the functions of the next degree.
///
/// Velocities are extended by cubic bubbles, six edge and four face functions per cell
/// ([`SurplusSpace`]), pressures by one quadratic function `l_a l_b` per edge. Together with the
/// quadratic velocities and linear pressures they span the Taylor-Hood space P3/P2 in a
/// hierarchical basis:
///
/// ```text
/// K(u, p; v, q) = ∫ ∇u:∇v - ∫ p ∇·v - ∫ q ∇·u
/// ```
///
/// The matrix of `K` in this basis has four blocks. Taylor-Hood elements have the first, in
/// quadratic and linear functions alone; this type has the other three. It is not assembled: a
/// product is one pass over the cells, with tables of the reference cell for affine cells and
/// stored element matrices for curved ones.
///
/// Memory: 5 kB per curved cell and 90 bytes per affine one. Dofs of the extension are three
/// components of each bubble and then one pressure per edge. Those that the boundary prescribes are
/// zero in all rows; in a vector they are zero, or the velocity of a surface
/// ([`interpolate`](Self::interpolate)).
///
/// For a viscosity that depends on the shear rate ([`with_viscosity`](Self::with_viscosity)) the
/// matrix is that of the derivative of the stress, and [`residual`](Self::residual) has the stress
/// itself.
///
/// On a part of a mesh ([`SurplusSpace::with_part`]) velocities and pressures have the values of
/// all nodes of the part. Dofs of the extension that belong to other processes are read from those,
/// and are zero in rows.
pub struct CubicExtension<'a> {
    space: &'a SurplusSpace,
    mesh: &'a TetMesh,
    cells: Vec<Cell>,
    /// One entry per bubble, then one per pressure.
    diagonal: Vec<f64>,
    viscosity: Option<&'a VaryingViscosity<'a>>,
}

/// Product of the matrix of a [`CubicExtension`] with a vector.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CubicProduct {
    /// Momentum rows of the quadratic velocities, one vector per node of the mesh.
    pub velocity: Vec<Vec3>,
    /// Continuity rows of the linear pressures.
    pub pressure: Vec<f64>,
    /// Rows of the extension.
    pub extension: Vec<f64>,
}

/// A flow of quadratic velocities and linear pressures with dofs of a [`CubicExtension`].
#[derive(Clone, Copy)]
pub struct CubicFlow<'a> {
    /// Velocity of each node.
    pub velocity: &'a [Vec3],
    /// Pressure of each vertex.
    pub pressure: &'a [f64],
    /// Dofs of the extension.
    pub extension: &'a [f64],
}

/// Vectors from their components.
fn vectors([x, y, z]: &Vectors) -> [Vec3; 10] {
    std::array::from_fn(|k| Vec3::new(x[k], y[k], z[k]))
}

impl<'a> CubicExtension<'a> {
    /// Integrates over the curved cells and computes the diagonal.
    ///
    /// Cost: two passes over the cells.
    ///
    /// # Errors
    /// A mesh that does not belong to the space; an inverted cell.
    pub fn new(space: &'a SurplusSpace, mesh: &'a TetMesh) -> Result<Self, FemError> {
        space.check(mesh)?;
        let matrices = |cell: usize| {
            let points = mesh.cell_points(cell);
            Ok(match mesh.is_affine(cell) {
                true => Cell::Affine(AffineMap::new(&Affine::new(cell, &points)?)),
                false => Cell::Curved(CurvedCell::new(cell, &points)?),
            })
        };
        let cells = (0..mesh.n_cells())
            .into_par_iter()
            .with_min_len(CELLS_PER_TASK)
            .map(matrices)
            .collect::<Result<_, FemError>>()?;
        let mut extension = Self {
            space,
            mesh,
            cells,
            diagonal: Vec::new(),
            viscosity: None,
        };
        extension.diagonal = extension.compute_diagonal();
        Ok(extension)
    }

    /// The equations for the derivative of the stress of a viscosity that varies.
    ///
    /// # Errors
    /// A viscosity on another mesh.
    pub fn with_viscosity(mut self, viscosity: &'a VaryingViscosity<'a>) -> Result<Self, FemError> {
        check_length(
            "cells of the viscosity",
            viscosity.len(),
            self.mesh.n_cells(),
        )?;
        self.viscosity = Some(viscosity);
        self.diagonal = self.compute_diagonal();
        Ok(self)
    }

    /// The mesh.
    pub(super) fn mesh(&self) -> &TetMesh {
        self.mesh
    }

    /// Number of the face bubble of a facet of the boundary.
    pub(super) fn face_bubble(&self, facet: &Facet) -> usize {
        let (cell, corners) = (facet.cell as usize, &facet.nodes[..3]);
        let nodes = &self.mesh.cells()[cell];
        let opposite = (0..4).find(|&k| !corners.contains(&nodes[k]));
        // The face bubbles come after those of the edges, in the order of the opposite vertices.
        self.space.bubbles.of_cell(cell, nodes)[6 + opposite.unwrap_or_default()]
    }

    /// Number of dofs of the extension.
    pub fn len(&self) -> usize {
        3 * self.space.bubbles.len() + self.n_edges()
    }

    /// Whether there are no dofs, as on a mesh without cells.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// First pressure among the dofs of the extension.
    pub fn first_pressure(&self) -> usize {
        3 * self.space.bubbles.len()
    }

    /// `∫ |∇φ|^2` for a component of a bubble, `∫ ψ^2` for a pressure.
    ///
    /// The diagonal of the matrix for velocities; for pressures that of the mass matrix, to which
    /// minus the Schur complement is spectrally equivalent.
    ///
    /// # Panics
    /// If there is no such dof.
    #[inline]
    pub fn diagonal(&self, dof: usize) -> f64 {
        let bubbles = self.space.bubbles.len();
        match dof < 3 * bubbles {
            true => self.diagonal[dof / 3],
            false => self.diagonal[dof - 2 * bubbles],
        }
    }

    fn n_edges(&self) -> usize {
        self.mesh.n_points() - self.mesh.n_vertices()
    }

    fn compute_diagonal(&self) -> Vec<f64> {
        let (nodes, first_pressure) = (self.mesh.n_vertices(), self.space.bubbles.len());
        let mut diagonal = vec![0.0; first_pressure + self.n_edges()];
        for (number, cell) in self.cells.iter().enumerate() {
            let (energies, masses) = match cell {
                Cell::Affine(map) => AffineCell::new(map).diagonals(),
                Cell::Curved(cell) => cell.diagonals(),
            };
            let viscosity = self
                .viscosity
                .map_or(1.0, |viscosity| viscosity.mean(number));
            let cell_nodes = &self.mesh.cells()[number];
            let bubbles = self.space.bubbles.of_cell(number, cell_nodes);
            for (bubble, energy) in bubbles.into_iter().zip(energies) {
                diagonal[bubble] += viscosity * energy;
            }
            for (&node, mass) in cell_nodes[4..].iter().zip(masses) {
                diagonal[first_pressure + node as usize - nodes] += mass / viscosity;
            }
        }
        diagonal
    }

    /// Residual of a flow in the momentum and continuity equations of cubic elements.
    ///
    /// The [`product`](Self::product), with the stress of the flow in place of its derivative.
    /// Shapes and cost as there; `velocity` has no background flow.
    ///
    /// # Errors
    /// Arrays of the wrong length or not finite.
    pub fn residual(
        &self,
        velocity: &[Vec3],
        pressure: &[f64],
        extension: &[f64],
    ) -> Result<CubicProduct, FemError> {
        self.product_with(StressOf::Flow, velocity, pressure, extension)
    }

    /// Momentum rows of the stress that a change of the flow adds beyond its derivative.
    ///
    /// ```text
    /// ∫ (τ(D(u + b + c)) - τ(D(u + b)) - τ'(D(u)) D(c)) : ∇v
    /// ```
    ///
    /// with the flow `u` of [`with_viscosity`](Self::with_viscosity), the bubbles `b` of surfaces
    /// and the change `c` of `velocity` at nodes and `extension`. It is zero for constant
    /// viscosity; otherwise it is of second order in the change, and so is the error of forces.
    /// Shapes are those of [`product`](Self::product); the rows of pressures are zero.
    ///
    /// Cost: one pass over the cells.
    ///
    /// # Errors
    /// Arrays of the wrong length; velocities that are not finite.
    pub fn remainder(
        &self,
        of_surfaces: &[f64],
        velocity: &[Vec3],
        extension: &[f64],
    ) -> Result<CubicProduct, FemError> {
        let mesh = self.mesh;
        check_vectors("the velocity", velocity, mesh.n_points())?;
        for extension in [of_surfaces, extension] {
            check_length("the extension", extension.len(), self.len())?;
        }
        let [of_surfaces, extension] = [of_surfaces, extension].map(|all| self.completed(all));
        let mut product = self.zero_product();
        let Some(viscosity) = self.viscosity else {
            return Ok(product);
        };
        let of_cell = |cell: usize, rows: &mut [Vectors; 2]| {
            let (nodes, positions) = (&mesh.cells()[cell], mesh.cell_points(cell));
            let bubbles =
                [&of_surfaces, &extension].map(|all| vectors(&self.bubbles_of(cell, all)));
            for (point, at) in rule().iter().zip(viscosity.of_cell(cell)) {
                // cells were checked by the constructor
                let Ok(map) = MapAt::new(cell, &positions, point.at) else {
                    continue;
                };
                let gradients = map.gradients(point.at);
                let [before, of_bubbles] = (bubbles.each_ref())
                    .map(|bubbles| map.gradient(&gradient_of(bubbles, &point.gradients)));
                let change = gradient_in_cell(nodes, velocity, &gradients) + of_bubbles;
                let stress = at.remainder(viscosity.law(), &before, &change) * map.measure;
                let pulled = map.pulled_back(&stress);
                let [to_nodes, to_bubbles] = &mut *rows;
                for (rows, stress, gradients) in [
                    (to_nodes, &stress, &gradients),
                    (to_bubbles, &pulled, &point.gradients),
                ] {
                    for (k, gradient) in gradients.iter().enumerate() {
                        let row = stress * gradient;
                        (0..3).for_each(|c| rows[c][k] += row[c]);
                    }
                }
            }
        };
        accumulate(mesh.n_cells(), of_cell, |cell, [to_nodes, to_bubbles]| {
            for (&node, row) in mesh.cells()[cell].iter().zip(vectors(to_nodes)) {
                product.velocity[node as usize] += row;
            }
            self.add_to_bubbles(cell, to_bubbles, &mut product.extension);
        });
        self.constrain(&mut product.extension);
        Ok(product)
    }

    /// The product with a flow at rest.
    fn zero_product(&self) -> CubicProduct {
        CubicProduct {
            extension: vec![0.0; self.len()],
            ..self.zero_coarse_product()
        }
    }

    /// The same without rows of the extension.
    fn zero_coarse_product(&self) -> CubicProduct {
        CubicProduct {
            velocity: vec![Vec3::zeros(); self.mesh.n_points()],
            pressure: vec![0.0; self.mesh.n_vertices()],
            extension: Vec::new(),
        }
    }

    /// Product with a flow, without the block of quadratic velocities and linear pressures.
    ///
    /// Shapes: `velocity` `n_points`, `pressure` `n_vertices`, `extension` [`len`](Self::len). With
    /// a zero `extension` the rows of the extension are the residual of the flow there.
    ///
    /// Cost: one pass over the cells, about 3500 multiplications each. The same for any number of
    /// threads.
    ///
    /// # Errors
    /// Arrays of the wrong length or not finite.
    pub fn product(
        &self,
        velocity: &[Vec3],
        pressure: &[f64],
        extension: &[f64],
    ) -> Result<CubicProduct, FemError> {
        self.product_with(StressOf::Derivative, velocity, pressure, extension)
    }

    /// The [`product`](Self::product) with the rows of the extension written to `rows`, and none
    /// in the result.
    ///
    /// # Errors
    /// Those of [`product`](Self::product); rows of the wrong length.
    pub fn product_into(
        &self,
        velocity: &[Vec3],
        pressure: &[f64],
        extension: &[f64],
        rows: &mut [f64],
    ) -> Result<CubicProduct, FemError> {
        check_length("the rows of the extension", rows.len(), self.len())?;
        rows.fill(0.0);
        self.add_product(StressOf::Derivative, (velocity, pressure), extension, rows)
    }

    fn product_with(
        &self,
        stress: StressOf,
        velocity: &[Vec3],
        pressure: &[f64],
        extension: &[f64],
    ) -> Result<CubicProduct, FemError> {
        let mut rows = vec![0.0; self.len()];
        let product = self.add_product(stress, (velocity, pressure), extension, &mut rows)?;
        Ok(CubicProduct {
            extension: rows,
            ..product
        })
    }

    /// Adds the rows of the extension to zeros, and returns the other rows of a product.
    fn add_product(
        &self,
        stress: StressOf,
        (velocity, pressure): (&[Vec3], &[f64]),
        extension: &[f64],
        rows_of_extension: &mut [f64],
    ) -> Result<CubicProduct, FemError> {
        let mesh = self.mesh;
        check_vectors("the velocity", velocity, mesh.n_points())?;
        check_array("the pressure", pressure, mesh.n_vertices())?;
        check_length("the extension", extension.len(), self.len())?;
        let extension = &*self.completed(extension);
        let mut product = self.zero_coarse_product();
        let arch = Arch::new();
        let of_cell = |cell: usize, rows: &mut CellValues| {
            let nodes = &mesh.cells()[cell];
            let values = CellValues {
                coarse: CoarseValues {
                    nodes: std::array::from_fn(|c| nodes.map(|node| velocity[node as usize][c])),
                    linear: std::array::from_fn(|k| pressure[nodes[k] as usize]),
                },
                bubbles: self.bubbles_of(cell, extension),
                edges: self.edges_of(cell, extension),
            };
            arch.dispatch(Product {
                cell: &self.cells[cell],
                values: &values,
                rows,
            });
            let CellValues {
                coarse, bubbles, ..
            } = &values;
            let [to_nodes, to_bubbles] = [&mut rows.coarse.nodes, &mut rows.bubbles];
            let of_cell = (&coarse.nodes, bubbles);
            self.add_varying_stress(cell, stress, of_cell, to_nodes, Some(to_bubbles));
        };
        accumulate(mesh.n_cells(), of_cell, |cell, rows| {
            self.add_to_coarse(cell, &rows.coarse, &mut product);
            self.add_to_bubbles(cell, &rows.bubbles, rows_of_extension);
            for (edge, value) in self.edge_numbers(cell).into_iter().zip(rows.edges) {
                rows_of_extension[edge] += value;
            }
        });
        self.constrain(rows_of_extension);
        Ok(product)
    }

    /// Rows of quadratic velocities and linear pressures of a product with the extension alone.
    ///
    /// The rows of the extension are left out. Cost: a third of [`product`](Self::product).
    ///
    /// # Errors
    /// An array of the wrong length.
    pub fn coarse_rows(&self, extension: &[f64]) -> Result<CubicProduct, FemError> {
        check_length("the extension", extension.len(), self.len())?;
        let extension = &*self.completed(extension);
        let mut product = self.zero_coarse_product();
        let arch = Arch::new();
        let of_cell = |cell: usize, rows: &mut CoarseValues| {
            let bubbles = self.bubbles_of(cell, extension);
            let edges = self.edges_of(cell, extension);
            arch.dispatch(CoarseRows {
                cell: &self.cells[cell],
                bubbles: &bubbles,
                edges: &edges,
                rows,
            });
            let of_cell = (&Vectors::default(), &bubbles);
            self.add_varying_stress(cell, StressOf::Derivative, of_cell, &mut rows.nodes, None);
        };
        accumulate(self.mesh.n_cells(), of_cell, |cell, rows| {
            self.add_to_coarse(cell, rows, &mut product);
        });
        Ok(product)
    }

    /// Writes the rows of the bubbles of a product with the pressures of the extension alone.
    ///
    /// They take the place of the dofs of the bubbles, which are not read. Cost: a tenth of
    /// [`product`](Self::product).
    ///
    /// # Errors
    /// An array of the wrong length.
    pub fn gradient(&self, extension: &mut [f64]) -> Result<(), FemError> {
        check_length("the extension", extension.len(), self.len())?;
        if let Some(part) = &self.space.part {
            part.update(extension);
        }
        let first = self.first_pressure();
        let (bubbles, pressures) = extension.split_at_mut(first);
        bubbles.fill(0.0);
        let arch = Arch::new();
        let of_cell = |cell: usize, rows: &mut Vectors| {
            let edges = self.edge_numbers(cell).map(|edge| pressures[edge - first]);
            arch.dispatch(Gradient {
                cell: &self.cells[cell],
                edges: &edges,
                rows,
            });
        };
        accumulate(self.mesh.n_cells(), of_cell, |cell, rows| {
            self.add_to_bubbles(cell, rows, bubbles);
        });
        self.constrain(extension);
        Ok(())
    }

    /// Adds what a viscosity that varies has in addition to `∇u`, in the rows of nodes and bubbles.
    fn add_varying_stress(
        &self,
        cell: usize,
        stress: StressOf,
        (nodes, bubbles): (&Vectors, &Vectors),
        to_nodes: &mut Vectors,
        mut to_bubbles: Option<&mut Vectors>,
    ) {
        let Some(viscosity) = self.viscosity else {
            return;
        };
        let positions = self.mesh.cell_points(cell);
        let [nodes, bubbles] = [nodes, bubbles].map(vectors);
        for (point, at) in rule().iter().zip(viscosity.of_cell(cell)) {
            // cells were checked by the constructor
            let Ok(map) = MapAt::new(cell, &positions, point.at) else {
                continue;
            };
            let gradients = map.gradients(point.at);
            let of_nodes = gradient_of(&nodes, &gradients);
            let of_bubbles = map.gradient(&gradient_of(&bubbles, &point.gradients));
            let all = of_nodes + of_bubbles;
            // the Taylor-Hood equations have the rows of nodes for velocities of nodes
            let [for_nodes, for_bubbles] = match stress {
                StressOf::Derivative => [at.derivative(&of_bubbles), at.derivative(&all)],
                StressOf::Flow => {
                    let stress = at.changed(viscosity.law(), &of_bubbles);
                    [stress - at.stress(), stress]
                }
            };
            let for_nodes = (for_nodes - of_bubbles) * map.measure;
            for (k, gradient) in gradients.iter().enumerate() {
                let row = for_nodes * gradient;
                (0..3).for_each(|c| to_nodes[c][k] += row[c]);
            }
            if let Some(to_bubbles) = &mut to_bubbles {
                let pulled = map.pulled_back(&(for_bubbles - all)) * map.measure;
                for (k, gradient) in point.gradients.iter().enumerate() {
                    let row = pulled * gradient;
                    (0..3).for_each(|c| to_bubbles[c][k] += row[c]);
                }
            }
        }
    }

    /// Coefficients of the bubbles of a cell, in its own orientation.
    pub(super) fn bubbles_of(&self, cell: usize, extension: &[f64]) -> Vectors {
        let nodes = &self.mesh.cells()[cell];
        let mut values = [[0.0; BUBBLES_PER_CELL]; 3];
        let bubbles = self.space.bubbles.of_cell(cell, nodes).into_iter();
        for (k, (bubble, sign)) in bubbles.zip(signs(nodes)).enumerate() {
            for (c, values) in values.iter_mut().enumerate() {
                values[k] = sign * extension[3 * bubble + c];
            }
        }
        values
    }

    /// Pressures of the edges of a cell.
    pub(super) fn edges_of(&self, cell: usize, extension: &[f64]) -> [f64; 6] {
        self.edge_numbers(cell).map(|edge| extension[edge])
    }

    /// Dofs of the pressures of the edges of a cell.
    fn edge_numbers(&self, cell: usize) -> [usize; 6] {
        let (nodes, first) = (&self.mesh.cells()[cell], self.first_pressure());
        std::array::from_fn(|k| first + nodes[4 + k] as usize - self.mesh.n_vertices())
    }

    fn add_to_coarse(&self, cell: usize, rows: &CoarseValues, product: &mut CubicProduct) {
        let nodes = &self.mesh.cells()[cell];
        let [x, y, z] = &rows.nodes;
        for (k, &node) in nodes.iter().enumerate() {
            product.velocity[node as usize] += Vec3::new(x[k], y[k], z[k]);
        }
        for (&vertex, value) in nodes[..4].iter().zip(rows.linear) {
            product.pressure[vertex as usize] += value;
        }
    }

    fn add_to_bubbles(&self, cell: usize, rows: &Vectors, extension: &mut [f64]) {
        let nodes = &self.mesh.cells()[cell];
        let bubbles = self.space.bubbles.of_cell(cell, nodes).into_iter();
        for (k, (bubble, sign)) in bubbles.zip(signs(nodes)).enumerate() {
            let sums = &mut extension[3 * bubble..3 * bubble + 3];
            for (sum, rows) in sums.iter_mut().zip(rows) {
                *sum += sign * rows[k];
            }
        }
    }

    /// A vector with the entries of other processes.
    pub(super) fn completed<'v>(&self, extension: &'v [f64]) -> Cow<'v, [f64]> {
        match &self.space.part {
            None => Cow::Borrowed(extension),
            Some(part) => {
                let mut all = extension.to_vec();
                part.update(&mut all);
                Cow::Owned(all)
            }
        }
    }

    /// The part of this process, if the mesh is divided between several.
    pub(super) fn part(&self) -> Option<&SurplusPart> {
        self.space.part.as_ref()
    }

    /// Sets the rows of constrained components, and those of other processes, to zero.
    fn constrain(&self, extension: &mut [f64]) {
        if let Some(part) = &self.space.part {
            part.zero_others(extension);
        }
        let bubbles = extension[..self.first_pressure()].as_chunks_mut().0;
        for (bubble, value) in bubbles.iter_mut().enumerate() {
            let free = (self.space.bubbles).without_constrained(bubble, Vec3::from(*value));
            *value = free.into();
        }
    }
}

impl CubicExtension<'_> {
    /// Power of the forces of a flow in the motion `test` of the boundary.
    ///
    /// ```text
    /// P = ∫ 2 η D(u):D(v) - ∫ p ∇·v
    /// ```
    ///
    /// The viscosity is 1 unless it varies; the flow then includes the background flow. As
    /// [`power`](crate::power) for functions of the next degree; the pressures of `test` are not
    /// used. Cost: one pass over the cells at the boundary.
    ///
    /// # Errors
    /// Arrays of the wrong length or not finite; [`FemError::InvertedCell`].
    pub fn power(&self, flow: CubicFlow<'_>, test: CubicFlow<'_>) -> Result<f64, FemError> {
        let mesh = self.mesh();
        for field in [&flow, &test] {
            check_vectors("the velocity", field.velocity, mesh.n_points())?;
            check_length("the extension", field.extension.len(), self.len())?;
        }
        check_array("the pressure", flow.pressure, mesh.n_vertices())?;
        let extensions = [flow, test].map(|field| self.completed(field.extension));
        let [mut power] = sum_over(mesh.cells().len(), |cell| {
            if self.part().is_some_and(|part| !part.owns_cell(cell)) {
                return Ok([0.0]);
            }
            let nodes = &mesh.cells()[cell];
            let bubbles =
                (extensions.each_ref()).map(|extension| vectors(&self.bubbles_of(cell, extension)));
            let is_at_rest = |node: &u32| test.velocity[*node as usize] == Vec3::zeros();
            if nodes.iter().all(is_at_rest) && bubbles[1] == [Vec3::zeros(); 10] {
                return Ok([0.0]);
            }
            let positions = mesh.cell_points(cell);
            let edges = self.edges_of(cell, &extensions[0]);
            let mut sum = 0.0;
            for point in rule() {
                let map = MapAt::new(cell, &positions, point.at)?;
                let gradients = map.gradients(point.at);
                let [u, v] = [(flow, &bubbles[0]), (test, &bubbles[1])].map(|(field, bubbles)| {
                    let of_bubbles = gradient_of(bubbles, &point.gradients);
                    gradient_in_cell(nodes, field.velocity, &gradients) + map.gradient(&of_bubbles)
                });
                let l = &point.at.barycentric;
                let linear = l.iter().zip(nodes);
                let linear = linear.map(|(l, &vertex)| l * flow.pressure[vertex as usize]);
                let quadratic = edges.iter().zip(TET_EDGES);
                let quadratic = quadratic.map(|(value, [a, b])| value * l[a] * l[b]);
                let p: f64 = linear.chain(quadratic).sum();
                let twice_rate = u + u.transpose();
                let viscosity = self.viscosity.map_or(1.0, |v| v.at(&twice_rate));
                sum += map.measure * (viscosity * twice_rate.dot(&v) - p * v.trace());
            }
            Ok([sum])
        })?;
        if let Some(part) = self.part() {
            part.sum(std::slice::from_mut(&mut power));
        }
        check_array("the power", &[power], 1)?;
        Ok(power)
    }
}
