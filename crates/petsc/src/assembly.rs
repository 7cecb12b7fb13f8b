//! The system of one process in PETSc's matrices.

use linalg::Csr;
use mesh::Submesh;
use rigid::Constrained;

use crate::PetscError;
use crate::ffi::Int;
use crate::handles::{Matrix, Rows, Session, Vector};
use crate::numbering::Numbering;

/// The blocks of a distributed system, and the prolongation to its velocities.
///
/// ```text
/// [ A  B^T ]    A: velocities and border     M: pressure mass matrix
/// [ B   0  ]    P: from linear elements and the border
/// ```
pub struct Blocks<'s> {
    pub motion: Matrix<'s>,
    pub divergence: Matrix<'s>,
    pub pressure_mass: Matrix<'s>,
    /// Laplacian of the pressure in narrow gaps and channels.
    pub pressure_laplacian: Option<Matrix<'s>>,
    pub prolongation: Matrix<'s>,
    /// Sizes of the rows of both fields, by which residuals are weighted; see
    /// [`SaddleSystem`](linalg::SaddleSystem).
    pub sizes: [Vec<f64>; 2],
}

/// The system that one process has assembled, with the numbers of its degrees of freedom.
pub struct Part<'a> {
    pub system: &'a Constrained,
    pub submesh: &'a Submesh,
    pub numbering: &'a Numbering,
    /// Whether this process owns each node of the submesh.
    pub owned: &'a [bool],
}

