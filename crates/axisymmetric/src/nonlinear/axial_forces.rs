//! Forces on bodies as functions of their velocities, in a fluid with a viscosity law.

use nalgebra::DMatrix;
use rheology::ViscosityLaw;

use super::bodies::AxialBody;
use super::drive::{Slip, SteadyDrive, SteadyParameters};
use super::orders::{FIRST_ORDER, MIN_GROWTH, REFINEMENT};
use super::problem::{Level, Problem, SHARE_OUTSIDE};
use crate::solver::MAX_ORDER;
use crate::{AxialSpheroid, AxisymmetricError, Surroundings};

/// Forces on bodies with given velocities.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct AxialForces {
    /// Force that each body exerts on the fluid.
    pub forces: Vec<f64>,
    /// Derivatives of the forces (rows) by the velocities, symmetric and positive definite.
    pub derivatives: DMatrix<f64>,
    /// Power of the slip on the fluid.
    pub slip_power: f64,
    /// Largest component of the velocity of the fluid.
    pub largest_speed: f64,
    /// Estimated relative error of forces by neglecting the law in unbounded fluid beyond the mesh.
    pub error_outside: f64,
    /// Relative change of the power by the regularisation of the law.
    pub regularised: f64,
    /// Polynomial degree of the velocities.
    pub order: usize,
    /// Number of unknowns.
    pub dofs: usize,
    /// Iterations of Newton's method so far.
    pub iterations: usize,
}

/// Forces on bodies in one configuration as functions of their velocities, in a fluid with a
/// viscosity law and without inertia.
///
/// There is no resistance matrix, as forces are not linear in velocities. Who knows the joints of
/// the bodies finds velocities by Newton's method with the derivatives. Flows start from the one
/// before, moved along its derivatives.
///
/// ```
/// use axisymmetric::{AxialForceSolver, AxialSpheroid, Surroundings};
/// use rheology::Law;
///
/// let law = Law::PowerLaw { consistency: 1.0, index: 0.8, regularisation: 1e-9 };
/// let sphere = AxialSpheroid::sphere(0.0, 1.0);
/// let ball = Surroundings::Ball { radius: 10.0 };
/// let mut solver = AxialForceSolver::new(&[sphere], ball, None, &law, 1e-4)?;
/// let [slow, fast] = [solver.solve(&[1.0])?, solver.solve(&[2.0])?];
/// // Forces in a power law are homogeneous: F ~ U^n and U dF/dU = n F.
/// assert!((fast.forces[0] / slow.forces[0] - 2.0_f64.powf(0.8)).abs() < 1e-6);
/// assert!((slow.derivatives[(0, 0)] / (0.8 * slow.forces[0]) - 1.0).abs() < 1e-6);
/// # Ok::<(), axisymmetric::AxisymmetricError>(())
/// ```
pub struct AxialForceSolver<'a> {
    problem: Problem<'a>,
    tolerance: f64,
    order: usize,
    level: Option<Level>,
}

impl<'a> AxialForceSolver<'a> {
    /// The solver for bodies with this slip, by elements of the lowest order, from which an error
    /// is to be estimated: one less than that of results.
    ///
    /// In unbounded fluid the mesh is chosen at the first velocities, so that neglecting the
    /// viscosity beyond it takes a tenth of `tolerance`.
    ///
    /// # Errors
    /// [`AxisymmetricError::NoPlateau`], domains that are not valid.
    pub fn new(
        bodies: &[AxialSpheroid],
        surroundings: Surroundings,
        slip: Option<Slip<'a>>,
        law: &'a dyn ViscosityLaw,
        tolerance: f64,
    ) -> Result<Self, AxisymmetricError> {
        let bodies: Vec<AxialBody> = bodies.iter().map(|b| AxialBody::prescribed(*b)).collect();
        let drive = SteadyDrive {
            slip,
            ..SteadyDrive::default()
        };
        let parameters = SteadyParameters::new(0.0)
            .with_law(law)
            .with_tolerance(tolerance);
        Ok(Self {
            problem: Problem::new(&bodies, surroundings, &drive, &parameters)?,
            tolerance,
            order: FIRST_ORDER - 1,
            level: None,
        })
    }

    /// Raises the order of the elements; `false` if it is the highest.
    pub fn raise_order(&mut self) -> bool {
        let can = self.order < MAX_ORDER;
        self.order += usize::from(can);
        can
    }

    /// Number of orders above the present one.
    pub fn orders_left(&self) -> usize {
        MAX_ORDER - self.order
    }

    /// Returns to the lowest order, on a mesh whose edges are two thirds as long; `false` if it is
    /// the finest.
    ///
    /// Orders converge on any mesh, but slowly where the viscosity varies within one triangle.
    pub fn refine(&mut self) -> bool {
        let can = self.problem.refine(REFINEMENT, MIN_GROWTH);
        if can {
            self.order = FIRST_ORDER - 1;
            self.level = None;
        }
        can
    }

    /// Changes of the forces at the last velocities, to first order, if the law loses its
    /// regularisation; zero before the first velocities.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`], [`AxisymmetricError::SingularElement`].
    pub fn change_by_regularisation(&self) -> Result<Vec<f64>, AxisymmetricError> {
        match &self.level {
            Some(level) => {
                let [_, forces] = self.problem.change_by_regularisation(level)?;
                Ok(forces)
            }
            None => Ok(Vec::new()),
        }
    }

    /// The forces for these velocities along the axis.
    ///
    /// # Errors
    /// [`AxisymmetricError::LawNotSolved`], [`AxisymmetricError::NoPlateau`] for a viscosity that
    /// does not reach that at rest, velocities that are not one finite number per body, domains
    /// that cannot be meshed.
    pub fn solve(&mut self, velocities: &[f64]) -> Result<AxialForces, AxisymmetricError> {
        self.problem.set_velocities(velocities)?;
        let level = match self.level.take() {
            None => {
                self.problem
                    .choose_open_radius(SHARE_OUTSIDE * self.tolerance)?;
                self.problem.solve(self.order, None)?
            }
            Some(level) if level.state.order < self.order => {
                self.problem.solve(self.order, Some(&level))?
            }
            Some(level) if level.state.velocities == velocities => level,
            Some(level) => self.problem.solve_again(level)?,
        };
        let responses = self.problem.responses(&level)?;
        let of_bodies: f64 = level
            .state
            .forces
            .iter()
            .zip(velocities)
            .map(|(f, u)| f * u)
            .sum();
        let found = AxialForces {
            // symmetric up to rounding
            derivatives: 0.5 * (&responses.forces + responses.forces.transpose()),
            slip_power: level.state.power - of_bodies,
            forces: level.state.forces.clone(),
            largest_speed: level.state.speed,
            error_outside: level.outside,
            regularised: level.regularised,
            order: level.state.order,
            dofs: level.state.dofs,
            iterations: level.state.iterations,
        };
        self.level = Some(level);
        Ok(found)
    }
}
