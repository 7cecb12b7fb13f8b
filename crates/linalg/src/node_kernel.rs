//! Innermost kernels: three components of one or several columns per pass over a scalar matrix.
//!
//! Each column is summed in the same order as it would be alone, so results do not depend on the
//! number of columns.

use std::array::from_fn;
use std::ops::{Mul, Range};

use sprs::CsMatI;

use crate::Csr;
use crate::csr::{Csr32, Rounded, Rows};

/// Three components of a node in f32, padded to the width of a vector register; the fourth is zero.
pub(crate) type Padded = [f32; 4];

/// A 3 x 3 block in f32, column by column.
pub(crate) type Block32 = [Padded; 3];

/// Sparse matrix of 3 x 3 blocks in the precision of preconditioners.
pub(crate) type Blocks32 = CsMatI<Block32, u32, usize>;

/// A matrix in f32 with one row and one column per node.
pub(crate) trait NodeMatrix {
    /// The borrowed arrays of the matrix.
    type Rows<'a>: NodeRows + Sync
    where
        Self: 'a;

    /// Borrows the arrays once for a pass over the matrix.
    fn rows(&self) -> Self::Rows<'_>;
}

/// Rows of a [`NodeMatrix`].
pub(crate) trait NodeRows {
    /// `sum_j k_ij x_j` for three components; the columns of a node are adjacent in memory.
    fn padded_row<const S: usize>(&self, i: usize, x: &[[Padded; S]]) -> [Padded; S];
}

impl NodeMatrix for Rounded {
    type Rows<'a> = Rows<'a, f32>;

    fn rows(&self) -> Rows<'_, f32> {
        self.borrow()
    }
}

impl NodeMatrix for Csr32 {
    type Rows<'a> = Rows<'a, f32>;

    fn rows(&self) -> Rows<'_, f32> {
        Rows::new(self)
    }
}

impl NodeMatrix for Blocks32 {
    type Rows<'a> = Rows<'a, Block32>;

    fn rows(&self) -> Rows<'_, Block32> {
        Rows::new(self)
    }
}

impl NodeRows for Rows<'_, f32> {
    #[inline(always)]
    fn padded_row<const S: usize>(&self, i: usize, x: &[[Padded; S]]) -> [Padded; S] {
        padded_row(*self, i, x)
    }
}

impl NodeRows for Rows<'_, Block32> {
    /// Three partial sums, one for each component of `x_j`.
    #[inline(always)]
    fn padded_row<const S: usize>(&self, i: usize, x: &[[Padded; S]]) -> [Padded; S] {
        let mut sums = [[[0.0; 4]; S]; 3];
        for (j, block) in self.row(i) {
            for (c, column) in block.iter().enumerate() {
                for s in 0..S {
                    for d in 0..4 {
                        sums[c][s][d] += column[d] * x[j][s][c];
                    }
                }
            }
        }
        let [a, b, c] = sums;
        from_fn(|s| from_fn(|d| a[s][d] + b[s][d] + c[s][d]))
    }
}

/// `sum_j k_ij x_j` for 3 x 3 blocks in f64.
#[inline(always)]
pub(crate) fn block_row<const S: usize>(
    k: Rows<'_, [[f64; 3]; 3]>,
    i: usize,
    x: [&[[f64; 3]]; S],
) -> [[f64; 3]; S] {
    let mut sums = [[0.0; 3]; S];
    for (j, block) in k.row(i) {
        for (sums, x) in sums.iter_mut().zip(x) {
            let xj = x[j];
            for (sum, row) in sums.iter_mut().zip(block) {
                *sum += row[0] * xj[0] + row[1] * xj[1] + row[2] * xj[2];
            }
        }
    }
    sums
}

/// `sum_j k_ij x_j` for three components in f64, in two partial sums as in [`padded_row`].
#[inline(always)]
pub(crate) fn node_row<const S: usize>(
    k: Rows<'_, f64>,
    i: usize,
    x: [&[[f64; 3]]; S],
) -> [[f64; 3]; S] {
    let (columns, values) = k.entries(i);
    let (column_pairs, last_column) = columns.as_chunks::<2>();
    let (value_pairs, last_value) = values.as_chunks::<2>();
    let (mut even, mut odd) = ([[0.0; 3]; S], [[0.0; 3]; S]);
    let add = |sums: &mut [[f64; 3]; S], column: u32, value: f64| {
        for (sums, x) in sums.iter_mut().zip(x) {
            let xj = x[column as usize];
            for d in 0..3 {
                sums[d] += value * xj[d];
            }
        }
    };
    for (columns, values) in column_pairs.iter().zip(value_pairs) {
        add(&mut even, columns[0], values[0]);
        add(&mut odd, columns[1], values[1]);
    }
    for (&column, &value) in last_column.iter().zip(last_value) {
        add(&mut even, column, value);
    }
    from_fn(|s| from_fn(|d| even[s][d] + odd[s][d]))
}