impl Part<'_> {
    /// Copies the rows of this process into distributed matrices.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn blocks<'s>(&self, session: &'s Session) -> Result<Blocks<'s>, PetscError> {
        let columns = self.numbering.own_motion().len();
        let matrix = |rows: &Rows, columns| Matrix::from_rows(session, rows, columns);
        let border = self.border_rows(session)?;
        let motion = matrix(&self.motion_rows(&border)?, columns)?;
        drop(border);
        Ok(Blocks {
            motion,
            divergence: matrix(&self.divergence_rows()?, columns)?,
            pressure_mass: matrix(&self.mass_rows()?, self.numbering.own_pressure().len())?,
            pressure_laplacian: None,
            prolongation: matrix(
                &self.prolongation_rows()?,
                self.numbering.own_coarse().len(),
            )?,
            sizes: self.sizes(),
        })
    }

    /// Number in the mesh of each free node of the part, in the order of its rows.
    fn free_nodes(&self) -> impl Iterator<Item = (usize, u32)> {
        let nodes = self.system.free_nodes().iter().enumerate();
        nodes.map(|(row, &node)| (row, self.submesh.nodes[node as usize]))
    }

    /// Free nodes that this process owns, with their rows.
    fn own_free_nodes(&self) -> impl Iterator<Item = (usize, u32)> {
        let nodes = self.system.free_nodes().iter();
        let owned = nodes.map(|&node| self.owned[node as usize]);
        let free = self.free_nodes().zip(owned);
        free.filter_map(|(row, owned)| owned.then_some(row))
    }

    /// Vertices that this process owns, with their rows.
    pub fn own_vertices(&self) -> impl Iterator<Item = (usize, u32)> {
        let vertices = self.submesh.nodes[..self.submesh.mesh.n_vertices()].iter();
        let vertices = vertices.copied().enumerate();
        vertices.filter(|(row, _)| self.owned[*row])
    }

    /// Velocities that this process owns: row of the node, number in the mesh, component.
    fn own_velocities(&self) -> impl Iterator<Item = (usize, u32, usize)> {
        self.own_free_nodes().flat_map(|(row, node)| {
            let bits = self.numbering.components(node);
            let axes = (0..3).filter(move |axis| bits >> axis & 1 == 1);
            axes.map(move |axis| (row, node, axis))
        })
    }

    /// Entries of each column of the border at the velocities of all processes. They become rows of
    /// the first process.
    ///
    /// They are gathered here: `MatTranspose` would insert the entries of other processes one by
    /// one into long rows, in quadratic time (25 s at two million dofs on four processes).
    fn border_rows(&self, session: &Session) -> Result<Vec<Vec<(Int, f64)>>, PetscError> {
        let border = self.system.system.velocity_block().border();
        let own: Vec<(Int, usize, f64)> = self
            .own_velocities()
            .filter_map(|(row, node, axis)| Some((row, self.numbering.velocity(node, axis)?, axis)))
            .flat_map(|(row, number, axis)| {
                entries(border, 3 * row + axis).map(move |(column, value)| (number, column, value))
            })
            .collect();
        let of_all = |numbers: Vec<f64>| Vector::from_slice(session, &numbers)?.of_all();
        let numbers = of_all(own.iter().map(|(number, ..)| *number as f64).collect())?;
        let columns = of_all(own.iter().map(|(_, column, _)| *column as f64).collect())?;
        let values = of_all(own.iter().map(|(.., value)| *value).collect())?;
        let mut rows = vec![Vec::new(); self.numbering.border_len()];
        for ((number, column), value) in numbers.into_iter().zip(columns).zip(values) {
            rows[column as usize].push((number as Int, value));
        }
        Ok(rows)
    }

    /// Rows of `A`: `[K (x) I3, C]` for velocities, `[C^T, M]` for the border.
    fn motion_rows(&self, border_rows: &[Vec<(Int, f64)>]) -> Result<Rows, PetscError> {
        let (numbering, block) = (self.numbering, self.system.system.velocity_block());
        let node_of: Vec<u32> = self.free_nodes().map(|(_, node)| node).collect();
        let mut rows = Rows::default();
        for (row, _, axis) in self.own_velocities() {
            for (column, value) in entries(block.stiffness(), row) {
                if let Some(number) = numbering.velocity(node_of[column], axis) {
                    rows.push(number, value);
                }
            }
            for (column, value) in entries(block.border(), 3 * row + axis) {
                rows.push(numbering.border(column), value);
            }
            rows.end_row()?;
        }
        for (border, entries) in border_rows.iter().enumerate().take(numbering.own_border()) {
            for &(column, value) in entries {
                rows.push(column, value);
            }
            for (other, &value) in block.corner().row(border).iter().enumerate() {
                rows.push(numbering.border(other), value);
            }
            rows.end_row()?;
        }
        Ok(rows)
    }

    /// Rows of `B` with those of the border.
    fn divergence_rows(&self) -> Result<Rows, PetscError> {
        let (numbering, system) = (self.numbering, &self.system.system);
        let node_of: Vec<u32> = self.free_nodes().map(|(_, node)| node).collect();
        let mut rows = Rows::default();
        for (row, _) in self.own_vertices() {
            let divergence = system.divergence().outer_view(row);
            for (column, values) in divergence.iter().flat_map(|row| row.iter()) {
                for (axis, &value) in values.iter().enumerate() {
                    if let Some(number) = numbering.velocity(node_of[column], axis) {
                        rows.push(number, value);
                    }
                }
            }
            for (column, value) in entries(system.border_divergence(), row) {
                rows.push(numbering.border(column), value);
            }
            rows.end_row()?;
        }
        Ok(rows)
    }

    /// Rows of the pressure mass matrix.
    fn mass_rows(&self) -> Result<Rows, PetscError> {
        let mut rows = Rows::default();
        for (row, _) in self.own_vertices() {
            for (column, value) in entries(self.system.system.pressure_mass(), row) {
                rows.push(self.numbering.pressure(self.submesh.nodes[column]), value);
            }
            rows.end_row()?;
        }
        Ok(rows)
    }

    /// Rows of the prolongation `[P (x) I3, Q; 0, I]`.
    fn prolongation_rows(&self) -> Result<Rows, PetscError> {
        let (numbering, prolongation) = (self.numbering, &self.system.prolongation);
        let vertices = self.submesh.mesh.n_vertices();
        let mut free: Vec<u32> = (self.system.free_nodes().iter().copied())
            .filter(|&node| (node as usize) < vertices)
            .collect();
        free.sort_unstable();
        let mut rows = Rows::default();
        for (row, _, axis) in self.own_velocities() {
            for (column, value) in entries(prolongation.nodes(), row) {
                let vertex = self.submesh.nodes[free[column] as usize];
                if let Some(number) = numbering.coarse_velocity(vertex, axis) {
                    rows.push(number, value);
                }
            }
            for (column, value) in entries(prolongation.border(), 3 * row + axis) {
                rows.push(numbering.coarse_border(column), value);
            }
            rows.end_row()?;
        }
        for border in 0..numbering.own_border() {
            rows.push(numbering.coarse_border(border), 1.0);
            rows.end_row()?;
        }
        Ok(rows)
    }

    /// Diagonals of `K` and of the mass matrix, and the largest entries of the corner's rows.
    fn sizes(&self) -> [Vec<f64>; 2] {
        let system = &self.system.system;
        let block = system.velocity_block();
        let diagonal = |matrix: &Csr, row| matrix.get(row, row).copied().unwrap_or(1.0);
        let border = block.corner().row_iter().map(|row| match row.amax() {
            0.0 => 1.0,
            largest => largest,
        });
        let velocities = self.own_velocities();
        [
            (velocities.map(|(row, ..)| diagonal(block.stiffness(), row)))
                .chain(border.take(self.numbering.own_border()))
                .collect(),
            (self.own_vertices())
                .map(|(row, _)| diagonal(system.pressure_mass(), row))
                .collect(),
        ]
    }

    /// Positions of the entries of this process in a vector of its part: motion, then pressure.
    pub fn own_entries(&self) -> OwnEntries {
        let system = &self.system.system;
        let border = system.border_range().take(self.numbering.own_border());
        let pressures = system.pressure_range().start;
        let positions = (self.own_velocities())
            .map(|(row, _, axis)| 3 * row + axis)
            .chain(border)
            .chain(self.own_vertices().map(|(row, _)| pressures + row));
        OwnEntries {
            positions: positions.map(|position| position as u32).collect(),
            len: system.pressure_range().end,
        }
    }
}

