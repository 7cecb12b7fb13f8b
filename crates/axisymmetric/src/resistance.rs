//! Resistance matrices with error estimates, from elements of increasing order on one mesh.

use std::f64::consts::PI;

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::AxisymmetricError;
use crate::generate::generate;
use crate::meridian::{Meridian, Spheroid, Surroundings};
use crate::mesh::MeridianMesh;
use crate::stokes::stokes;
use crate::swirl::{omitted_torque, swirl};
use crate::system::Solution;

/// Resistance matrix `R` of motions along the axis or about it, with an error estimate.
///
/// `F_i = sum_j R_ij U_j` are the forces (torques) that the bodies exert on the fluid when they
/// move with the velocities (angular velocities) `U_j`. The viscosity is 1. `R` is symmetric
/// positive definite.
#[derive(Clone, Debug, PartialEq)]
pub struct AxialResistance {
    matrix: DMatrix<f64>,
    lower_order: DMatrix<f64>,
    error_factor: f64,
    truncation_error: f64,
    dofs: usize,
    order: usize,
    triangles: usize,
    residual: f64,
}

/// Edge length relative to the distance from the focus of the nearest body.
///
/// Shorter edges need more degrees of freedom for the same error, longer ones a higher order;
/// between 0.6 and 1 it matters little (measured on spheres and spheroids in balls and tubes).
const GROWTH: f64 = 0.65;

/// Highest order: above it the tabulated nodal basis loses digits.
const MAX_ORDER: usize = 10;

/// The first of three orders, of which the last is likely to meet the tolerance.
///
/// The error of order `k` is about `10^-k`. The three orders are at least 3, 4, 5: from five on the
/// error decreases regularly enough for the estimate.
fn first_order(tolerance: f64) -> usize {
    ((-tolerance.log10()).ceil() as usize).clamp(5, MAX_ORDER) - 2
}

/// Bounds on the factor by which one order reduces the error, when the last change is extrapolated.
///
/// A smaller observed factor is considered accidental. A larger one means that the orders do not
/// converge yet.
const REDUCTION: [f64; 2] = [0.08, 0.6];

/// Smallest tolerance; rounding in the factorisation causes errors of about a hundredth of it.
const MIN_TOLERANCE: f64 = 1e-11;

/// Computes the resistance to motion along the axis to a relative `tolerance`.
///
/// Uses velocities of degree `k` and pressures of degree `k - 1` on curved triangles. The order `k`
/// increases from three or more until the estimated error, the change from order `k - 1`
/// extrapolated as a geometric series, is below the tolerance. For smooth bodies each order reduces
/// the error by a factor of five to ten. Tolerances below 1e-11, or below the error of order ten,
/// are not reached: see [`AxialResistance::relative_error`].
///
/// Unbounded fluid is replaced by a ball a thousand times as large as the bodies, whose effect is
/// removed to first order in the inverse radius.
///
/// Cost: 1500 to 3000 degrees of freedom per body for 1e-6, 4000 more in unbounded fluid; 0.1 s to
/// 1 s.
///
/// ```
/// use axisymmetric::{Spheroid, Surroundings, axial_resistance};
///
/// let sphere = Spheroid::sphere(0.0, 1.0);
/// let drag = axial_resistance(&[sphere], Surroundings::Ball { radius: 2.0 }, 1e-6)?;
/// let exact = 7.294117647058823 * 6.0 * std::f64::consts::PI; // Haberman & Sayre 1958
/// assert!((drag.matrix()[(0, 0)] / exact - 1.0).abs() < 1e-6);
/// # Ok::<(), axisymmetric::AxisymmetricError>(())
/// ```
///
/// # Errors
/// [`AxisymmetricError`] for sizes that are not positive, bodies that overlap or touch, gaps below
/// 1e-4 of a radius, a tolerance outside (0, 1), and failures of the solver.
pub fn axial_resistance(
    bodies: &[Spheroid],
    surroundings: Surroundings,
    tolerance: f64,
) -> Result<AxialResistance, AxisymmetricError> {
    converged(bodies, surroundings, tolerance, Motion::Translation)
}

