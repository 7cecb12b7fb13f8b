//! Sums over all pairs of many spheres by a fast multipole method.
//!
//! The flow of singularities is that of four harmonic functions (Tornberg & Greengard 2008): about
//! a centre, with `X` and `Y` the places of the fluid and of a source relative to it,
//!
//! ```text
//! 8π u_i = φ_i - X_j ∂_i φ_j + ∂_i ψ
//! force F:           φ = F/r,              ψ = Y·F/r
//! force dipole D:    φ_l = D_kl ∂'_k(1/r), ψ = D_kl ∂'_k(Y_l/r)      ∂' by the source
//! potential flow:    ψ = p·∂'(1/r) + Q_kl ∂'_k ∂'_l(1/r)
//! ```
//!
//! and `½ curl u` is the curl of `φ`, `∇²u = -2 ∇(∇·φ)`. The functions are expanded in cells of an
//! octree (Greengard & Rokhlin 1987): moments are added up towards the first level, translated
//! between cells that are not neighbours, and local expansions passed down. What is near is summed
//! pair by pair. At another centre, `c'` for `c`, `ψ` is `ψ + (c - c')·φ`.

mod harmonics;
mod octree;

use std::ops::Range;
use std::sync::LazyLock;

use nalgebra::{DMatrix, DMatrixView, Matrix3, Vector3};
use rayon::prelude::*;

use self::harmonics::{
    DERIVATIVES, FROM_PART, TERMS, centre_of_part, degree_at, local_from_moments_to, regular,
};
use self::octree::Octree;

/// Singularities of the flow at one place.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Singularities {
    pub force: Vector3<f64>,
    /// `D_kl`: a derivative by the place along `k` of a force along `l`.
    pub force_dipole: Matrix3<f64>,
    /// `p`.
    pub dipole: Vector3<f64>,
    /// `Q`, symmetric.
    pub quadrupole: Matrix3<f64>,
}

/// What is computed of the flow at a sphere with the squared radius `a²`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Observed {
    /// `(1 + a²∇²/6) u` and `½ curl u`.
    Velocity,
    /// `(1 + a²∇²/10) ½ (∇u + ∇u^T)` as `xx, yy, zz, xy, xz, yz`.
    StrainRate,
}

/// Harmonic functions of a flow: the three of `φ`, and `ψ`.
const FUNCTIONS: usize = 4;

/// Numbers of the expansions of a cell.
const CELL: usize = FUNCTIONS * TERMS;

/// Cells whose expansions are found together, so that translations are products of matrices.
const CELLS_AT_ONCE: usize = 64;

/// Cells of a level along each axis between the farthest of an interaction.
const REACH: i64 = 3;

/// Translations by all offsets between cells that interact, in edges of the cells, of the first
/// terms of the expansions.
///
/// Found by one thread: one that waits for others here could take up work that waits for this.
static TRANSLATIONS: LazyLock<Vec<DMatrix<f64>>> = LazyLock::new(|| {
    let width = 2 * REACH + 1;
    (0..width.pow(3))
        .map(|number| {
            let offset = [
                number / width.pow(2),
                number / width % width,
                number % width,
            ];
            let offset = offset.map(|d| d - REACH);
            match offset.iter().any(|d| d.abs() > 1) {
                // from the source to the target
                true => local_from_moments_to(degree_at(offset), &-Vector3::from(offset).cast()),
                false => DMatrix::zeros(0, 0),
            }
        })
        .collect()
});

fn number_of(offset: [i64; 3]) -> usize {
    let width = 2 * REACH + 1;
    offset
        .iter()
        .fold(0, |number, d| number * width + d + REACH) as usize
}

/// The translations to cells whose expansions are found together, one for each offset.
struct Receivers(Vec<Translation>);

/// Translations by one offset, from a receiver to a source.
struct Translation {
    offset: [i64; 3],
    /// The place of the receiver among those of its block, and the source.
    pairs: Vec<(usize, usize)>,
}

