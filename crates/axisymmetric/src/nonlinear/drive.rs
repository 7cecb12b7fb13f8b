//! What drives a steady flow, and how it is computed.

use rheology::ViscosityLaw;

use super::orders::GROWTH;

/// The velocity of a surface relative to its body, along the axis and away from it, at a point
/// relative to the centre of the body.
pub type Slip<'a> = &'a (dyn Fn(usize, [f64; 2]) -> [f64; 2] + Sync);

/// What drives a steady flow.
#[derive(Clone, Copy, Default)]
pub struct SteadyDrive<'a> {
    /// Velocity of each body along the axis: of a prescribed body in the laboratory, of a free one
    /// relative to its swimmer. Empty if all are zero.
    pub velocities: &'a [f64],
    /// External force along the axis on each body. Empty if all are zero.
    pub loads: &'a [f64],
    /// Slip of the surfaces.
    pub slip: Option<Slip<'a>>,
    /// Velocity of the wall along the axis, in the laboratory.
    pub wall_velocity: f64,
    /// Whether the fluid domain moves with the first body, walls included.
    ///
    /// The flow is then steady in its frame: fluid enters and leaves through the boundary of the
    /// domain, at the velocity that the walls have in the laboratory.
    pub moves_with_body: bool,
}

/// Parameters of a steady state.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct SteadyParameters<'a> {
    /// Density of the fluid.
    pub density: f64,
    /// Law of the viscosity; without one the viscosity is 1.
    pub law: Option<&'a dyn ViscosityLaw>,
    /// Largest estimated error of velocities and forces, relative to the largest ones.
    pub tolerance: f64,
    /// Estimated error at which the result of the highest order is accepted where none meets the
    /// tolerance; zero for none.
    pub accepted: f64,
    /// Edge length relative to the distance from the focus of the nearest body.
    ///
    /// Boundary layers at walls need a small one, as the mesh is graded for bodies.
    pub growth: f64,
}

impl<'a> SteadyParameters<'a> {
    /// The Navier-Stokes equations with this density and viscosity 1, to 1e-6.
    pub fn new(density: f64) -> Self {
        Self {
            density,
            law: None,
            tolerance: 1e-6,
            accepted: 0.0,
            growth: GROWTH,
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

    /// The same with another tolerance.
    #[must_use]
    pub fn with_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }

    /// The same where the highest order needs to reach this error only.
    #[must_use]
    pub fn with_accepted(self, accepted: f64) -> Self {
        Self { accepted, ..self }
    }

    /// The same with a mesh that is graded otherwise.
    #[must_use]
    pub fn with_growth(self, growth: f64) -> Self {
        Self { growth, ..self }
    }
}
