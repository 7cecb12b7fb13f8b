//! Fields of the whole mesh from those of the processes.

use mesh::{Submesh, TetMesh};
use nalgebra::Vector3;
use stokes::{Gather, StokesError};

use crate::PetscError;
use crate::handles::{Session, Vector};
use crate::partition::Partition;

/// Gathers fields on all processes: 8 bytes per number on each of them.
pub struct Fields<'a> {
    mesh: &'a TetMesh,
    partition: &'a Partition,
    submesh: &'a Submesh,
    rank: usize,
}

impl<'a> Fields<'a> {
    /// Fields of `mesh`, of which process `rank` has `submesh`.
    pub fn new(
        mesh: &'a TetMesh,
        partition: &'a Partition,
        submesh: &'a Submesh,
        rank: usize,
    ) -> Self {
        Self {
            mesh,
            partition,
            submesh,
            rank,
        }
    }

    /// Arrays of `N` numbers for `0..len` of the whole mesh, from those of this process.
    ///
    /// `own` are the arrays of the items that `owner` assigns to this process, ascending.
    fn of_all<const N: usize>(
        &self,
        len: usize,
        owner: impl Fn(usize) -> usize,
        own: impl Iterator<Item = [f64; N]>,
    ) -> Result<Vec<[f64; N]>, StokesError> {
        let own: Vec<f64> = own.flatten().collect();
        let all = Session::with_current(|session| Vector::from_slice(session, &own)?.of_all());
        let all = all.map_err(engine_error)?;
        let mut by_owner: Vec<u32> = (0..len as u32).collect();
        by_owner.sort_by_key(|&item| owner(item as usize));
        let mut values = vec![[0.0; N]; len];
        for (&item, value) in by_owner.iter().zip(all.as_chunks().0) {
            values[item as usize] = *value;
        }
        Ok(values)
    }

    /// Arrays for the first `len` nodes of the whole mesh.
    fn of_nodes<const N: usize>(
        &self,
        len: usize,
        part: impl Iterator<Item = [f64; N]>,
    ) -> Result<Vec<[f64; N]>, StokesError> {
        let owner = |node: usize| self.partition.owner(node as u32);
        let nodes = part.zip(&self.submesh.nodes);
        let own = nodes.filter(|(_, node)| owner(**node as usize) == self.rank);
        self.of_all(len, owner, own.map(|(value, _)| value))
    }

    /// Process to which a cell with these nodes of the whole mesh belongs.
    fn owner_of_cell(&self, cell: &[u32; 10]) -> usize {
        let vertices = cell[..4].iter();
        self.partition
            .owner(vertices.min().copied().unwrap_or_default())
    }
}

/// An error of this crate as one of `stokes`.
pub fn engine_error(error: PetscError) -> StokesError {
    StokesError::Engine(error.into())
}

impl Gather for Fields<'_> {
    fn nodes(&self, part: &[Vector3<f64>]) -> Result<Vec<Vector3<f64>>, StokesError> {
        let values = self.of_nodes(self.mesh.n_points(), part.iter().map(|v| (*v).into()))?;
        Ok(values.into_iter().map(Vector3::from).collect())
    }

    fn vertices(&self, part: &[f64]) -> Result<Vec<f64>, StokesError> {
        let values = self.of_nodes(self.mesh.n_vertices(), part.iter().map(|value| [*value]))?;
        Ok(values.into_iter().flatten().collect())
    }

    fn cells(&self, part: &[f64]) -> Result<Vec<f64>, StokesError> {
        let cells = self.mesh.cells();
        let is_own = |cell: &[u32; 10]| self.owner_of_cell(cell) == self.rank;
        let kept = cells
            .iter()
            .filter(|cell| self.partition.assembles(self.rank, cell));
        let own = kept.zip(part).filter(|(cell, _)| is_own(cell));
        let owner = |cell: usize| self.owner_of_cell(&cells[cell]);
        let values = self.of_all(cells.len(), owner, own.map(|(_, value)| [*value]))?;
        Ok(values.into_iter().flatten().collect())
    }
}