/// An arrangement of many points, with what its sums share.
pub(crate) struct FastSums {
    tree: Octree,
    /// Points relative to the centre of their cell, in the order of the tree.
    places: Vec<Vector3<f64>>,
    /// For each level, blocks of [`CELLS_AT_ONCE`] cells.
    receivers: Vec<Vec<Receivers>>,
}

impl FastSums {
    /// The tree of an arrangement. Cost: `O(n log n)`.
    pub fn new(points: &[Vector3<f64>]) -> Self {
        let tree = Octree::new(points);
        let mut places = Vec::with_capacity(points.len());
        let last = tree.levels.len() - 1;
        for (cell, leaf) in tree.leaves.iter().enumerate() {
            let centre = tree.centre(last, cell);
            places.extend(tree.order[leaf.clone()].iter().map(|&k| points[k] - centre));
        }
        let receivers = tree.levels.iter().map(|level| {
            let blocks = level.codes.len().div_ceil(CELLS_AT_ONCE);
            let block = |block: usize| {
                let first = block * CELLS_AT_ONCE;
                let cells = first..(first + CELLS_AT_ONCE).min(level.codes.len());
                let all = cells.flat_map(|cell| {
                    let own = cell - first;
                    level
                        .distant(cell)
                        .map(move |(offset, source)| (offset, own, source))
                });
                let mut all: Vec<_> = all.collect();
                all.sort_unstable();
                let by_offset = all.chunk_by(|a, b| a.0 == b.0).map(|same| Translation {
                    offset: same[0].0,
                    pairs: same.iter().map(|&(_, own, source)| (own, source)).collect(),
                });
                Receivers(by_offset.collect())
            };
            (0..blocks).into_par_iter().map(block).collect()
        });
        Self {
            receivers: receivers.collect(),
            places,
            tree,
        }
    }

    /// Order of the points in the ranges of [`FastSums::leaves`].
    pub fn order(&self) -> &[usize] {
        &self.tree.order
    }

    /// Up to this number of points with large errors: those of cells that are farthest from their
    /// centres.
    pub fn corners(&self, most: usize) -> Vec<usize> {
        let leaves = &self.tree.leaves;
        let count = most.min(leaves.len());
        let corners = |number: usize| {
            let mut points: Vec<usize> = leaves[number * leaves.len() / count].clone().collect();
            points.sort_by(|&a, &b| {
                let [a, b] = [a, b].map(|k| self.places[k].norm_squared());
                b.total_cmp(&a)
            });
            points.truncate(most / count);
            points.into_iter().map(|place| self.tree.order[place])
        };
        (0..count).flat_map(corners).collect()
    }

    /// Points of the last cells.
    pub fn leaves(&self) -> &[Range<usize>] {
        &self.tree.leaves
    }

