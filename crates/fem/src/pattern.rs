//! Symbolic phase: which cells meet which nodes, and where each of their contributions goes.

use mesh::TetMesh;
use rayon::prelude::*;

use crate::FemError;

/// Matrix rows handled as one task. Fixed, so that results do not depend on the thread count; some thousand entries
/// a task is enough work to hide its start.
pub(crate) const ROWS_PER_TASK: usize = 512;

/// A cell seen from one of its nodes: the cell and the node's local number, in one word.
#[derive(Clone, Copy)]
pub(crate) struct Visit(u32);

impl Visit {
    /// Largest cell number that leaves four bits for the local number.
    const MAX_CELLS: usize = 1 << 28;

    pub fn cell(self) -> usize {
        (self.0 >> 4) as usize
    }

    pub fn local(self) -> usize {
        (self.0 & 15) as usize
    }
}

/// The node-to-node sparsity of quadratic elements, and for every pair of a row and a cell the places in that row
/// of the cell's ten columns.
///
/// Vertices come first and columns are sorted. Hence the first `n_vertices` rows are also the sparsity of the
/// divergence, and the leading columns of these rows that of linear elements, with the same places.
pub(crate) struct Pattern {
    /// Visits of node `i` are `first_visit[i]..first_visit[i + 1]`, cells ascending.
    pub first_visit: Vec<usize>,
    pub visits: Vec<Visit>,
    /// Places, counted from the start of the row, of the ten nodes of the visited cell.
    pub places: Vec<[u16; 10]>,
    pub row_starts: Vec<usize>,
    pub columns: Vec<u32>,
}

impl Pattern {
    /// The pattern of `mesh`.
    pub fn new(mesh: &TetMesh) -> Result<Self, FemError> {
        let (first_visit, visits) = visit_lists(mesh)?;
        let mut places = vec![[0u16; 10]; visits.len()];
        let rows = (0..mesh.n_points()).step_by(ROWS_PER_TASK);
        let tasks: Vec<_> = rows.zip(split_rows(&mut places, &first_visit)).collect();
        let parts = tasks
            .into_par_iter()
            .map_init(
                || vec![Mark::default(); mesh.n_points()],
                |marks, (first, places)| rows_of(mesh, &first_visit, &visits, first, places, marks),
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
            first_visit,
            visits,
            places,
            row_starts,
            columns,
        })
    }
}

/// Splits `data`, whose row `i` is `starts[i]..starts[i + 1]`, into slices of [`ROWS_PER_TASK`] rows.
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

/// The visits of every node, by counting.
fn visit_lists(mesh: &TetMesh) -> Result<(Vec<usize>, Vec<Visit>), FemError> {
    let cells = mesh.cells();
    if cells.len() > Visit::MAX_CELLS {
        return Err(FemError::TooLarge {
            what: "the number of cells",
            found: cells.len(),
            limit: Visit::MAX_CELLS,
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
    let mut visits = vec![Visit(0); 10 * cells.len()];
    for (cell, nodes) in cells.iter().enumerate() {
        for (local, &node) in nodes.iter().enumerate() {
            visits[next[node as usize]] = Visit((cell as u32) << 4 | local as u32);
            next[node as usize] += 1;
        }
    }
    Ok((first, visits))
}

/// Scratch of one column while a row is built.
#[derive(Clone, Copy, Default)]
struct Mark {
    /// One more than the last row that had this column.
    row: u32,
    /// Its place in that row.
    place: u16,
}

/// Lengths and columns of the rows from `first` on, as many as `places` covers, which is filled.
fn rows_of(
    mesh: &TetMesh,
    first_visit: &[usize],
    visits: &[Visit],
    first: usize,
    places: &mut [[u16; 10]],
    marks: &mut [Mark],
) -> Result<(Vec<usize>, Vec<u32>), FemError> {
    let last = (first + ROWS_PER_TASK).min(mesh.n_points());
    let mut lengths = Vec::with_capacity(last - first);
    let mut columns: Vec<u32> = Vec::new();
    for row in first..last {
        let visited = first_visit[row]..first_visit[row + 1];
        let start = columns.len();
        for visit in &visits[visited.clone()] {
            for &node in &mesh.cells()[visit.cell()] {
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
        for (place, &column) in columns.iter().enumerate() {
            marks[column as usize].place = place as u16;
        }
        for visit in visited {
            let nodes = &mesh.cells()[visits[visit].cell()];
            places[visit - first_visit[first]] = nodes.map(|node| marks[node as usize].place);
        }
        lengths.push(columns.len());
    }
    Ok((lengths, columns))
}
