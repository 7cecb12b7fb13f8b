//! Galerkin system of spheres at any positions, and its solution by conjugate gradients.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use nalgebra::Vector3;
use rayon::prelude::*;

use super::coupling::{Coupling, Expansion};
use super::frame::{Frame, Surroundings};
use super::modes::{Family, Modes};
use super::narrow_gap::Block;
use super::orders::Orders;
use super::wall_image;
use crate::HydroError;

/// Coefficients of all expansions for several right-hand sides: one matrix per expansion, one
/// column per right-hand side.
pub(crate) type MultiVector = Vec<Mat<f64>>;

/// Galerkin matrix: the identity plus the couplings of all pairs of expansions.
pub(crate) struct System {
    pub expansions: Vec<Expansion>,
    pub spheres: usize,
    /// Centres of the expansions.
    centres: Vec<Vector3<f64>>,
    /// Accuracy of the couplings.
    tolerance: f64,
    /// Couplings of all pairs of expansions; empty until [`System::store_couplings`].
    couplings: Vec<Coupling>,
    /// Dense blocks from the first expansion to the second one, first <= second: images in a wall
    /// and narrow gaps.
    blocks: Vec<Block>,
}

/// The Galerkin matrix in parts: of the spheres, of the container, and between them.
pub(crate) struct DenseSystem {
    /// Lower triangle of the modes of the spheres.
    pub spheres: Mat<f64>,
    /// Columns of the modes of the container, none without one, in the rows of the spheres.
    pub container: Mat<f64>,
    /// Lower triangle of the modes of the container, where it is not the identity.
    pub own: Option<Mat<f64>>,
}

impl System {
    /// System of expansions whose couplings have the accuracy `tolerance`.
    ///
    /// Beside a wall it computes the couplings with the images: `O(L^4)` numbers per pair.
    pub fn new(frame: &Frame, radii: &[f64], orders: &Orders, tolerance: f64) -> Self {
        let spheres = radii.len();
        let mut expansions: Vec<Expansion> = radii
            .iter()
            .zip(&orders.spheres)
            .map(|(&radius, &order)| Expansion {
                radius,
                modes: Modes { order },
            })
            .collect();
        let mut centres = frame.centres.clone();
        let mut blocks = Vec::new();
        match frame.surroundings {
            Surroundings::Unbounded => {}
            Surroundings::Ball(radius) => {
                expansions.push(Expansion {
                    radius,
                    modes: Modes {
                        order: orders.container,
                    },
                });
                centres.push(Vector3::zeros());
            }
            Surroundings::Wall => {
                let x = &frame.centres;
                let with_self: Vec<(usize, usize)> = (0..spheres)
                    .flat_map(|j| (0..=j).map(move |i| (i, j)))
                    .collect();
                blocks = with_self
                    .par_iter()
                    .map(|&(i, j)| {
                        (
                            (i, j),
                            wall_image::image_coupling(
                                (&expansions[i], &x[i]),
                                (&expansions[j], &x[j]),
                            ),
                        )
                    })
                    .collect();
            }
        }
        Self {
            expansions,
            spheres,
            centres,
            tolerance,
            couplings: Vec::new(),
            blocks,
        }
    }

    /// Computes and stores the couplings for [`System::apply`].
    ///
    /// Storage: `O(L^3)` numbers per pair of expansions.
    pub fn store_couplings(mut self) -> Self {
        let pairs: Vec<(usize, usize)> = self.pairs().collect();
        self.couplings = pairs.par_iter().map(|&pair| self.coupling(pair)).collect();
        self
    }

    /// Pairs of expansions, the container after all spheres.
    fn pairs(&self) -> impl Iterator<Item = (usize, usize)> {
        (0..self.expansions.len()).flat_map(|j| (0..j).map(move |i| (i, j)))
    }

    /// Coupling of a pair of expansions.
    fn coupling(&self, (i, j): (usize, usize)) -> Coupling {
        let [first, second] = [i, j].map(|k| &self.expansions[k]);
        if j == self.spheres {
            return Coupling::with_container((j, i), second, first, &self.centres[i]);
        }
        let offset = self.centres[j] - self.centres[i];
        Coupling::between_spheres((i, j), (first, second), &offset, self.tolerance)
    }

