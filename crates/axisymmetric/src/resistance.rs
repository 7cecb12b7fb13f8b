//! Resistance matrices with error estimates, from elements of increasing order on one mesh.

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::AxisymmetricError;
use crate::collar::{Collars, Motion};
use crate::curve::BoundaryPart;
use crate::generate::generate;
use crate::meridian::{GROWTH, Meridian, Surroundings};
use crate::mesh::MeridianMesh;
use crate::open_boundary::{exterior_flow, exterior_swirl};
use crate::spheroid::Spheroid;
use crate::swirl::omitted_torque;
use crate::system::{Dof, Element, Solution};

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
    dofs: usize,
    order: usize,
    triangles: usize,
    residual: f64,
}

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
    ResistanceSolver::new().axial(bodies, surroundings, tolerance)
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
    ResistanceSolver::new().spin(bodies, surroundings, tolerance)
}

/// Computes the resistances of successive configurations, and keeps what they have in common.
///
/// Around each body with enough clearance lies a collar: the fluid up to a confocal spheroid of one
/// of a few sizes. It moves rigidly with the body, so its matrices do not change. They are computed
/// once for each shape of body and size of collar, and condensed to the degrees of freedom on the
/// outline. A solution then takes the fluid between the collars only.
///
/// Results do not depend on what was computed before, not even in the last bit.
///
/// ```
/// use axisymmetric::{ResistanceSolver, Spheroid, Surroundings};
///
/// let mut solver = ResistanceSolver::new();
/// let mut attraction = |distance| {
///     let pair = [Spheroid::sphere(0.0, 1.0), Spheroid::sphere(distance, 1.0)];
///     let found = solver.axial(&pair, Surroundings::Unbounded, 1e-4)?;
///     Ok::<f64, axisymmetric::AxisymmetricError>(found.matrix()[(0, 1)])
/// };
/// assert!(attraction(6.0)? < attraction(10.0)?);
/// # Ok::<(), axisymmetric::AxisymmetricError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct ResistanceSolver {
    collars: Collars,
}

impl ResistanceSolver {
    /// A solver that has not computed anything.
    pub fn new() -> Self {
        Self::default()
    }

    /// As [`axial_resistance`].
    ///
    /// # Errors
    /// Those of [`axial_resistance`].
    pub fn axial(
        &mut self,
        bodies: &[Spheroid],
        surroundings: Surroundings,
        tolerance: f64,
    ) -> Result<AxialResistance, AxisymmetricError> {
        self.converged(bodies, surroundings, tolerance, Motion::Translation)
    }

    /// As [`spin_resistance`].
    ///
    /// # Errors
    /// Those of [`axial_resistance`].
    pub fn spin(
        &mut self,
        bodies: &[Spheroid],
        surroundings: Surroundings,
        tolerance: f64,
    ) -> Result<AxialResistance, AxisymmetricError> {
        self.converged(bodies, surroundings, tolerance, Motion::Rotation)
    }

    /// Raises the order until the estimated error is below `tolerance`.
    fn converged(
        &mut self,
        bodies: &[Spheroid],
        surroundings: Surroundings,
        tolerance: f64,
        motion: Motion,
    ) -> Result<AxialResistance, AxisymmetricError> {
        if !(tolerance > 0.0 && tolerance < 1.0) {
            return Err(AxisymmetricError::InvalidTolerance { tolerance });
        }
        let meridian = Meridian::new(bodies, surroundings)?.without_collars();
        let mesh = generate(&meridian, GROWTH)?;
        let discretisation = Discretisation {
            meridian: &meridian,
            mesh: &mesh,
            bodies,
            motion,
        };
        let first = first_order(tolerance);
        let mut solve = |orders: Vec<usize>| -> Result<Vec<Solution>, AxisymmetricError> {
            self.collars.provide(&meridian, motion, &orders)?;
            let collars = &self.collars;
            // each factorisation is too small for many threads, so orders are solved in parallel
            (orders.into_par_iter())
                .map(|order| discretisation.solve(order, collars))
                .collect()
        };
        let mut last = solve(vec![first, first + 1, first + 2])?;
        let mut order = first + 2;
        loop {
            let found = discretisation.estimated(order, &last);
            if found.relative_error() <= tolerance.max(MIN_TOLERANCE) || order == MAX_ORDER {
                return Ok(found);
            }
            order += 1;
            last.rotate_left(1);
            last[2] = solve(vec![order])?.remove(0);
        }
    }
}

/// The problem and its mesh, which solutions of all orders share.
struct Discretisation<'a> {
    meridian: &'a Meridian,
    mesh: &'a MeridianMesh,
    /// Bodies in the caller's order.
    bodies: &'a [Spheroid],
    motion: Motion,
}

impl Discretisation<'_> {
    /// The resistance by elements of this order.
    fn solve(&self, order: usize, collars: &Collars) -> Result<Solution, AxisymmetricError> {
        let mut system = self.motion.system(self.mesh, order)?;
        for (number, body, outline) in self.meridian.collars() {
            let mut dofs = system.trace(BoundaryPart::Interface(number)).to_vec();
            dofs.push(Dof::Body(number));
            let matrix = collars.matrix(&body, &outline, self.motion, order);
            system.elements.push(Element { dofs, matrix });
        }
        if let Some(radius) = self.meridian.open_radius() {
            let matrix = match self.motion {
                Motion::Translation => exterior_flow(self.mesh, order, radius),
                Motion::Rotation => exterior_swirl(self.mesh, order, radius),
            };
            // the pressures on the boundary are not degrees of freedom of the flow beyond it
            let dofs = system.trace(BoundaryPart::Open)[..matrix.nrows()].to_vec();
            system.elements.push(Element { dofs, matrix });
        }
        let mut solution = system.resistance(self.bodies.len())?;
        if self.motion == Motion::Rotation {
            for (i, body) in self.bodies.iter().enumerate() {
                solution.resistance[(i, i)] += omitted_torque(body);
            }
        }
        Ok(solution)
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
            dofs: last.n_dofs,
            order,
            triangles: self.mesh.triangles.len(),
            residual: last.residual,
        }
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