/// The entries of a process in the vectors of its part, in the order of PETSc's vectors.
pub struct OwnEntries {
    positions: Vec<u32>,
    /// Length of a vector of the part.
    len: usize,
}

impl OwnEntries {
    /// Length of a vector of the part.
    pub fn len(&self) -> usize {
        self.len
    }

    /// The own entries of a vector of the part.
    pub fn of(&self, vector: &[f64]) -> Vec<f64> {
        (self.positions.iter())
            .map(|&position| vector[position as usize])
            .collect()
    }

    /// Writes a vector of the part with these own entries; zero for those of other processes.
    pub fn write(&self, own: &[f64], vector: &mut [f64]) {
        vector.fill(0.0);
        for (&position, value) in self.positions.iter().zip(own) {
            vector[position as usize] = *value;
        }
    }
}

/// Columns and values of a row.
pub fn entries(matrix: &Csr, row: usize) -> impl Iterator<Item = (usize, f64)> {
    let view = matrix.outer_view(row);
    let row: Vec<(usize, f64)> = (view.iter().flat_map(|row| row.iter()))
        .map(|(column, &value)| (column, value))
        .collect();
    row.into_iter()
}

impl<'s> Blocks<'s> {
    /// Scales both fields symmetrically by the square roots of the row sizes.
    ///
    /// In the scaled system the Euclidean norm of the residual is the weighted one, by which
    /// velocities converge; see
    /// [`residual_weights`](linalg::LinearOperator::residual_weights). Returns the reciprocal
    /// square roots.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn scale(&mut self, session: &'s Session) -> Result<[Vec<f64>; 2], PetscError> {
        let factors = (self.sizes.each_ref())
            .map(|sizes| -> Vec<f64> { sizes.iter().map(|size| size.sqrt().recip()).collect() });
        let motion = Vector::from_slice(session, &factors[0])?;
        let pressure = Vector::from_slice(session, &factors[1])?;
        let inverse: Vec<f64> = factors[0].iter().map(|factor| factor.recip()).collect();
        let inverse = Vector::from_slice(session, &inverse)?;
        self.motion.scale(Some(&motion), Some(&motion))?;
        self.divergence.scale(Some(&pressure), Some(&motion))?;
        self.pressure_mass.scale(Some(&pressure), Some(&pressure))?;
        if let Some(laplacian) = &mut self.pressure_laplacian {
            laplacian.scale(Some(&pressure), Some(&pressure))?;
        }
        self.prolongation.scale(Some(&inverse), None)?;
        Ok(factors)
    }
}