    /// Cells whose flow is summed pair by pair, the own one among them.
    pub fn neighbours(&self, leaf: usize) -> impl Iterator<Item = usize> + '_ {
        self.tree.levels[self.tree.levels.len() - 1].neighbours(leaf)
    }

    /// The flow by the sources that are not in neighbouring cells, six numbers per point, times 8π.
    ///
    /// Sources, squared radii and results are in the order of the tree. The error is that of
    /// [`harmonics::ORDER`]; velocities by forces are a symmetric operator up to it.
    pub fn far(
        &self,
        sources: &[Singularities],
        squares: &[f64],
        observed: Observed,
    ) -> Vec<[f64; 6]> {
        let moments = self.moments(sources);
        let locals = self.locals(&moments);
        let leaves = self.tree.leaves.par_iter().zip(locals.par_chunks(CELL));
        let edge = self.edge();
        let values = leaves.flat_map_iter(|(leaf, local)| {
            let observe = |local| match observed {
                Observed::Velocity => self.velocities(leaf, local, squares, edge),
                Observed::StrainRate => self.strain_rates(leaf, local, squares, edge),
            };
            observe(local)
        });
        values.collect()
    }

    /// Edge of the last cells.
    fn edge(&self) -> f64 {
        self.tree.levels[self.tree.levels.len() - 1].edge
    }

    /// Regular harmonics of the points of a cell, a column for each.
    fn harmonics(&self, leaf: &Range<usize>) -> DMatrix<f64> {
        let edge = self.edge();
        let columns: Vec<_> = self.places[leaf.clone()]
            .iter()
            .map(|y| regular(&(y / edge)))
            .collect();
        DMatrix::from_columns(&columns)
    }

    /// Moments of all cells, by level: the functions are `1/h` times their sum with irregular
    /// harmonics of lengths in edges `h`.
    fn moments(&self, sources: &[Singularities]) -> Vec<Vec<f64>> {
        let last = self.tree.levels.len() - 1;
        let mut finest = vec![0.0; CELL * self.tree.leaves.len()];
        let leaves = finest.par_chunks_mut(CELL).zip(&self.tree.leaves);
        leaves.for_each(|(own, leaf)| own.copy_from_slice(&self.moments_of(leaf, sources)));
        let mut levels = vec![finest];
        for level in (1..last).rev() {
            let parts = &self.tree.levels[level + 1];
            let (below, codes) = (&levels[levels.len() - 1], &self.tree.levels[level].codes);
            let mut above = vec![0.0; CELL * codes.len()];
            let cells = above.par_chunks_mut(CELL).zip(codes);
            cells.for_each(|(own, &code)| {
                let first = parts.codes.partition_point(|part| part >> 3 < code);
                let of_cell = parts.codes[first..]
                    .iter()
                    .take_while(|part| *part >> 3 == code);
                for (part, part_code) in (first..).zip(of_cell) {
                    let octant = (part_code & 7) as usize;
                    let mut moved = part_of(below, part).to_vec();
                    centre(&mut moved, &(centre_of_part(octant) * 2.0 * parts.edge));
                    add_product(&FROM_PART[octant], &moved, own);
                }
            });
            levels.push(above);
        }
        levels.push(Vec::new());
        levels.reverse();
        levels
    }

    /// Moments of the sources in a cell.
    fn moments_of(&self, leaf: &Range<usize>, sources: &[Singularities]) -> Vec<f64> {
        let (sources, places) = (&sources[leaf.clone()], &self.places[leaf.clone()]);
        // Charges of φ and ψ, and their dipoles along three axes.
        let weights = DMatrix::from_fn(sources.len(), 4 * FUNCTIONS + 6, |row, column| {
            let (source, y) = (&sources[row], &places[row]);
            let (axis, function) = (column / FUNCTIONS, column % FUNCTIONS);
            match (axis, function) {
                (0, 3) => source.force.dot(y) + source.force_dipole.trace(),
                (0, _) => source.force[function],
                (1..=3, 3) => source.dipole[axis - 1] + source.force_dipole.row(axis - 1).tr_dot(y),
                (1..=3, _) => source.force_dipole[(axis - 1, function)],
                _ => {
                    let (k, l) = SYMMETRIC[column - 4 * FUNCTIONS];
                    let factor = if k == l { 1.0 } else { 2.0 };
                    factor * source.quadrupole[(k, l)]
                }
            }
        });
        let sums = self.harmonics(leaf) * weights;
        let inverse = 1.0 / self.edge();
        let column = |k: usize| &sums.as_slice()[k * TERMS..(k + 1) * TERMS];
        let mut moments = sums.as_slice()[..CELL].to_vec();
        for (axis, derivative) in DERIVATIVES.iter().enumerate() {
            for (function, own) in moments.chunks_exact_mut(TERMS).enumerate() {
                derivative.add(inverse, column((axis + 1) * FUNCTIONS + function), own);
            }
        }
        for (number, (k, l)) in SYMMETRIC.into_iter().enumerate() {
            let mut once = vec![0.0; TERMS];
            DERIVATIVES[k].add(inverse, column(4 * FUNCTIONS + number), &mut once);
            DERIVATIVES[l].add(inverse, &once, &mut moments[3 * TERMS..]);
        }
        moments
    }

    /// Local expansions of the last cells.
    fn locals(&self, moments: &[Vec<f64>]) -> Vec<f64> {
        let levels = &self.tree.levels;
        let mut above = vec![0.0; CELL * levels[1].codes.len()];
        for level in 2..levels.len() {
            let (codes, edge) = (&levels[level].codes, levels[level].edge);
            let mut own = vec![0.0; CELL * codes.len()];
            let blocks = own.par_chunks_mut(CELL * CELLS_AT_ONCE);
            blocks
                .zip(&self.receivers[level])
                .for_each(|(cells, receivers)| {
                    receivers.translate(&moments[level], edge, cells);
                });
            let cells = own.par_chunks_mut(CELL).zip(codes);
            cells.for_each(|(local, code)| {
                let Ok(parent) = levels[level - 1].codes.binary_search(&(code >> 3)) else {
                    return;
                };
                let octant = (code & 7) as usize;
                let mut passed = vec![0.0; CELL];
                add_transposed_product(&FROM_PART[octant], part_of(&above, parent), &mut passed);
                centre(&mut passed, &(-centre_of_part(octant) * 2.0 * edge));
                for (sum, value) in local.iter_mut().zip(&passed) {
                    *sum += 0.5 * value;
                }
            });
            above = own;
        }
        above
    }

    /// Values of functions at the points of a cell, a row for each function.
    ///
    /// `fill` adds the local expansion of a function, times the edge of the cell.
    fn values(
        &self,
        leaf: &Range<usize>,
        functions: usize,
        fill: impl Fn(usize, &mut [f64]),
    ) -> DMatrix<f64> {
        let mut expansions = DMatrix::zeros(TERMS, functions);
        for (function, own) in expansions
            .as_mut_slice()
            .chunks_exact_mut(TERMS)
            .enumerate()
        {
            fill(function, own);
        }
        // a product of matrices, which is faster than scalar products
        expansions.transpose() * self.harmonics(leaf) / self.edge()
    }

    fn velocities(
        &self,
        leaf: &Range<usize>,
        local: &[f64],
        squares: &[f64],
        edge: f64,
    ) -> Vec<[f64; 6]> {
        let once = 1.0 / edge;
        // φ_i + ∂_i ψ, then ∂_i φ_j, then ∂_i ∂_j φ_j
        let divergence = divergence(local, edge);
        let values = self.values(leaf, 15, |number, own| match number {
            0..3 => {
                own.copy_from_slice(part(local, number));
                DERIVATIVES[number].add_transposed(once, part(local, 3), own);
            }
            3..12 => DERIVATIVES[number % 3].add_transposed(once, part(local, number / 3 - 1), own),
            _ => DERIVATIVES[number % 3].add_transposed(once, &divergence, own),
        });
        let points = leaf.clone().zip(values.column_iter());
        points
            .map(|(point, f)| {
                let x = self.places[point];
                let gradient = |i: usize, j: usize| f[3 + 3 * j + i];
                let velocity = |i: usize| {
                    let turned: f64 = (0..3).map(|j| x[j] * gradient(i, j)).sum();
                    f[i] - turned - squares[point] / 3.0 * f[12 + i]
                };
                let spin = |i: usize| {
                    let (k, j) = ((i + 1) % 3, (i + 2) % 3);
                    gradient(k, j) - gradient(j, k)
                };
                [
                    velocity(0),
                    velocity(1),
                    velocity(2),
                    spin(0),
                    spin(1),
                    spin(2),
                ]
            })
            .collect()
    }

    fn strain_rates(
        &self,
        leaf: &Range<usize>,
        local: &[f64],
        squares: &[f64],
        edge: f64,
    ) -> Vec<[f64; 6]> {
        let once = 1.0 / edge;
        let divergence = divergence(local, edge);
        // ∂_i ∂_k of φ, ψ and of the divergence of φ
        let values = self.values(leaf, 30, |number, own| {
            let (i, k) = SYMMETRIC[number % 6];
            let of = match number / 6 {
                4 => &divergence[..],
                function => part(local, function),
            };
            let mut first = vec![0.0; TERMS];
            DERIVATIVES[i].add_transposed(once, of, &mut first);
            DERIVATIVES[k].add_transposed(once, &first, own);
        });
        let points = leaf.clone().zip(values.column_iter());
        points
            .map(|(point, f)| {
                let x = self.places[point];
                [0, 1, 2, 3, 4, 5].map(|pair| {
                    let turned: f64 = (0..3).map(|j| x[j] * f[6 * j + pair]).sum();
                    f[18 + pair] - turned - squares[point] / 5.0 * f[24 + pair]
                })
            })
            .collect()
    }
}

