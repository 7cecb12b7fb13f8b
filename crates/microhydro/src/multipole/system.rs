//! Galerkin system of spheres at any positions, and its solution by conjugate gradients.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use rayon::prelude::*;

use super::collinear::Around;
use super::frame::Frame;
use super::link::{Body, Link};
use super::modes::{Family, Modes};
use super::order::Orders;
use super::wall_block;
use crate::HydroError;

/// Coefficients of all expansions for several right-hand sides: one matrix per expansion, one
/// column per right-hand side.
pub(crate) type Panel = Vec<Mat<f64>>;

/// Galerkin matrix: the identity plus the couplings of all pairs of expansions.
pub(crate) struct System {
    pub bodies: Vec<Body>,
    pub spheres: usize,
    links: Vec<Link>,
    /// Couplings from the image of the first sphere to the second one, first <= second.
    images: Vec<((usize, usize), Mat<f64>)>,
}

impl System {
    /// Computes all couplings that matter to `tolerance`.
    ///
    /// Storage: `O(L^3)` numbers per pair of spheres, `O(L^4)` beside a wall.
    pub fn new(frame: &Frame, radii: &[f64], orders: &Orders, tolerance: f64) -> Self {
        let spheres = radii.len();
        let mut bodies: Vec<Body> = radii
            .iter()
            .zip(&orders.spheres)
            .map(|(&radius, &order)| Body {
                radius,
                modes: Modes { order },
            })
            .collect();
        let pairs: Vec<(usize, usize)> = (0..spheres)
            .flat_map(|j| (0..j).map(move |i| (i, j)))
            .collect();
        let x = &frame.centres;
        let mut links: Vec<Link> = pairs
            .par_iter()
            .map(|&(i, j)| {
                Link::between((i, j), (&bodies[i], &bodies[j]), &(x[j] - x[i]), tolerance)
            })
            .collect();
        let mut images = Vec::new();
        match frame.around {
            Around::Nothing => {}
            Around::Ball(radius) => {
                bodies.push(Body {
                    radius,
                    modes: Modes {
                        order: orders.container,
                    },
                });
                let container = bodies[spheres];
                links.par_extend(
                    (0..spheres)
                        .into_par_iter()
                        .map(|j| Link::inside((spheres, j), &container, &bodies[j], &x[j])),
                );
            }
            Around::Wall => {
                let with_self: Vec<(usize, usize)> = (0..spheres)
                    .flat_map(|j| (0..=j).map(move |i| (i, j)))
                    .collect();
                images = with_self
                    .par_iter()
                    .map(|&(i, j)| {
                        (
                            (i, j),
                            wall_block::coupling((&bodies[i], &x[i]), (&bodies[j], &x[j])),
                        )
                    })
                    .collect();
            }
        }
        Self {
            bodies,
            spheres,
            links,
            images,
        }
    }

    /// Zero coefficients for a number of right-hand sides.
    pub fn zeros(&self, columns: usize) -> Panel {
        self.bodies
            .iter()
            .map(|body| Mat::zeros(body.modes.len(), columns))
            .collect()
    }

    /// Product of the matrix and `x`.
    ///
    /// The expansions are computed in parallel; each adds its couplings in a fixed order.
    pub fn apply(&self, x: &Panel) -> Panel {
        (0..self.bodies.len())
            .into_par_iter()
            .map(|body| {
                let mut y = x[body].clone();
                for link in &self.links {
                    if link.ends.1 == body {
                        link.add(x[link.ends.0].as_ref(), y.as_mut(), false);
                    } else if link.ends.0 == body {
                        link.add(x[link.ends.1].as_ref(), y.as_mut(), true);
                    }
                }
                for ((from, to), image) in &self.images {
                    let mut add = |a: faer::MatRef<f64>, other: usize| {
                        matmul(y.as_mut(), Accum::Add, a, x[other].as_ref(), 1.0, Par::Seq);
                    };
                    if *to == body {
                        add(image.as_ref(), *from);
                    } else if *from == body {
                        add(image.transpose(), *to);
                    }
                }
                y
            })
            .collect()
    }

