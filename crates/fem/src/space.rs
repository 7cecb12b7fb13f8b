//! The Taylor-Hood space of a mesh: the data that depends on the connectivity alone.

use linalg::Csr;
use mesh::{TET_EDGES, TetMesh};
use rayon::prelude::*;

use crate::FemError;
use crate::pattern::Pattern;

/// Taylor-Hood space of a mesh: continuous quadratic velocity and continuous linear pressure.
///
/// The velocity has one nodal value (a 3-vector) per point of the mesh, the pressure one per
/// vertex. Matrices cover all nodes; essential boundary conditions are imposed afterwards
/// ([`DirichletCondition`](crate::DirichletCondition)).
///
/// The space stores what depends on the connectivity alone: the sparsity patterns, and the position
/// of every entry of an element matrix in them. A mesh whose points move is therefore assembled
/// again at little cost. Assembly takes the mesh with its current points; it is an error
/// ([`FemError::OtherMesh`]) if the cells differ from those for which the space was built.
///
/// Memory: about 240 bytes per cell besides the sparsity pattern itself. Every matrix is bitwise
/// the same for any number of threads: an entry is the sum over its cells in ascending order.
pub struct TaylorHood {
    pub(crate) pattern: Pattern,
    pub(crate) vertex_row_starts: Vec<usize>,
    pub(crate) vertex_columns: Vec<u32>,
    n_vertices: usize,
    n_points: usize,
    n_cells: usize,
    fingerprint: u64,
}

impl TaylorHood {
    /// Builds the sparsity patterns for `mesh`.
    ///
    /// Cost: about that of assembling each matrix once.
    ///
    /// # Errors
    /// [`FemError::TooLarge`] for more than 2^28 cells or 65535 neighbours of a node.
    pub fn new(mesh: &TetMesh) -> Result<Self, FemError> {
        let pattern = Pattern::new(mesh)?;
        let n_vertices = mesh.n_vertices();
        let (vertex_row_starts, vertex_columns) = pattern.leading_columns(n_vertices, n_vertices);
        Ok(Self {
            pattern,
            vertex_row_starts,
            vertex_columns,
            n_vertices,
            n_points: mesh.n_points(),
            n_cells: mesh.cells().len(),
            fingerprint: fingerprint(mesh),
        })
    }

    /// Number of vertices, equal to the number of pressure dofs.
    pub fn n_vertices(&self) -> usize {
        self.n_vertices
    }

    /// Number of points, each of which is a velocity node.
    pub fn n_points(&self) -> usize {
        self.n_points
    }

    /// Interpolation from linear to quadratic elements, `n_points` × `n_vertices`.
    ///
    /// The row of a vertex holds 1, that of a midside node 1/2 for each end of its edge.
    ///
    /// # Errors
    /// [`FemError::OtherMesh`].
    pub fn vertex_interpolation(&self, mesh: &TetMesh) -> Result<Csr, FemError> {
        self.check(mesh)?;
        let n_midside = self.n_points - self.n_vertices;
        let mut parents = vec![[0u32; 2]; n_midside];
        for nodes in mesh.cells() {
            for (k, [i, j]) in TET_EDGES.into_iter().enumerate() {
                let (a, b) = (nodes[i], nodes[j]);
                parents[nodes[4 + k] as usize - self.n_vertices] = [a.min(b), a.max(b)];
            }
        }
        let row_starts = (0..=self.n_vertices)
            .chain((1..=n_midside).map(|k| self.n_vertices + 2 * k))
            .collect();
        let columns = (0..self.n_vertices as u32)
            .chain(parents.into_iter().flatten())
            .collect();
        let values = [vec![1.0; self.n_vertices], vec![0.5; 2 * n_midside]].concat();
        Ok(Csr::new(
            (self.n_points, self.n_vertices),
            row_starts,
            columns,
            values,
        ))
    }

    /// Checks that `mesh` has the cells for which this space was built.
    pub(crate) fn check(&self, mesh: &TetMesh) -> Result<(), FemError> {
        let same = mesh.cells().len() == self.n_cells
            && mesh.n_points() == self.n_points
            && mesh.n_vertices() == self.n_vertices
            && fingerprint(mesh) == self.fingerprint;
        if same {
            Ok(())
        } else {
            Err(FemError::OtherMesh {
                expected: self.n_cells,
                found: mesh.cells().len(),
            })
        }
    }
}

/// Number of cells per task of the hash, fixed, because the hash depends on it.
const CELLS_PER_HASH: usize = 4096;

/// Hash of the connectivity.
fn fingerprint(mesh: &TetMesh) -> u64 {
    // The multiplier of FxHash in rustc; any odd number with well distributed bits would do.
    let mix =
        |hash: u64, word: u64| (hash.rotate_left(5) ^ word).wrapping_mul(0x51_7c_c1_b7_27_22_0a_95);
    let parts: Vec<u64> = mesh
        .cells()
        .par_chunks(CELLS_PER_HASH)
        .map(|cells| {
            let (pairs, _) = cells.as_flattened().as_chunks();
            pairs.iter().fold(0, |hash, &[a, b]| {
                mix(hash, u64::from(a) << 32 | u64::from(b))
            })
        })
        .collect();
    parts.into_iter().fold(0, mix)
}
