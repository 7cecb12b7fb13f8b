//! The part of a bubble space that belongs to one process.

use std::fmt;
use std::sync::Arc;

use mesh::Vec3;

/// Replaces numbers by sums over processes, or entries of other processes by theirs.
///
/// It is called by every process in the same order, on the thread that calls this crate. A call
/// that fails writes NaN.
pub type OverProcesses = Arc<dyn Fn(&mut [f64]) + Send + Sync>;

/// The cells and bubbles of a [`SurplusSpace`](super::SurplusSpace) that belong to this process.
///
/// The mesh of the space has all cells around the vertices of this process. A bubble has one owner
/// among the processes whose meshes have all of its cells, and so has a cell.
#[derive(Clone)]
pub struct SurplusPart {
    cells: Vec<bool>,
    bubbles: Vec<bool>,
    sum: OverProcesses,
    update: OverProcesses,
}

impl SurplusPart {
    /// A part that owns the `cells` and `bubbles` with these flags.
    ///
    /// Bubbles are those of the edges, numbered like the midside nodes of the mesh, then those of
    /// the faces ([`SurplusSpace::face_bubbles`](super::SurplusSpace::face_bubbles)). `sum` returns
    /// sums over all processes. `update` replaces the entries of other processes in a vector with
    /// three numbers per bubble, followed by one per edge.
    pub fn new(
        cells: Vec<bool>,
        bubbles: Vec<bool>,
        sum: OverProcesses,
        update: OverProcesses,
    ) -> Self {
        Self {
            cells,
            bubbles,
            sum,
            update,
        }
    }

    /// Numbers of cells and bubbles.
    pub(super) fn lengths(&self) -> [usize; 2] {
        [self.cells.len(), self.bubbles.len()]
    }

    pub(super) fn owns_cell(&self, cell: usize) -> bool {
        self.cells[cell]
    }

    pub(super) fn owns_bubble(&self, bubble: usize) -> bool {
        self.bubbles[bubble]
    }

    /// Replaces `values` by their sums over all processes.
    pub(super) fn sum(&self, values: &mut [f64]) {
        (self.sum)(values);
    }

    /// Replaces the entries of other processes in a vector of the extension.
    pub(super) fn update(&self, extension: &mut [f64]) {
        (self.update)(extension);
    }

    /// Replaces the values of bubbles of other processes, of which there are `edges` on edges.
    pub(super) fn update_bubbles(&self, values: &mut [Vec3], edges: usize) {
        let mut extension: Vec<f64> = values.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
        extension.resize(3 * values.len() + edges, 0.0);
        self.update(&mut extension);
        for (value, updated) in values.iter_mut().zip(extension.as_chunks().0) {
            *value = Vec3::from(*updated);
        }
    }

    /// As [`update_bubbles`](Self::update_bubbles), for numbers.
    pub(super) fn update_numbers(&self, numbers: &mut [f64], edges: usize) {
        let mut values: Vec<Vec3> = numbers.iter().map(|x| Vec3::new(*x, 0.0, 0.0)).collect();
        self.update_bubbles(&mut values, edges);
        for (number, value) in numbers.iter_mut().zip(values) {
            *number = value.x;
        }
    }

    /// Sets entries of other processes in a vector of the extension to zero.
    pub(super) fn zero_others(&self, extension: &mut [f64]) {
        let (bubbles, edges) = extension.split_at_mut(3 * self.bubbles.len());
        for (value, owned) in bubbles.as_chunks_mut::<3>().0.iter_mut().zip(&self.bubbles) {
            if !owned {
                *value = [0.0; 3];
            }
        }
        // Edges come first among the bubbles.
        for (value, owned) in edges.iter_mut().zip(&self.bubbles) {
            if !owned {
                *value = 0.0;
            }
        }
    }
}

impl fmt::Debug for SurplusPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = |flags: &[bool]| flags.iter().filter(|owned| **owned).count();
        let (cells, bubbles) = (count(&self.cells), count(&self.bubbles));
        write!(f, "SurplusPart({cells} cells, {bubbles} bubbles)")
    }
}
