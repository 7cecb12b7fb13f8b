//! Direct solution of the saddle-point system.

use nalgebra::{DMatrix, DVector};

use super::factor::{Definiteness, SparseFactor};
use super::order::nested_dissection;
use super::schur::SchurFactor;
use crate::csr::{Rows, check_finite, check_shape};
use crate::node_kernel::long_row;
use crate::product::build_rows;
use crate::vector::{axpy, norm, subtract_from};
use crate::{Csr, LinalgError, LinearOperator, SaddleSystem, SolveReport};

const METHOD: &str = "LDLT with refinement";

/// Right-hand sides solved together: enough for level-3 kernels, little memory.
const GROUP: usize = 6;

/// Choices of the direct solver.
#[derive(Debug, Clone, PartialEq)]
pub struct DirectParams {
    /// The pressure block becomes `-shift diag(M_p)`. The Schur complement is `M_p` up to a factor of six, so a refinement step
    /// gains about `1 / shift`, until rounding, which small pivots amplify, takes over.
    pub shift: f64,
    /// Bound on the true `||b - A x|| / ||b||`.
    pub rel_tol: f64,
    /// Refinement steps allowed; the default shift needs one.
    pub max_refinements: usize,
}

impl Default for DirectParams {
    fn default() -> Self {
        DirectParams {
            shift: 1e-8,
            rel_tol: 1e-12,
            max_refinements: 10,
        }
    }
}

/// An `L D L^T` of the fluid block with the border eliminated by a dense, pivoted Schur complement.
///
/// `[K (x) I3, B^T; B, -shift diag(M_p)]` is quasi-definite: it has such factors in any elimination order (Vanderbei 1995), here
/// METIS nested dissection of the graph of velocity nodes and pressures. The shift is removed by refinement on
/// the true system, which also carries enclosed flow with its undetermined pressure constant: the
/// constant is taken out of each correction.
///
/// Cost: `N^1.4` memory, `N^1.8` time for N unknowns; 200 000 are comfortable, a million is not.
pub struct SaddleLdlt<'a> {
    system: &'a SaddleSystem,
    rel_tol: f64,
    max_refinements: usize,
    factor: SparseFactor,
    /// Solutions of the fluid block for the border columns `[C; E]`, one after another.
    lifted: Vec<f64>,
    schur: SchurFactor,
    /// Whether pressures are determined up to a constant only.
    enclosed: bool,
}

impl<'a> SaddleLdlt<'a> {
    /// Orders and factorises.
    ///
    /// # Errors
    /// [`LinalgError::Factorisation`] for a singular block or lack of memory, [`LinalgError::Parameter`].
    pub fn factor(system: &'a SaddleSystem, params: &DirectParams) -> Result<Self, LinalgError> {
        for (name, value) in [("shift", params.shift), ("rel_tol", params.rel_tol)] {
            if !(value > 0.0 && value < 1.0) {
                let range = "between 0 and 1";
                return Err(LinalgError::Parameter { name, value, range });
            }
        }
        let order = elimination_order(system)?;
        let fluid = fluid_block(system, params.shift);
        let quasi = Definiteness::Quasi;
        let mut factor = SparseFactor::new("fluid block", &fluid, &order, quasi, GROUP)?;

        let a = system.velocity_block();
        let (velocity, m, size) = (3 * a.nodes(), a.border_len(), fluid.rows());
        let mut lifted = vec![0.0; size * m];
        let columns = Rows::of(a.border());
        for i in 0..velocity {
            for (c, v) in columns.row(i) {
                lifted[size * c + i] = v;
            }
        }
        let columns = Rows::of(system.border_divergence());
        for q in 0..system.pressure_range().len() {
            for (c, v) in columns.row(q) {
                lifted[size * c + velocity + q] = v;
            }
        }
        factor.solve_in_place(&mut lifted);
        let mut schur: DMatrix<f64> = a.corner().clone();
        for d in 0..m {
            let column = &lifted[size * d..size * (d + 1)];
            for c in 0..m {
                schur[(c, d)] -= border_row(system, c, column);
            }
        }
        Ok(SaddleLdlt {
            rel_tol: params.rel_tol,
            max_refinements: params.max_refinements,
            factor,
            lifted,
            schur: SchurFactor::new(schur)?,
            enclosed: is_enclosed(system),
            system,
        })
    }

