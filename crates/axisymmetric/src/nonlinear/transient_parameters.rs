//! Parameters of steps in time.

use rheology::ViscosityLaw;

use super::orders::GROWTH;

/// Terms of the momentum equation of the fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Convection {
    /// `ρ ∂u/∂t` at points that move with the mesh, no convection: unsteady Stokes flow.
    Neglected,
    /// `ρ (∂u/∂t + (u - w) · ∇u)` with the velocity `w` of the mesh: the Navier-Stokes equations.
    #[default]
    Full,
}

/// Parameters of steps in time.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct TransientParameters<'a> {
    /// Density of the fluid.
    pub density: f64,
    /// Law of the viscosity; without one the viscosity is 1.
    pub law: Option<&'a dyn ViscosityLaw>,
    /// Terms of the momentum equation.
    pub convection: Convection,
    /// Whether displacements are small: then neither bodies nor mesh move, whatever their
    /// velocities.
    pub frozen: bool,
    /// Polynomial degree of the velocities.
    pub order: usize,
    /// Edge length relative to the distance from the focus of the nearest body.
    pub growth: f64,
    /// Relative change of the velocity, and displacement in body sizes, at which the iteration for
    /// a step ends.
    pub tolerance: f64,
}

impl<'a> TransientParameters<'a> {
    /// The Navier-Stokes equations with this density and viscosity 1, on a mesh that follows the
    /// bodies.
    pub fn new(density: f64) -> Self {
        Self {
            density,
            law: None,
            convection: Convection::Full,
            frozen: false,
            // steady flows up to a Reynolds number of 5 have errors of about 1e-6
            order: 6,
            growth: GROWTH,
            tolerance: 1e-9,
        }
    }

    /// The same with a viscosity that depends on the shear rate.
    #[must_use]
    pub fn with_law(self, law: &'a dyn ViscosityLaw) -> Self {
        Self {
            law: Some(law),
            ..self
        }
    }

    /// The same with other terms.
    #[must_use]
    pub fn with_convection(self, convection: Convection) -> Self {
        Self { convection, ..self }
    }

    /// The same for small displacements.
    #[must_use]
    pub fn with_frozen_mesh(self) -> Self {
        Self {
            frozen: true,
            ..self
        }
    }

    /// The same with elements of another order.
    #[must_use]
    pub fn with_order(self, order: usize) -> Self {
        Self { order, ..self }
    }

    /// The same with a mesh that is graded otherwise.
    #[must_use]
    pub fn with_growth(self, growth: f64) -> Self {
        Self { growth, ..self }
    }

    /// The same with another tolerance of the iteration.
    #[must_use]
    pub fn with_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }
}