/// Computes the resistance to rotation about the axis to a relative `tolerance`.
///
/// Solves a scalar equation without pressure, with a third of the degrees of freedom of
/// [`axial_resistance`]. The ball that replaces unbounded fluid changes torques by a relative 1e-9,
/// the third power of the size of the bodies over the size of the ball.
///
/// ```
/// use axisymmetric::{Spheroid, Surroundings, spin_resistance};
///
/// let sphere = Spheroid::sphere(0.0, 1.0);
/// let torque = spin_resistance(&[sphere], Surroundings::Ball { radius: 2.0 }, 1e-6)?;
/// let exact = 8.0 * std::f64::consts::PI * 8.0 / 7.0; // 1 / (1 - 2^-3)
/// assert!((torque.matrix()[(0, 0)] / exact - 1.0).abs() < 1e-6);
/// # Ok::<(), axisymmetric::AxisymmetricError>(())
/// ```
///
/// # Errors
/// Those of [`axial_resistance`].
pub fn spin_resistance(
    bodies: &[Spheroid],
    surroundings: Surroundings,
    tolerance: f64,
) -> Result<AxialResistance, AxisymmetricError> {
    converged(bodies, surroundings, tolerance, Motion::Rotation)
}

/// The motion of the bodies.
#[derive(Clone, Copy, PartialEq)]
enum Motion {
    /// Along the axis.
    Translation,
    /// About the axis.
    Rotation,
}

/// Raises the order until the estimated error is below `tolerance`.
fn converged(
    bodies: &[Spheroid],
    surroundings: Surroundings,
    tolerance: f64,
    motion: Motion,
) -> Result<AxialResistance, AxisymmetricError> {
    if !(tolerance > 0.0 && tolerance < 1.0) {
        return Err(AxisymmetricError::InvalidTolerance { tolerance });
    }
    let meridian = Meridian::new(bodies, surroundings)?;
    let mesh = generate(&meridian, GROWTH)?;
    let discretisation = Discretisation {
        meridian: &meridian,
        mesh: &mesh,
        unbounded: surroundings == Surroundings::Unbounded,
        bodies,
        motion,
    };
    let first = first_order(tolerance);
    // each factorisation is too small for many threads, so the three run in parallel
    let mut last: Vec<Solution> = [first, first + 1, first + 2]
        .into_par_iter()
        .map(|order| discretisation.solve(order))
        .collect::<Result<_, AxisymmetricError>>()?;
    let mut order = first + 2;
    loop {
        let found = discretisation.estimated(order, &last);
        if found.relative_error() <= tolerance.max(MIN_TOLERANCE) || order == MAX_ORDER {
            return Ok(found);
        }
        order += 1;
        last.rotate_left(1);
        last[2] = discretisation.solve(order)?;
    }
}

/// The problem and its mesh, which solutions of all orders share.
struct Discretisation<'a> {
    meridian: &'a Meridian,
    mesh: &'a MeridianMesh,
    unbounded: bool,
    /// Bodies in the caller's order.
    bodies: &'a [Spheroid],
    motion: Motion,
}