    /// Entries of the factor, 8 bytes each.
    pub fn entries(&self) -> usize {
        self.factor.entries()
    }

    /// Solves `A x = b`; refines until the true residual reaches `rel_tol`.
    ///
    /// `iterations` of the report counts solves with the factor. In enclosed flow the pressure has mean zero over its unknowns.
    ///
    /// # Errors
    /// [`LinalgError::Stagnated`] when refinement stalls (with the best solution in `x`), [`LinalgError::NotConverged`],
    /// [`LinalgError::Breakdown`] for NaN, [`LinalgError::Shape`], [`LinalgError::NotFinite`].
    pub fn solve(&mut self, b: &[f64], x: &mut [f64]) -> Result<SolveReport, LinalgError> {
        let n = self.system.rows();
        check_shape("right-hand side", (b.len(), 1), (n, 1))?;
        check_shape("solution vector", (x.len(), 1), (n, 1))?;
        check_finite("right-hand side", b)?;
        x.fill(0.0);
        let b_norm = norm(b);
        if b_norm == 0.0 {
            return Ok(SolveReport {
                iterations: 0,
                true_rel_residual: 0.0,
                history: vec![0.0],
            });
        }
        let mut r = b.to_vec();
        let mut trial = vec![0.0; n];
        let mut history = vec![1.0];
        loop {
            let iterations = history.len() - 1;
            let residual = history[iterations];
            if residual <= self.rel_tol {
                return Ok(SolveReport {
                    iterations,
                    true_rel_residual: residual,
                    history,
                });
            }
            if iterations > self.max_refinements {
                return Err(LinalgError::NotConverged {
                    method: METHOD,
                    iterations,
                    true_rel_residual: residual,
                    target: self.rel_tol,
                });
            }
            trial.copy_from_slice(x);
            self.add_correction(&r, &mut trial);
            self.system.apply(&trial, &mut r);
            subtract_from(b, &mut r);
            let next = norm(&r) / b_norm;
            if next.is_nan() {
                return Err(LinalgError::Breakdown {
                    method: METHOD,
                    iteration: iterations,
                    cause: "the factor returned NaN",
                });
            }
            // a step that does not even halve the residual is at the level of rounding
            if next > 0.5 * residual {
                return Err(LinalgError::Stagnated {
                    method: METHOD,
                    iterations: iterations + 1,
                    true_rel_residual: residual,
                    target: self.rel_tol,
                });
            }
            x.copy_from_slice(&trial);
            history.push(next);
        }
    }

    /// `x <- x + N r` with the factors of the shifted system.
    fn add_correction(&mut self, r: &[f64], x: &mut [f64]) {
        let (velocity, pressure) = (self.system.velocity_range(), self.system.pressure_range());
        let border = self.system.border_range();
        let mut t = [&r[velocity.clone()], &r[pressure.clone()]].concat();
        self.factor.solve_in_place(&mut t);
        let mut v = DVector::from_fn(border.len(), |c, _| {
            r[border.start + c] - border_row(self.system, c, &t)
        });
        self.schur.solve(&mut v);
        for (column, v) in self.lifted.chunks_exact(t.len().max(1)).zip(v.iter()) {
            axpy(-v, column, &mut t);
        }
        let (u, p) = t.split_at_mut(velocity.len());
        if self.enclosed {
            let mean = p.iter().sum::<f64>() / p.len() as f64;
            p.iter_mut().for_each(|p| *p -= mean);
        }
        axpy(1.0, u, &mut x[velocity]);
        axpy(1.0, v.as_slice(), &mut x[border]);
        axpy(1.0, p, &mut x[pressure]);
    }
}

