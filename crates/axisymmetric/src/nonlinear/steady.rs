//! Steady states by Newton's method and elements of increasing order.

use super::bodies::{AxialBody, check, check_growth};
use super::drive::{SteadyDrive, SteadyParameters};
use super::orders::raise_order;
use super::problem::{Level, Problem, SHARE_OUTSIDE};
use crate::{AxisymmetricError, Surroundings};

/// A steady state.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SteadyState {
    /// Velocity of each body along the axis, in the laboratory.
    pub velocities: Vec<f64>,
    /// Force that each body exerts on the fluid.
    pub forces: Vec<f64>,
    /// Power of the surfaces of bodies and of the wall on the fluid.
    pub power: f64,
    /// Power of the slip of all surfaces on the fluid.
    pub slip_power: f64,
    /// Dissipation `∫ 2 η D:D` in the fluid that is meshed; without inertia it is the power.
    pub dissipation: f64,
    /// Estimated error of velocities and forces, relative to `speed` and `force`: the last change
    /// of the order, and what the regularisation of a viscosity law and neglecting it far away
    /// change.
    pub relative_error: f64,
    /// Largest velocity of the fluid.
    pub speed: f64,
    /// Largest force, or the drag of the largest body at that velocity if that is larger.
    pub force: f64,
    /// Polynomial degree of the velocities.
    pub order: usize,
    /// Number of unknowns.
    pub dofs: usize,
    /// Iterations of Newton's method, of all orders.
    pub iterations: usize,
    /// Relative change of the velocity in the last of them.
    pub change: f64,
}

/// Finds the steady flow around bodies on one axis in a container.
///
/// Navier-Stokes equations at viscosity 1 with elements of increasing order on one mesh, until the
/// results change by less than the tolerance. Newton's method starts from Stokes flow; where it
/// does not converge, the density is increased in steps. The velocities of free bodies are unknowns
/// of the same system, with the balance of the forces as their equations.
///
/// Cost: a few seconds for 1e-6.
///
/// ```
/// use axisymmetric::{AxialBody, AxialSpheroid, Surroundings};
/// use axisymmetric::{SteadyDrive, SteadyParameters, steady_state};
///
/// // A neutral squirmer in a ball that moves with it: its speed does not depend on inertia.
/// let squirmer = AxialBody::free(AxialSpheroid::sphere(0.0, 1.0), 1.0, 0);
/// let slip = |_: usize, [z, r]: [f64; 2]| [-1.5 * r * r, 1.5 * z * r];
/// let drive = SteadyDrive { slip: Some(&slip), moves_with_body: true, ..SteadyDrive::default() };
/// let parameters = SteadyParameters::new(5.0).with_tolerance(1e-5);
/// let ball = Surroundings::Ball { radius: 10.0 };
/// let found = steady_state(&[squirmer], ball, &drive, &parameters)?;
/// // The exact speed in a ball: Stokes flow, whose vorticity over r is constant.
/// let l: f64 = 0.1;
/// let exact = (1.0 - 2.5 * l.powi(3) + 1.5 * l.powi(5)) / (1.0 - l.powi(5));
/// assert!((found.velocities[0] - exact).abs() < 1e-5);
/// # Ok::<(), axisymmetric::AxisymmetricError>(())
/// ```
///
/// # Errors
/// [`AxisymmetricError::NoContainer`], [`AxisymmetricError::NotSteady`],
/// [`AxisymmetricError::FlowNotConverged`], numbers out of range, lists that do not fit the
/// bodies, and domains that cannot be meshed.
pub fn steady_state(
    bodies: &[AxialBody],
    surroundings: Surroundings,
    drive: &SteadyDrive,
    parameters: &SteadyParameters,
) -> Result<SteadyState, AxisymmetricError> {
    check("the density of the fluid", parameters.density)?;
    check_growth(parameters.growth)?;
    let mut problem = Problem::new(bodies, surroundings, drive, parameters)?;
    problem.choose_open_radius(SHARE_OUTSIDE * parameters.tolerance)?;
    let solve = |order: usize, lower: Option<&Level>| problem.solve(order, lower);
    let (level, error) = raise_order(parameters.tolerance, solve, |before, after| {
        problem.difference(before, after)
    })?;
    Ok(SteadyState {
        velocities: level.velocities,
        forces: level.forces,
        power: level.power,
        slip_power: level.slip_power,
        dissipation: level.dissipation,
        relative_error: error + level.outside + level.regularised,
        speed: level.speed,
        force: level.force,
        order: level.order,
        dofs: level.dofs,
        iterations: level.iterations,
        change: level.change,
    })
}