impl Receivers {
    /// Adds the translated moments of all sources to the local expansions of these cells.
    fn translate(&self, moments: &[f64], edge: f64, locals: &mut [f64]) {
        for Translation { offset, pairs } in &self.0 {
            // from the receiver to the source
            let shift = Vector3::from(*offset).cast::<f64>() * edge;
            let translation = &TRANSLATIONS[number_of(*offset)];
            let terms = translation.nrows();
            let mut sources = Vec::with_capacity(FUNCTIONS * terms * pairs.len());
            for &(_, source) in pairs {
                let first = sources.len();
                for function in part_of(moments, source).chunks_exact(TERMS) {
                    sources.extend_from_slice(&function[..terms]);
                }
                centre(&mut sources[first..], &shift);
            }
            let sources = DMatrix::from_vec(terms, FUNCTIONS * pairs.len(), sources);
            let translated = translation * sources;
            let cells = translated.as_slice().chunks_exact(FUNCTIONS * terms);
            for (&(own, _), values) in pairs.iter().zip(cells) {
                let local = &mut locals[own * CELL..(own + 1) * CELL];
                let functions = local
                    .chunks_exact_mut(TERMS)
                    .zip(values.chunks_exact(terms));
                for (sums, values) in functions {
                    for (sum, value) in sums.iter_mut().zip(values) {
                        *sum += value;
                    }
                }
            }
        }
    }
}