/// `sum_j k_ij x_j` for three components in f32; the columns of a node are adjacent in memory.
///
/// Four partial sums: a single one would wait three or four cycles for each addition, which is
/// longer than a memory access takes.
#[inline(always)]
fn padded_row<const S: usize>(k: Rows<'_, f32>, i: usize, x: &[[Padded; S]]) -> [Padded; S] {
    let (columns, values) = k.entries(i);
    let (column_fours, columns) = columns.as_chunks::<4>();
    let (value_fours, values) = values.as_chunks::<4>();
    let mut sums = [[[0.0; 4]; S]; 4];
    let mut add = |lane: usize, column: u32, value: f32| {
        let xj = &x[column as usize];
        for s in 0..S {
            for d in 0..4 {
                sums[lane][s][d] += value * xj[s][d];
            }
        }
    };
    for (columns, values) in column_fours.iter().zip(value_fours) {
        for lane in 0..4 {
            add(lane, columns[lane], values[lane]);
        }
    }
    for (lane, (&column, &value)) in columns.iter().zip(values).enumerate() {
        add(lane, column, value);
    }
    let [a, b, c, d] = sums;
    from_fn(|s| from_fn(|k| (a[s][k] + b[s][k]) + (c[s][k] + d[s][k])))
}

/// The nonempty rows of a matrix with three rows per node, most of them empty.
///
/// Products skip empty rows without reading their row pointers, which would take a tenth of a pass
/// over `K`.
#[derive(Debug, Clone)]
pub(crate) struct SparseNodes<T> {
    nodes: Vec<u32>,
    /// Entries `starts[k]..starts[k + 1]` belong to node `nodes[k]`.
    starts: Vec<usize>,
    /// Component and column of each entry, `4 column + component`, with its value.
    entries: Vec<(u32, T)>,
}

impl<T: Copy> SparseNodes<T> {
    /// Collects the nonempty rows of `matrix`, each value converted by `convert`.
    pub fn new(matrix: &Csr, convert: impl Fn(f64) -> T) -> Self {
        let rows = Rows::new(matrix);
        let (mut nodes, mut starts, mut entries) = (Vec::new(), vec![0], Vec::new());
        for node in 0..matrix.rows() / 3 {
            if rows.indptr[3 * node] == rows.indptr[3 * node + 3] {
                continue;
            }
            for d in 0..3 {
                let row = rows.row(3 * node + d);
                entries.extend(row.map(|(c, v)| ((4 * c + d) as u32, convert(v))));
            }
            nodes.push(node as u32);
            starts.push(entries.len());
        }
        SparseNodes {
            nodes,
            starts,
            entries,
        }
    }

    /// Calls `add(node, component, column, value)` for the entries in the rows of `nodes`.
    #[inline]
    pub fn for_each(&self, nodes: Range<usize>, mut add: impl FnMut(usize, usize, usize, T)) {
        let first = self.nodes.partition_point(|&n| (n as usize) < nodes.start);
        for (k, &node) in self.nodes.iter().enumerate().skip(first) {
            if node as usize >= nodes.end {
                break;
            }
            for &(place, value) in &self.entries[self.starts[k]..self.starts[k + 1]] {
                add(node as usize, place as usize % 4, place as usize / 4, value);
            }
        }
    }
}

/// `sum_j a_ij x_j` of one row for the columns `x(j)`, accumulated in f64.
///
/// Border rows may have 10^5 nonzeros.
#[inline]
pub(crate) fn long_row<T: Copy + Mul<Output = T> + Into<f64>, const S: usize>(
    a: Rows<'_, T>,
    i: usize,
    x: impl Fn(usize) -> [T; S],
) -> [f64; S] {
    let mut sums = [0.0; S];
    for (j, v) in a.row(i) {
        for (sum, x) in sums.iter_mut().zip(x(j)) {
            *sum += (v * x).into();
        }
    }
    sums
}
