//! Symbolic phase of the assembly: sparsity pattern and positions of element-matrix entries in it.

use mesh::TetMesh;
use rayon::prelude::*;

use crate::FemError;

/// Number of matrix rows per task.
///
/// Fixed, so that results do not depend on the number of threads. A task then has some thousand
/// nonzeros, enough work to outweigh its start.
pub(crate) const ROWS_PER_TASK: usize = 512;

/// Incidence of a node and a cell: the cell and the local number of the node, packed in one word.
#[derive(Clone, Copy)]
pub(crate) struct Incidence(u32);

impl Incidence {
    /// Largest number of cells that leaves four bits for the local number.
    const MAX_CELLS: usize = 1 << 28;

    pub fn cell(self) -> usize {
        (self.0 >> 4) as usize
    }

    pub fn local(self) -> usize {
        (self.0 & 15) as usize
    }
}

/// Sparsity pattern of quadratic elements, and where each row of each element matrix is added.
///
/// Vertices are numbered before midside nodes and columns are sorted. Therefore the first
/// `n_vertices` rows are the pattern of the divergence, the leading columns of these rows are that
/// of linear elements, and the positions within the rows are the same for all three.
pub(crate) struct Pattern {
    /// The incidences of node `i` are `incidence_starts[i]..incidence_starts[i + 1]`, in ascending
    /// order of the cells.
    pub incidence_starts: Vec<usize>,
    pub incidences: Vec<Incidence>,
    /// For each incidence, positions of the ten nodes of the cell in the row of the node, counted
    /// from the start of the row.
    pub positions: Vec<[u16; 10]>,
    pub row_starts: Vec<usize>,
    pub columns: Vec<u32>,
}

impl Pattern {
    /// Builds the pattern of `mesh`.
    pub fn new(mesh: &TetMesh) -> Result<Self, FemError> {
        let (incidence_starts, incidences) = incidences_of_nodes(mesh)?;
        let mut positions = vec![[0u16; 10]; incidences.len()];
        let rows = (0..mesh.n_points()).step_by(ROWS_PER_TASK);
        let tasks: Vec<_> = rows
            .zip(split_rows(&mut positions, &incidence_starts))
            .collect();
        let parts = tasks
            .into_par_iter()
            .map_init(
                || vec![Mark::default(); mesh.n_points()],
                |marks, (first, positions)| {
                    rows_of(
                        mesh,
                        &incidence_starts,
                        &incidences,
                        first,
                        positions,
                        marks,
                    )
                },
            )
            .collect::<Result<Vec<_>, _>>()?;

        let mut row_starts = Vec::with_capacity(mesh.n_points() + 1);
        row_starts.push(0);
        let mut columns = Vec::with_capacity(parts.iter().map(|(_, c)| c.len()).sum());
        for (lengths, part) in parts {
            for length in lengths {
                row_starts.push(row_starts[row_starts.len() - 1] + length);
            }
            columns.extend_from_slice(&part);
        }
        Ok(Self {
            incidence_starts,
            incidences,
            positions,
            row_starts,
            columns,
        })
    }
}

impl Pattern {
    /// Positions of the ten nodes of `cell` in the row of one of its nodes.
    pub fn positions_in_row(&self, row: usize, cell: usize) -> &[u16; 10] {
        let range = self.incidence_starts[row]..self.incidence_starts[row + 1];
        let cells = &self.incidences[range.clone()];
        &self.positions[range.start + cells.partition_point(|incidence| incidence.cell() < cell)]
    }

    /// Starts and columns of the rows with the columns below `n_columns` alone.
    pub fn leading_columns(&self, n_columns: usize, n_rows: usize) -> (Vec<usize>, Vec<u32>) {
        let mut starts = Vec::with_capacity(n_rows + 1);
        starts.push(0);
        let mut leading = Vec::new();
        for row in 0..n_rows {
            let columns = &self.columns[self.row_starts[row]..self.row_starts[row + 1]];
            let count = columns.partition_point(|&column| (column as usize) < n_columns);
            leading.extend_from_slice(&columns[..count]);
            starts.push(leading.len());
        }
        (starts, leading)
    }
}

/// Splits `data`, whose row `i` is `starts[i]..starts[i + 1]`, into slices of [`ROWS_PER_TASK`]
/// rows.
pub(crate) fn split_rows<'a, T>(mut data: &'a mut [T], starts: &[usize]) -> Vec<&'a mut [T]> {
    let n_rows = starts.len() - 1;
    (0..n_rows)
        .step_by(ROWS_PER_TASK)
        .map(|first| {
            let last = (first + ROWS_PER_TASK).min(n_rows);
            let (head, tail) = std::mem::take(&mut data).split_at_mut(starts[last] - starts[first]);
            data = tail;
            head
        })
        .collect()
}

/// Starts of the incidences of each node, and all incidences, by a counting sort.
fn incidences_of_nodes(mesh: &TetMesh) -> Result<(Vec<usize>, Vec<Incidence>), FemError> {
    let cells = mesh.cells();
    if cells.len() > Incidence::MAX_CELLS {
        return Err(FemError::TooLarge {
            what: "the number of cells",
            found: cells.len(),
            limit: Incidence::MAX_CELLS,
        });
    }
    let mut first = vec![0usize; mesh.n_points() + 1];
    for &node in cells.as_flattened() {
        first[node as usize + 1] += 1;
    }
    for i in 1..first.len() {
        first[i] += first[i - 1];
    }
    let mut next = first.clone();
    let mut incidences = vec![Incidence(0); 10 * cells.len()];
    for (cell, nodes) in cells.iter().enumerate() {
        for (local, &node) in nodes.iter().enumerate() {
            incidences[next[node as usize]] = Incidence((cell as u32) << 4 | local as u32);
            next[node as usize] += 1;
        }
    }
    Ok((first, incidences))
}

/// State of a column while rows are built.
#[derive(Clone, Copy, Default)]
struct Mark {
    /// One more than the last row in which this column occurred.
    row: u32,
    /// Its position in that row.
    position: u16,
}

/// Builds the [`ROWS_PER_TASK`] rows from `first` on: their lengths and columns; fills `positions`.
fn rows_of(
    mesh: &TetMesh,
    incidence_starts: &[usize],
    incidences: &[Incidence],
    first: usize,
    positions: &mut [[u16; 10]],
    marks: &mut [Mark],
) -> Result<(Vec<usize>, Vec<u32>), FemError> {
    let last = (first + ROWS_PER_TASK).min(mesh.n_points());
    let mut lengths = Vec::with_capacity(last - first);
    let mut columns: Vec<u32> = Vec::new();
    for row in first..last {
        let of_row = incidence_starts[row]..incidence_starts[row + 1];
        let start = columns.len();
        for incidence in &incidences[of_row.clone()] {
            for &node in &mesh.cells()[incidence.cell()] {
                let mark = &mut marks[node as usize];
                if mark.row != row as u32 + 1 {
                    mark.row = row as u32 + 1;
                    columns.push(node);
                }
            }
        }
        let columns = &mut columns[start..];
        if columns.len() > u16::MAX as usize {
            return Err(FemError::TooLarge {
                what: "the number of neighbours of a node",
                found: columns.len(),
                limit: u16::MAX as usize,
            });
        }
        columns.sort_unstable();
        for (position, &column) in columns.iter().enumerate() {
            marks[column as usize].position = position as u16;
        }
        for k in of_row {
            let nodes = &mesh.cells()[incidences[k].cell()];
            positions[k - incidence_starts[first]] =
                nodes.map(|node| marks[node as usize].position);
        }
        lengths.push(columns.len());
    }
    Ok((lengths, columns))
}
