//! The equations of Stokes flow in cubic velocities and quadratic pressures.

use mesh::{Facet, TetMesh, Vec3};
use nalgebra::Matrix3;
use rayon::prelude::*;

use super::bubbles::{PER_CELL, signs};
use super::cubic_tables::{
    AffineCell, CurvedCell, Divergence, PRESSURES, Square, Stiffness, VELOCITIES,
    reference_divergence,
};
use super::surplus::SurplusSpace;
use crate::FemError;
use crate::check::{check_array, check_length, check_vectors};
use crate::geometry::Affine;
use crate::sum::{CELLS_PER_TASK, accumulate};

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
/// Memory: 12 kB per curved cell and 140 bytes per affine one. Dofs of the extension are three
/// components of each bubble and then one pressure per edge. Those that the boundary prescribes are
/// zero in all rows; in a vector they are zero, or the velocity of a surface
/// ([`interpolate`](Self::interpolate)).
pub struct CubicExtension<'a> {
    space: &'a SurplusSpace,
    mesh: &'a TetMesh,
    cells: Vec<Cell>,
    diagonal: Vec<f64>,
}

/// Element matrices of a cell.
enum Cell {
    Affine(AffineCell),
    Curved(Box<CurvedCell>),
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

/// Which blocks of the matrix a product needs.
#[derive(Clone, Copy, PartialEq)]
enum Rows {
    /// All but the block of the Taylor-Hood elements.
    All,
    /// Those of the Taylor-Hood elements, from the extension.
    Coarse,
    /// Those of the bubbles, from pressures of the extension.
    Bubbles,
}

/// Values of one cell: components of velocities, and pressures.
struct Local {
    velocity: [[f64; VELOCITIES]; 3],
    pressure: [f64; PRESSURES],
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
                true => Cell::Affine(AffineCell::new(&Affine::new(cell, &points)?)),
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
        };
        extension.diagonal = extension.compute_diagonal();
        Ok(extension)
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

    /// `∫ |∇φ|^2` for the components of the bubbles, then `∫ ψ^2` for the pressures.
    ///
    /// The diagonal of the matrix for velocities; for pressures that of the mass matrix, to which
    /// minus the Schur complement is spectrally equivalent.
    pub fn diagonal(&self) -> &[f64] {
        &self.diagonal
    }

    fn n_edges(&self) -> usize {
        self.mesh.n_points() - self.mesh.n_vertices()
    }

    fn compute_diagonal(&self) -> Vec<f64> {
        let mut diagonal = vec![0.0; self.len()];
        let (nodes, first_pressure) = (self.mesh.n_vertices(), self.first_pressure());
        for (number, cell) in self.cells.iter().enumerate() {
            let (energies, masses) = match cell {
                Cell::Affine(cell) => cell.diagonals(),
                Cell::Curved(cell) => cell.diagonals(),
            };
            let cell_nodes = &self.mesh.cells()[number];
            let bubbles = self.space.bubbles.of_cell(number, cell_nodes);
            for (bubble, energy) in bubbles.into_iter().zip(energies) {
                for value in &mut diagonal[3 * bubble..3 * bubble + 3] {
                    *value += energy;
                }
            }
            for (&node, mass) in cell_nodes[4..].iter().zip(masses) {
                diagonal[first_pressure + node as usize - nodes] += mass;
            }
        }
        diagonal
    }

