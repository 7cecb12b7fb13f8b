//! Steady states by Newton's method and elements of increasing order.

use super::bodies::{AxialBody, check, check_growth};
use super::drive::{SteadyDrive, SteadyParameters};
use super::orders::raise_order;
use super::problem::{Level, Problem, SHARE_OUTSIDE, SteadyState};
use crate::{AxisymmetricError, Surroundings};

/// Bar for the regularisation of a viscosity law over its effect to first order.
///
/// In random scenes the effect was up to 1.6 times its first order
/// (`docs/figures/random_cases.py`, laws).
pub const REGULARISATION_FACTOR: f64 = 2.0;

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
    let tolerances = [parameters.tolerance, parameters.accepted];
    let (level, error) = raise_order(tolerances, solve, |before, after| {
        problem.difference(before, after)
    })?;
    Ok(SteadyState {
        relative_error: error
            + level.outside
            + REGULARISATION_FACTOR * problem.effect_of_regularisation(&level)?,
        ..level.state
    })
}
