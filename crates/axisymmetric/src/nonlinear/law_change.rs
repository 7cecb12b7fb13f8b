//! What a viscosity law changes about Newtonian flow, to first order.

use rheology::ViscosityLaw;

use super::bodies::AxialBody;
use super::drive::{SteadyDrive, SteadyParameters};
use super::orders::raise_order;
use super::problem::{FirstOrderChange, Level, Problem, SHARE_OUTSIDE, check_plateau};
use crate::{AxisymmetricError, Surroundings};

/// A Newtonian flow at the viscosity at rest, and the first-order changes by a viscosity law.
///
/// The two forms of the change bracketed the true one in all squirmers in a fluid of Carreau that
/// were tried; no theorem says that they must.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LawChange {
    /// Velocity of each body in the Newtonian fluid.
    pub velocities: Vec<f64>,
    /// Force that each body exerts on the Newtonian fluid.
    pub forces: Vec<f64>,
    /// Changes of both by the viscosity at the shear rates of the Newtonian flow.
    pub by_viscosity: AxialChange,
    /// Changes by the first term of the viscosity for small shear rates, `g^2`; none for laws
    /// without it.
    pub by_square: Option<AxialChange>,
    /// Estimated error of the Newtonian flow, relative to the largest velocity and force, and of
    /// the changes by the viscosity, relative to the power that the viscosity changes.
    pub relative_error: f64,
}

/// Changes of the motion of bodies.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct AxialChange {
    /// Of the velocity of each body.
    pub velocities: Vec<f64>,
    /// Of the force of each body on the fluid.
    pub forces: Vec<f64>,
}

/// The first-order change of a flow by a viscosity law, without inertia.
///
/// `V_1 = -∫ 2 (η(g) - η_0) D(u):D(v)` with the Newtonian flow `u` at the viscosity `η_0` at rest
/// and the flow `v` of a unit force (Lauga 2014, reciprocal theorem; Datt, Zhu, Elfring & Pak
/// 2015). Cost: a Newtonian flow and two right-hand sides.
///
/// ```
/// use axisymmetric::{AxialBody, AxialSpheroid, SteadyDrive, Surroundings, law_change};
/// use rheology::Law;
///
/// let law = Law::Carreau {
///     zero_shear_viscosity: 1.0,
///     infinite_shear_viscosity: 0.0,
///     relaxation_time: 0.01,
///     index: 0.5,
/// };
/// let slip = |_: usize, [z, r]: [f64; 2]| [-1.5 * r * r, 1.5 * z * r];
/// let drive = SteadyDrive { slip: Some(&slip), ..SteadyDrive::default() };
/// let squirmer = AxialBody::free(AxialSpheroid::sphere(0.0, 1.0), 0.0, 0);
/// let found = law_change(&[squirmer], Surroundings::Unbounded, &drive, &law, 1e-6)?;
/// // (n - 1) / 2 (λ U)^2 72 / 65, by integration
/// let exact = -0.25e-4 * 72.0 / 65.0;
/// assert!((found.by_viscosity.velocities[0] / exact - 1.0).abs() < 2e-3);
/// assert!((found.velocities[0] - 1.0).abs() < 1e-6);
/// # Ok::<(), axisymmetric::AxisymmetricError>(())
/// ```
///
/// # Errors
/// [`AxisymmetricError::NoPlateau`] for laws without a viscosity at rest;
/// [`AxisymmetricError::FlowNotConverged`], numbers out of range, lists that do not fit the bodies,
/// and domains that cannot be meshed.
pub fn law_change(
    bodies: &[AxialBody],
    surroundings: Surroundings,
    drive: &SteadyDrive,
    law: &dyn ViscosityLaw,
    tolerance: f64,
) -> Result<LawChange, AxisymmetricError> {
    let parameters = SteadyParameters::new(0.0).with_law(law);
    check_plateau(Some(law))?;
    let mut problem = Problem::new(bodies, surroundings, drive, &parameters)?;
    problem.choose_open_radius_for_change(SHARE_OUTSIDE * tolerance)?;
    let problem = problem.newtonian();
    let solve = |order: usize, lower: Option<&(Level, FirstOrderChange)>| {
        let level = problem.solve(order, lower.map(|(level, _)| level))?;
        let change = problem.first_order_change(&level, law)?;
        Ok((level, change))
    };
    let ((level, change), error) = raise_order([tolerance, 0.0], solve, |before, after| {
        let of_flow = problem.difference(&before.0, &after.0);
        of_flow.max(problem.difference_of_changes(&before.1, &after.1, &after.0))
    })?;
    let named = |change: FirstOrderChange| AxialChange {
        velocities: change.velocities,
        forces: change.forces,
    };
    let by_square = match Square::at_rest(law, problem.typical_rate(&level)) {
        Some(square) => Some(named(problem.first_order_change(&level, &square)?)),
        None => None,
    };
    Ok(LawChange {
        velocities: level.state.velocities,
        forces: level.state.forces,
        by_viscosity: named(change),
        by_square,
        relative_error: error + SHARE_OUTSIDE * tolerance,
    })
}

/// The law `η_0 + c g^2`.
#[derive(Clone, Copy, Debug)]
struct Square {
    rest: f64,
    coefficient: f64,
}

impl Square {
    /// The first two terms of a law for small shear rates; none if the second one is not a square.
    fn at_rest(law: &dyn ViscosityLaw, rate: f64) -> Option<Self> {
        // The next term is smaller by the square of the rate, relative to that of the flow.
        let [one, other] = [1e-5, 1e-6].map(|part| {
            let rate = part * rate;
            law.derivative(rate) / (2.0 * rate)
        });
        let agrees = (one - other).abs() <= 1e-6 * one.abs();
        agrees.then_some(Self {
            rest: law.viscosity(0.0),
            coefficient: other,
        })
    }
}

impl ViscosityLaw for Square {
    fn viscosity(&self, rate: f64) -> f64 {
        self.rest + self.coefficient * rate * rate
    }

    fn derivative(&self, rate: f64) -> f64 {
        2.0 * self.coefficient * rate
    }

    fn potential(&self, rate: f64) -> f64 {
        0.5 * rate * rate * (self.rest + 0.5 * self.coefficient * rate * rate)
    }
}
