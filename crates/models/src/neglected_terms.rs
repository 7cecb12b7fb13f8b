//! What terms that Newtonian Stokes flow neglects would change, to first order.

use crate::error::ModelError;
use crate::query::Configuration;
use crate::response::Response;

/// A term of the equations that Newtonian Stokes flow does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NeglectedTerm {
    /// The inertia of fluid and bodies.
    ///
    /// The parts of a change are its causes and add up: `unsteady`, the acceleration `ρ ∂u/∂t`;
    /// `convective`, `ρ (u · ∇) u`; `bodies`, that of the bodies, of which one without a density
    /// has that of the fluid.
    Inertia,
    /// The viscosity law, by which the viscosity depends on the shear rate.
    ///
    /// The parts of a change are two forms of it: `viscosity`, by the viscosity at the shear rates
    /// of the Newtonian flow, and `second_order`, by the term of the law of second order in the
    /// rate, if it begins with one.
    Rheology,
}

impl NeglectedTerm {
    /// All terms.
    pub const ALL: [Self; 2] = [Self::Inertia, Self::Rheology];

    /// The term in a sentence.
    pub fn name(self) -> &'static str {
        match self {
            Self::Inertia => "inertia",
            Self::Rheology => "the viscosity law",
        }
    }

    /// Whether the parts of a change add up; otherwise they are forms of the same change.
    pub fn adds_up(self) -> bool {
        self == Self::Inertia
    }
}

/// A configuration on a path, with the rates and accelerations of the joints there.
#[derive(Clone, Copy, Debug)]
pub struct PathPoint<'a> {
    /// Positions of the bodies.
    pub configuration: Configuration<'a>,
    /// Rate of change of each joint, in the scene's units.
    pub rates: &'a [f64],
    /// Rate of change of the rate of each joint.
    pub accelerations: &'a [f64],
}

/// First-order changes of motion and loads by a neglected term, in the scene's units.
#[derive(Clone, Debug, PartialEq)]
pub struct FirstOrderChange {
    /// Names of the parts, which are those of the [`NeglectedTerm`], with the changes.
    pub parts: Vec<(&'static str, Response)>,
}

impl FirstOrderChange {
    /// The two forms of the change by a viscosity law, each converted from what a model finds.
    ///
    /// # Errors
    /// Those of `convert`.
    pub(crate) fn by_law<T>(
        viscosity: &T,
        second_order: Option<&T>,
        convert: impl Fn(&T) -> Result<Response, ModelError>,
    ) -> Result<Self, ModelError> {
        let mut parts = vec![("viscosity", convert(viscosity)?)];
        if let Some(change) = second_order {
            parts.push(("second_order", convert(change)?));
        }
        Ok(Self { parts })
    }

    /// The change by one part; none if there is no such part.
    pub fn part(&self, name: &str) -> Option<&Response> {
        let found = self.parts.iter().find(|(part, _)| *part == name);
        found.map(|(_, response)| response)
    }
}

/// Models that compute what neglected terms would change about their velocities.
///
/// With inertia, the velocities `V_0` of Stokes flow `u_0` change to first order by
///
/// ```text
/// V_1 = -ρ ∫ (∂u_0/∂t + (u_0 · ∇) u_0) · z dV - sum_b m_b A_b · Z_b
/// ```
///
/// with the adjoint Stokes flow `z` of each velocity (the reciprocal theorem), its velocities `Z_b`
/// of the bodies and their accelerations `A_b` in `u_0`. This holds as long as vorticity diffuses
/// through the fluid around the bodies in a short time compared with that of the motion: for a
/// small frequency parameter `S = ρ ω L^2 / μ` and Reynolds number. In unbounded fluid a total
/// force on it has effects of lower order, `sqrt(S)` (Basset) and `Re` far away (Oseen), which no
/// such integral has.
///
/// With a viscosity law `η(g)`, of the shear rate `g`, they change by
///
/// ```text
/// V_1 = -∫ 2 (η(g_0) - η(0)) D(u_0) : ∇z dV
/// ```
///
/// In place of `η(g) - η(0)` the law has its first term `c g^2` in the form `second_order`. No
/// theorem says that the true change is between both; it was for all squirmers in a fluid of
/// Carreau that were tried.
pub trait NeglectedTerms {
    /// Change of motion and loads by a term at a point of a path.
    ///
    /// # Errors
    /// [`ModelError::Unsupported`] for what has no such change; those of
    /// [`Hydrodynamics::solve`](crate::Hydrodynamics::solve).
    fn change(
        &mut self,
        term: NeglectedTerm,
        at: &PathPoint<'_>,
    ) -> Result<FirstOrderChange, ModelError>;

    /// Change by inertia of the displacements, which have the place of velocities, by a jump of the
    /// rates of the joints from `before` to `after`.
    ///
    /// It is the integral of [`NeglectedTerms::change`] over the time in which the rates change, in
    /// the limit of a short time: long compared with that of diffusion, short compared with that of
    /// the motion. Loads have the place of forces in the same way.
    ///
    /// # Errors
    /// As [`NeglectedTerms::change`].
    fn jump(
        &mut self,
        configuration: Configuration<'_>,
        before: &[f64],
        after: &[f64],
    ) -> Result<FirstOrderChange, ModelError>;
}