    /// Lower triangle of the matrix, with the modes of each expansion in the given rows.
    pub fn dense(&self, places: &[Vec<usize>]) -> Mat<f64> {
        let size = places.iter().map(Vec::len).sum();
        let mut matrix = Mat::<f64>::identity(size, size);
        let mut put = |block: &Mat<f64>, from: usize, to: usize| {
            for (j, &column) in places[from].iter().enumerate() {
                for (i, &row) in places[to].iter().enumerate() {
                    // the block of a sphere with itself contains each pair of modes twice
                    if from != to || row >= column {
                        matrix[(row.max(column), row.min(column))] += block[(i, j)];
                    }
                }
            }
        };
        for some in self.links.chunks(BLOCKS_AT_A_TIME) {
            let blocks: Vec<Mat<f64>> = some.par_iter().map(Link::dense).collect();
            for (link, block) in some.iter().zip(&blocks) {
                put(block, link.ends.0, link.ends.1);
            }
        }
        for ((from, to), image) in &self.images {
            put(image, *from, *to);
        }
        matrix
    }

    /// Rows of the rigid motions of a sphere: translation `m = -1, 0, 1`, then rotation.
    pub fn rigid_rows(&self, sphere: usize) -> [usize; 6] {
        let modes = self.bodies[sphere].modes;
        let (force, torque) = (
            modes.shell(Family::Stokeslet, 1).start,
            modes.shell(Family::Rotlet, 1).start,
        );
        [force, force + 1, force + 2, torque, torque + 1, torque + 2]
    }

    /// For each expansion and mode: whether the condition holds.
    pub fn mask(&self, condition: impl Fn(Modes, Family, usize) -> bool) -> Vec<Vec<bool>> {
        self.bodies
            .iter()
            .map(|body| {
                let mut mask = vec![false; body.modes.len()];
                for (family, l) in body.modes.shells() {
                    mask[body.modes.shell(family, l)].fill(condition(body.modes, family, l));
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
        right: &Panel,
        x: &mut Panel,
        target: f64,
    ) -> Result<Panel, HydroError> {
        let columns = right.first().map_or(0, Mat::ncols);
        let ax = self.apply(x);
        let mut r: Panel = right.iter().zip(&ax).map(|(b, ax)| b - ax).collect();
        keep(&mut r, mask);
        let mut p = r.clone();
        let mut squares = dots(&r, &r);
        let worst = |squares: &[f64]| squares.iter().fold(0.0_f64, |m, s| m.max(s.sqrt()));
        for iteration in 0.. {
            let residual = worst(&squares);
            if residual <= target {
                break;
            }
            if iteration == MOST_STEPS || !residual.is_finite() {
                return Err(HydroError::NotConverged {
                    iterations: iteration,
                    residual,
                    target,
                });
            }
            let mut ap = self.apply(&p);
            keep(&mut ap, mask);
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
            for body in 0..self.bodies.len() {
                for j in 0..columns {
                    for i in 0..p[body].nrows() {
                        x[body][(i, j)] += step[j] * p[body][(i, j)];
                        r[body][(i, j)] -= step[j] * ap[body][(i, j)];
                    }
                }
            }
            let next = dots(&r, &r);
            for body in 0..self.bodies.len() {
                for j in 0..columns {
                    let factor = if squares[j] > 0.0 {
                        next[j] / squares[j]
                    } else {
                        0.0
                    };
                    for i in 0..p[body].nrows() {
                        p[body][(i, j)] = r[body][(i, j)] + factor * p[body][(i, j)];
                    }
                }
            }
            squares = next;
        }
        Ok(r)
    }
}

/// Number of couplings expanded to dense blocks at a time. Few, so that the blocks need little
/// memory beside the matrix.
const BLOCKS_AT_A_TIME: usize = 32;

/// Iteration limit. Gaps of a twentieth of a radius take 60 iterations; more than this limit means
/// that a gap is far too narrow for the order.
const MOST_STEPS: usize = 500;

/// Sets coefficients to zero where the mask is false.
fn keep(panel: &mut Panel, mask: &[Vec<bool>]) {
    for (block, mask) in panel.iter_mut().zip(mask) {
        for j in 0..block.ncols() {
            for (i, &keep) in mask.iter().enumerate() {
                if !keep {
                    block[(i, j)] = 0.0;
                }
            }
        }
    }
}

/// Scalar products of corresponding columns, summed in a fixed order.
fn dots(a: &Panel, b: &Panel) -> Vec<f64> {
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