    /// Adds dense blocks from one expansion to another; a block of an expansion with itself is
    /// symmetric.
    pub fn add_blocks(&mut self, blocks: impl IntoIterator<Item = Block>) {
        self.blocks.extend(blocks);
    }

    /// Zero coefficients for a number of right-hand sides.
    pub fn zeros(&self, columns: usize) -> MultiVector {
        self.expansions
            .iter()
            .map(|expansion| Mat::zeros(expansion.modes.len(), columns))
            .collect()
    }

    /// Product of the matrix and `x`.
    ///
    /// The expansions are computed in parallel; each adds its couplings in a fixed order.
    pub fn apply(&self, x: &MultiVector) -> MultiVector {
        (0..self.expansions.len())
            .into_par_iter()
            .map(|expansion| {
                let mut y = x[expansion].clone();
                for coupling in &self.couplings {
                    if coupling.pair.1 == expansion {
                        coupling.add(x[coupling.pair.0].as_ref(), y.as_mut(), false);
                    } else if coupling.pair.0 == expansion {
                        coupling.add(x[coupling.pair.1].as_ref(), y.as_mut(), true);
                    }
                }
                for ((from, to), block) in &self.blocks {
                    let mut add = |a: faer::MatRef<f64>, other: usize| {
                        matmul(y.as_mut(), Accum::Add, a, x[other].as_ref(), 1.0, Par::Seq);
                    };
                    if *to == expansion {
                        add(block.as_ref(), *from);
                    } else if *from == expansion {
                        add(block.transpose(), *to);
                    }
                }
                y
            })
            .collect()
    }

    /// The matrix, with the modes of the spheres, and those of the container apart, in the given
    /// rows.
    pub fn dense(&self, rows: &[Vec<usize>]) -> DenseSystem {
        let n = self.spheres;
        let size = rows[..n].iter().map(Vec::len).sum();
        let of_container = rows.get(n).map_or(0, Vec::len);
        let is_changed = |((from, _), _): &Block| *from == n;
        let mut dense = DenseSystem {
            spheres: Mat::identity(size, size),
            container: Mat::zeros(size, of_container),
            own: (self.blocks.iter().any(is_changed))
                .then(|| Mat::identity(of_container, of_container)),
        };
        let mut put = |block: &Mat<f64>, from: usize, to: usize| {
            for (j, &column) in rows[from].iter().enumerate() {
                for (i, &row) in rows[to].iter().enumerate() {
                    let entry = match (from == n, to == n) {
                        (true, false) => &mut dense.container[(row, column)],
                        (false, true) => &mut dense.container[(column, row)],
                        // a block of an expansion with itself has each pair of modes twice
                        _ if from == to && row < column => continue,
                        (false, false) => &mut dense.spheres[(row.max(column), row.min(column))],
                        (true, true) => match &mut dense.own {
                            Some(own) => &mut own[(row, column)],
                            None => continue,
                        },
                    };
                    *entry += block[(i, j)];
                }
            }
        };
        let pairs: Vec<(usize, usize)> = self.pairs().collect();
        let largest = rows.iter().map(Vec::len).max().unwrap_or_default().max(1);
        for some in pairs.chunks((BATCH_NUMBERS / (largest * largest)).max(2)) {
            let blocks: Vec<Block> = some
                .par_iter()
                .map(|&pair| {
                    let coupling = self.coupling(pair);
                    (coupling.pair, coupling.dense())
                })
                .collect();
            for ((from, to), block) in &blocks {
                put(block, *from, *to);
            }
        }
        for ((from, to), block) in &self.blocks {
            put(block, *from, *to);
        }
        dense
    }

    /// Rows of the rigid motions of a sphere: translation `m = -1, 0, 1`, then rotation.
    pub fn rigid_rows(&self, sphere: usize) -> [usize; 6] {
        let modes = self.expansions[sphere].modes;
        let (force, torque) = (
            modes.shell(Family::Stokeslet, 1).start,
            modes.shell(Family::Rotlet, 1).start,
        );
        [force, force + 1, force + 2, torque, torque + 1, torque + 2]
    }