/// Pairs of axes of a symmetric tensor, in the order in which its components are stored.
pub(crate) const SYMMETRIC: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// The expansion of one function of a cell.
fn part(cell: &[f64], function: usize) -> &[f64] {
    &cell[function * TERMS..(function + 1) * TERMS]
}

/// The expansions of one cell.
fn part_of(cells: &[f64], cell: usize) -> &[f64] {
    &cells[cell * CELL..(cell + 1) * CELL]
}

/// Makes `ψ` relative to another centre, which is the present one less the shift.
fn centre(cell: &mut [f64], shift: &Vector3<f64>) {
    let terms = cell.len() / FUNCTIONS;
    let (forces, potential) = cell.split_at_mut(3 * terms);
    for (of_axis, shift) in forces.chunks_exact(terms).zip(shift) {
        for (value, force) in potential.iter_mut().zip(of_axis) {
            *value += shift * force;
        }
    }
}

/// Adds the product of a matrix and the expansions of a cell.
fn add_product(matrix: &DMatrix<f64>, cell: &[f64], sum: &mut [f64]) {
    let product = matrix * DMatrixView::from_slice(cell, TERMS, FUNCTIONS);
    sum.iter_mut()
        .zip(&product)
        .for_each(|(sum, value)| *sum += value);
}

/// The same with the transposed matrix.
fn add_transposed_product(matrix: &DMatrix<f64>, cell: &[f64], sum: &mut [f64]) {
    let product = matrix.tr_mul(&DMatrixView::from_slice(cell, TERMS, FUNCTIONS));
    sum.iter_mut()
        .zip(&product)
        .for_each(|(sum, value)| *sum += value);
}

/// Local expansion of `∇·φ`.
fn divergence(local: &[f64], edge: f64) -> Vec<f64> {
    let mut sum = vec![0.0; TERMS];
    for (axis, derivative) in DERIVATIVES.iter().enumerate() {
        derivative.add_transposed(1.0 / edge, part(local, axis), &mut sum);
    }
    sum
}