    /// Product with a flow, without the block of quadratic velocities and linear pressures.
    ///
    /// Shapes: `velocity` `n_points`, `pressure` `n_vertices`, `extension` [`len`](Self::len). With
    /// a zero `extension` the rows of the extension are the residual of the flow there.
    ///
    /// Cost: one pass over the cells, about 4300 multiplications each. The same for any number of
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
        check_vectors("the velocity", velocity, self.mesh.n_points())?;
        check_array("the pressure", pressure, self.mesh.n_vertices())?;
        self.rows(Rows::All, Some((velocity, pressure)), extension)
    }

    /// Rows of quadratic velocities and linear pressures of a product with the extension alone.
    ///
    /// The rows of the extension are left out. Cost: a third of [`product`](Self::product).
    ///
    /// # Errors
    /// An array of the wrong length.
    pub fn coarse_rows(&self, extension: &[f64]) -> Result<CubicProduct, FemError> {
        self.rows(Rows::Coarse, None, extension)
    }

    /// Rows of the bubbles of a product with the pressures of the extension alone.
    ///
    /// All other rows are left out or zero. Cost: a quarter of [`product`](Self::product).
    ///
    /// # Errors
    /// An array of the wrong length.
    pub fn gradient(&self, extension: &[f64]) -> Result<CubicProduct, FemError> {
        self.rows(Rows::Bubbles, None, extension)
    }

    fn rows(
        &self,
        rows: Rows,
        flow: Option<(&[Vec3], &[f64])>,
        extension: &[f64],
    ) -> Result<CubicProduct, FemError> {
        let mesh = self.mesh;
        check_length("the extension", extension.len(), self.len())?;
        let first_pressure = self.first_pressure();
        let (to_coarse, to_extension) = (rows != Rows::Bubbles, rows != Rows::Coarse);
        let zeros = |wanted: bool, length: usize| vec![0.0; if wanted { length } else { 0 }];
        let nodes = if to_coarse { mesh.n_points() } else { 0 };
        let mut product = CubicProduct {
            velocity: vec![Vec3::zeros(); nodes],
            pressure: zeros(to_coarse, mesh.n_vertices()),
            extension: zeros(to_extension, self.len()),
        };
        let of_cell = |cell| self.multiply(rows, cell, &self.gather(cell, flow, extension));
        accumulate(mesh, of_cell, |cell, local| {
            let nodes = &mesh.cells()[cell];
            let [x, y, z] = &local.velocity;
            if to_coarse {
                for (k, &node) in nodes.iter().enumerate() {
                    product.velocity[node as usize] += Vec3::new(x[k], y[k], z[k]);
                }
                for (&vertex, value) in nodes[..4].iter().zip(local.pressure) {
                    product.pressure[vertex as usize] += value;
                }
            }
            if to_extension {
                let bubbles = self.space.bubbles.of_cell(cell, nodes);
                for (k, (bubble, sign)) in bubbles.into_iter().zip(signs(nodes)).enumerate() {
                    let k = 10 + k;
                    let value = sign * Vec3::new(x[k], y[k], z[k]);
                    let value = self.space.bubbles.without_constrained(bubble, value);
                    for axis in 0..3 {
                        product.extension[3 * bubble + axis] += value[axis];
                    }
                }
            }
            if rows == Rows::All {
                for (&node, value) in nodes[4..].iter().zip(&local.pressure[4..]) {
                    let edge = node as usize - mesh.n_vertices();
                    product.extension[first_pressure + edge] += value;
                }
            }
        });
        Ok(product)
    }

    fn gather(&self, cell: usize, flow: Option<(&[Vec3], &[f64])>, extension: &[f64]) -> Local {
        let nodes = &self.mesh.cells()[cell];
        let bubbles = self.space.bubbles.of_cell(cell, nodes);
        let signs = signs(nodes);
        let first_edge = self.first_pressure();
        let mut local = Local {
            velocity: [[0.0; VELOCITIES]; 3],
            pressure: [0.0; PRESSURES],
        };
        for (c, values) in local.velocity.iter_mut().enumerate() {
            if let Some((velocity, _)) = flow {
                for (value, &node) in values.iter_mut().zip(nodes) {
                    *value = velocity[node as usize][c];
                }
            }
            for k in 0..PER_CELL {
                values[10 + k] = signs[k] * extension[3 * bubbles[k] + c];
            }
        }
        if let Some((_, pressure)) = flow {
            for (value, &vertex) in local.pressure.iter_mut().zip(&nodes[..4]) {
                *value = pressure[vertex as usize];
            }
        }
        for (value, &node) in local.pressure[4..].iter_mut().zip(&nodes[4..]) {
            *value = extension[first_edge + node as usize - self.mesh.n_vertices()];
        }
        local
    }

    fn multiply(&self, rows: Rows, cell: usize, local: &Local) -> Local {
        let mut result = Local {
            velocity: [[0.0; VELOCITIES]; 3],
            pressure: [0.0; PRESSURES],
        };
        match &self.cells[cell] {
            Cell::Curved(cell) => {
                let identity = Matrix3::identity();
                add_stiffness(rows, &cell.stiffness, local, &mut result);
                add_divergence(rows, &cell.divergence, &identity, local, &mut result);
            }
            Cell::Affine(cell) => {
                match rows {
                    Rows::All => {
                        add_stiffness(rows, &Stiffness::affine(cell), local, &mut result);
                    }
                    Rows::Coarse => {
                        let to_nodes = Stiffness::affine_to_nodes(cell);
                        add_to_nodes(&to_nodes, local, &mut result);
                    }
                    Rows::Bubbles => {}
                }
                add_divergence(rows, reference_divergence(), &cell.pull, local, &mut result);
            }
        }
        result
    }
}

fn add_stiffness(rows: Rows, stiffness: &Stiffness, local: &Local, result: &mut Local) {
    if rows == Rows::Bubbles {
        return;
    }
    add_to_nodes(&stiffness.to_nodes, local, result);
    if rows == Rows::Coarse {
        return;
    }
    for (sums, values) in result.velocity.iter_mut().zip(&local.velocity) {
        let of_bubbles = &mut sums[10..];
        let (nodes, bubbles) = values.split_at(10);
        for k in 0..10 {
            add(of_bubbles, bubbles[k], &stiffness.bubbles[k]);
            add(of_bubbles, nodes[k], &stiffness.from_nodes[k]);
        }
    }
}

fn add_to_nodes(to_nodes: &Square, local: &Local, result: &mut Local) {
    for (sums, values) in result.velocity.iter_mut().zip(&local.velocity) {
        for k in 0..10 {
            add(&mut sums[..10], values[10 + k], &to_nodes[k]);
        }
    }
}

/// Adds the terms of the divergence; `pull` maps the components of its table to velocities.
fn add_divergence(
    rows: Rows,
    divergence: &Divergence,
    pull: &Matrix3<f64>,
    local: &Local,
    result: &mut Local,
) {
    for d in 0..3 {
        // the component along the reference coordinate d
        if rows != Rows::Bubbles {
            let mut pulled = [0.0; VELOCITIES];
            for c in 0..3 {
                add(&mut pulled, pull[(c, d)], &local.velocity[c]);
            }
            for (value, row) in pulled.iter().zip(&divergence.by_velocity[d]) {
                add(&mut result.pressure, -value, row);
            }
        }
        let mut gradient = [0.0; VELOCITIES];
        for (value, table) in local.pressure.iter().zip(&divergence.by_pressure) {
            add(&mut gradient, -value, &table[d]);
        }
        for c in 0..3 {
            add(&mut result.velocity[c], pull[(c, d)], &gradient);
        }
    }
}

/// `sums += factor * values`.
#[inline(always)]
fn add(sums: &mut [f64], factor: f64, values: &[f64]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += factor * value;
    }
}