    /// For each expansion and mode: whether the condition holds.
    pub fn mask(&self, condition: impl Fn(Modes, Family, usize) -> bool) -> Vec<Vec<bool>> {
        self.expansions
            .iter()
            .map(|expansion| {
                let mut mask = vec![false; expansion.modes.len()];
                for (family, l) in expansion.modes.shells() {
                    mask[expansion.modes.shell(family, l)].fill(condition(
                        expansion.modes,
                        family,
                        l,
                    ));
                }
                mask
            })
            .collect()
    }

    /// Solves for the coefficients with `mask` true, all others being zero; returns the residual.
    ///
    /// Conjugate gradients from the initial guess `x`, for all right-hand sides at once, until the
    /// norm of each residual is below `target`. The diagonal of the matrix is one, so no
    /// preconditioner is used.
    ///
    /// # Errors
    /// [`HydroError::NotConverged`].
    pub fn solve(
        &self,
        mask: &[Vec<bool>],
        rhs: &MultiVector,
        x: &mut MultiVector,
        target: f64,
    ) -> Result<MultiVector, HydroError> {
        let columns = rhs.first().map_or(0, Mat::ncols);
        let ax = self.apply(x);
        let mut r: MultiVector = rhs.iter().zip(&ax).map(|(b, ax)| b - ax).collect();
        apply_mask(&mut r, mask);
        let mut p = r.clone();
        let mut squares = dots(&r, &r);
        let worst = |squares: &[f64]| squares.iter().fold(0.0_f64, |m, s| m.max(s.sqrt()));
        for iteration in 0.. {
            let residual = worst(&squares);
            if residual <= target {
                break;
            }
            if iteration == MAX_ITERATIONS || !residual.is_finite() {
                return Err(HydroError::NotConverged {
                    iterations: iteration,
                    residual,
                    target,
                });
            }
            let mut ap = self.apply(&p);
            apply_mask(&mut ap, mask);
            let curvature = dots(&p, &ap);
            let step: Vec<f64> = (0..columns)
                .map(|j| {
                    if squares[j] > 0.0 {
                        squares[j] / curvature[j]
                    } else {
                        0.0
                    }
                })
                .collect();
            for expansion in 0..self.expansions.len() {
                for j in 0..columns {
                    for i in 0..p[expansion].nrows() {
                        x[expansion][(i, j)] += step[j] * p[expansion][(i, j)];
                        r[expansion][(i, j)] -= step[j] * ap[expansion][(i, j)];
                    }
                }
            }
            let next = dots(&r, &r);
            for expansion in 0..self.expansions.len() {
                for j in 0..columns {
                    let factor = if squares[j] > 0.0 {
                        next[j] / squares[j]
                    } else {
                        0.0
                    };
                    for i in 0..p[expansion].nrows() {
                        p[expansion][(i, j)] = r[expansion][(i, j)] + factor * p[expansion][(i, j)];
                    }
                }
            }
            squares = next;
        }
        Ok(r)
    }
}

/// Numbers in the dense blocks that are computed at a time: 32 MB.
const BATCH_NUMBERS: usize = 4_000_000;

/// Iteration limit.
///
/// Gaps of a twentieth of a radius take 60 iterations; more than this limit means that a gap is far
/// too narrow for the order.
const MAX_ITERATIONS: usize = 500;

/// Sets coefficients to zero where the mask is false.
fn apply_mask(panel: &mut MultiVector, mask: &[Vec<bool>]) {
    for (block, mask) in panel.iter_mut().zip(mask) {
        for j in 0..block.ncols() {
            for (i, &free) in mask.iter().enumerate() {
                if !free {
                    block[(i, j)] = 0.0;
                }
            }
        }
    }
}

/// Scalar products of corresponding columns, summed in a fixed order.
fn dots(a: &MultiVector, b: &MultiVector) -> Vec<f64> {
    let columns = a.first().map_or(0, Mat::ncols);
    (0..columns)
        .map(|j| {
            a.iter()
                .zip(b)
                .map(|(a, b)| (0..a.nrows()).map(|i| a[(i, j)] * b[(i, j)]).sum::<f64>())
                .sum()
        })
        .collect()
}
