//! What the inertia that Stokes flow neglects would change, to first order.

use crate::error::ModelError;
use crate::query::Configuration;
use crate::response::Response;

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

/// First-order changes of motion and loads by inertia, by cause, in the scene's units.
///
/// With inertia, the solution has their sum in addition, up to terms of second order in the
/// densities.
#[derive(Clone, Debug, PartialEq)]
pub struct InertialChange {
    /// By the unsteady acceleration of the fluid, `ρ ∂u/∂t`.
    pub unsteady: Response,
    /// By the convective acceleration of the fluid, `ρ (u · ∇) u`.
    pub convective: Response,
    /// By the inertia of the bodies. A body without a density has that of the fluid.
    pub bodies: Response,
}

impl InertialChange {
    /// Names and changes of the causes, in the order of the fields.
    pub fn causes(&self) -> [(&'static str, &Response); 3] {
        [
            ("unsteady", &self.unsteady),
            ("convective", &self.convective),
            ("bodies", &self.bodies),
        ]
    }

    /// The change by all causes.
    pub fn total(&self) -> Response {
        self.unsteady.clone() + &self.convective + &self.bodies
    }
}

/// Models that compute what inertia would change about their velocities.
///
/// The velocities `V_0` of Stokes flow `u_0` change to first order by
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
pub trait NeglectedInertia {
    /// Change of motion and loads at a point of a path.
    ///
    /// # Errors
    /// [`ModelError::Unsupported`] for what has no such change; those of
    /// [`Hydrodynamics::solve`](crate::Hydrodynamics::solve).
    fn change(&mut self, at: &PathPoint<'_>) -> Result<InertialChange, ModelError>;

    /// Change of the displacements, which have the place of velocities, by a jump of the rates of
    /// the joints from `before` to `after`.
    ///
    /// It is the integral of [`NeglectedInertia::change`] over the time in which the rates change,
    /// in the limit of a short time: long compared with that of diffusion, short compared with that
    /// of the motion. Loads have the place of forces in the same way.
    ///
    /// # Errors
    /// As [`NeglectedInertia::change`].
    fn jump(
        &mut self,
        configuration: Configuration<'_>,
        before: &[f64],
        after: &[f64],
    ) -> Result<InertialChange, ModelError>;
}