impl Discretisation<'_> {
    /// The resistance by elements of this order.
    fn solve(&self, order: usize) -> Result<Solution, AxisymmetricError> {
        let n = self.bodies.len();
        match self.motion {
            Motion::Translation => {
                let mut solution = stokes(self.mesh, order)?.resistance(n)?;
                if self.unbounded {
                    solution.resistance = self.without_container(&solution.resistance)?;
                }
                Ok(solution)
            }
            Motion::Rotation => {
                let mut solution = swirl(self.mesh, order)?.resistance(n)?;
                for (i, body) in self.bodies.iter().enumerate() {
                    solution.resistance[(i, i)] += omitted_torque(body);
                }
                Ok(solution)
            }
        }
    }

    /// The resistance in unbounded fluid from that in the large ball of radius `R`.
    ///
    /// To first order in `1 / R`, the wall adds to a force `F` near the centre the uniform flow
    /// `-9/4 F / (6 π R)` (Haberman & Sayre 1958; Maul & Kim 1994). All entries of the mobility
    /// matrix change by this same amount.
    fn without_container(
        &self,
        resistance: &DMatrix<f64>,
    ) -> Result<DMatrix<f64>, AxisymmetricError> {
        let inverse =
            |m: DMatrix<f64>| m.try_inverse().ok_or(AxisymmetricError::SingularResistance);
        let radius = self.meridian.ball_radius().unwrap_or(f64::INFINITY);
        let mobility = inverse(resistance.clone())?.add_scalar(2.25 / (6.0 * PI * radius));
        inverse(mobility)
    }

    /// The last of three solutions of successive orders, with its estimated error.
    fn estimated(&self, order: usize, solutions: &[Solution]) -> AxialResistance {
        let [first, second, last] = [0, 1, 2].map(|k| &solutions[k]);
        let change_before = distance(&first.resistance, &second.resistance);
        let change = distance(&second.resistance, &last.resistance);
        let reduction = (change / change_before).clamp(REDUCTION[0], REDUCTION[1]);
        AxialResistance {
            matrix: last.resistance.clone(),
            lower_order: second.resistance.clone(),
            // the remaining sum of the geometric series
            error_factor: if reduction.is_nan() {
                1.0
            } else {
                reduction / (1.0 - reduction)
            },
            truncation_error: if self.unbounded {
                self.truncation_error()
            } else {
                0.0
            },
            dofs: last.n_dofs,
            order,
            triangles: self.mesh.triangles.len(),
            residual: last.residual,
        }
    }

    /// Error left by [`Self::without_container`], relative to a body's own mobility `1 / (6 π a)`.
    ///
    /// The remaining terms are of order `R^-3`, with the factor 5/2 for a sphere at the centre and
    /// about 8/3 each for the distances of the force and of the body from the centre.
    fn truncation_error(&self) -> f64 {
        let radius = self.meridian.ball_radius().unwrap_or(f64::INFINITY);
        let [length, width] = self.meridian.extent();
        8.0 * width * length.max(width).powi(2) / radius.powi(3)
    }
}

/// Largest difference of entries `R_ij`, relative to `sqrt(R_ii R_jj)` of the second matrix.
fn distance(one: &DMatrix<f64>, other: &DMatrix<f64>) -> f64 {
    let mut largest = 0.0_f64;
    for i in 0..one.nrows() {
        for j in 0..one.ncols() {
            let size = (other[(i, i)] * other[(j, j)]).abs().sqrt();
            largest = largest.max((one[(i, j)] - other[(i, j)]).abs() / size);
        }
    }
    largest
}

impl AxialResistance {
    /// The resistance matrix, with the bodies in the caller's order.
    pub fn matrix(&self) -> &DMatrix<f64> {
        &self.matrix
    }

    /// The resistance matrix by elements of one order less, for error estimates.
    ///
    /// See [`AxialResistance::error_factor`].
    pub fn lower_order(&self) -> &DMatrix<f64> {
        &self.lower_order
    }

    /// Ratio of the estimated error to the last change.
    ///
    /// A quantity computed from both [`AxialResistance::matrix`] and
    /// [`AxialResistance::lower_order`] has an estimated error of this factor times the difference
    /// of the two results.
    pub fn error_factor(&self) -> f64 {
        self.error_factor
    }

    /// Relative error caused by the ball that replaces unbounded fluid; zero in a container.
    pub fn truncation_error(&self) -> f64 {
        self.truncation_error
    }

    /// Estimated discretisation error: the largest of an entry `R_ij`, relative to
    /// `sqrt(R_ii R_jj)`.
    pub fn relative_error(&self) -> f64 {
        self.error_factor * distance(&self.lower_order, &self.matrix)
    }

    /// Number of velocity and pressure degrees of freedom of the last system.
    pub fn dofs(&self) -> usize {
        self.dofs
    }

    /// Polynomial degree of the velocities.
    pub fn order(&self) -> usize {
        self.order
    }

    /// Number of triangles of the mesh.
    pub fn triangles(&self) -> usize {
        self.triangles
    }

    /// Largest true relative residual of a solve.
    pub fn residual(&self) -> f64 {
        self.residual
    }
}