/// `(C_l^T u + E_l^T p)_c` of a fluid vector `[u; p]`.
fn border_row(system: &SaddleSystem, c: usize, fluid: &[f64]) -> f64 {
    let a = system.velocity_block();
    let (u, p) = fluid.split_at(3 * a.nodes());
    long_row(Rows::of(a.border_rows()), c, u) + long_row(Rows::of(system.border_gradient()), c, p)
}

/// `[K (x) I3, B^T; B, -shift diag(M_p)]`.
fn fluid_block(system: &SaddleSystem, shift: f64) -> Csr {
    let a = system.velocity_block();
    let (k, b, bt) = (
        Rows::of(a.stiffness()),
        Rows::of(system.divergence()),
        Rows::of(system.gradient()),
    );
    let mass = crate::csr::diagonal(system.pressure_mass());
    let velocity = 3 * a.nodes();
    let size = velocity + mass.len();
    build_rows(size, size, |i, row| {
        if i < velocity {
            let d = i % 3;
            for (j, v) in k.row(i / 3) {
                row.add(3 * j + d, v);
            }
            for (q, w) in bt.row(i / 3) {
                row.add(velocity + q, w[d]);
            }
        } else {
            let q = i - velocity;
            for (j, w) in b.row(q) {
                for (d, v) in w.iter().enumerate() {
                    row.add(3 * j + d, *v);
                }
            }
            row.add(i, -shift * mass[q]);
        }
    })
}

/// Nested dissection of the graph whose vertices are velocity nodes (three unknowns) and pressures (one), expanded.
fn elimination_order(system: &SaddleSystem) -> Result<Vec<usize>, LinalgError> {
    let a = system.velocity_block();
    let (n, np) = (a.nodes(), system.pressure_range().len());
    let (k, b, bt) = (
        Rows::of(a.stiffness()),
        Rows::of(system.divergence()),
        Rows::of(system.gradient()),
    );
    let mut adjacency = Vec::with_capacity(n + np);
    for i in 0..n {
        let velocities = k.row(i).map(|(j, _)| j as u32).filter(|&j| j as usize != i);
        adjacency.push(
            velocities
                .chain(bt.row(i).map(|(q, _)| (n + q) as u32))
                .collect(),
        );
    }
    for q in 0..np {
        adjacency.push(b.row(q).map(|(j, _)| j as u32).collect());
    }
    let weights: Vec<u32> = (0..n + np).map(|v| if v < n { 3 } else { 1 }).collect();
    let mut order = Vec::with_capacity(3 * n + np);
    for vertex in nested_dissection(&adjacency, &weights)? {
        if vertex < n {
            order.extend(3 * vertex..3 * vertex + 3);
        } else {
            order.push(2 * n + vertex);
        }
    }
    Ok(order)
}

/// Whether `[B^T; E_l^T] 1 = 0` to rounding: nothing then determines the constant pressure.
fn is_enclosed(system: &SaddleSystem) -> bool {
    let (bt, et) = (
        Rows::of(system.gradient()),
        Rows::of(system.border_gradient()),
    );
    // a sum of k terms of size s is zero up to k epsilon s; the factor allows for the rounding of the terms themselves
    let vanishes = |terms: &mut dyn Iterator<Item = f64>| {
        let (mut sum, mut size) = (0.0, 0.0);
        for t in terms {
            sum += t;
            size += t.abs();
        }
        f64::abs(sum) <= 1e-10 * size
    };
    (0..system.velocity_block().nodes())
        .all(|i| (0..3).all(|d| vanishes(&mut bt.row(i).map(|(_, w)| w[d]))))
        && (0..et.indptr.len() - 1).all(|c| vanishes(&mut et.row(c).map(|(_, w)| w)))
}
