//! Errors of setting up and solving a Stokes problem.

/// A Stokes problem that cannot be set up or solved.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StokesError {
    /// A boundary part that the mesh does not have, or an unusable mesh.
    #[error(transparent)]
    Mesh(#[from] mesh::MeshError),
    /// A part of the boundary that is given twice.
    #[error("the boundary part '{name}' is given twice; it is one body or one wall")]
    PartTwice {
        /// Name of the part.
        name: String,
    },
    /// A failed assembly.
    #[error(transparent)]
    Fem(#[from] fem::FemError),
    /// Contradictory constraints, or a flow that is not unique.
    #[error(transparent)]
    Rigid(#[from] rigid::RigidError),
    /// A failed linear solve.
    #[error(transparent)]
    Linalg(#[from] linalg::LinalgError),
    /// A failure of an [`Engine`](crate::Engine).
    #[error(transparent)]
    Engine(Box<dyn std::error::Error + Send + Sync>),
    /// A law whose viscosity is not positive.
    #[error("the viscosity of the fluid is {viscosity} at the shear rate 1; it must be positive")]
    Viscosity {
        /// The viscosity.
        viscosity: f64,
    },
    /// A flow so slow that the viscosity of its fluid is many times the unit of viscosity.
    #[error(
        "the largest viscosity of this flow is about {viscosity:.0e} times that at the shear rate 1, \
         too much for double precision: the fluid hardly moves; give times in a unit near that of the \
         motion, loads above a yield stress, or a larger regularisation"
    )]
    SlowFlow {
        /// The viscosity, as an order of magnitude.
        viscosity: f64,
    },
    /// Newton's method did not converge.
    #[error(
        "the flow of the generalised Newtonian fluid did not converge in {steps} Newton steps: \
         residual {residual:.1e}, required {target:.1e}; {}",
        remedy()
    )]
    NewtonNotConverged {
        /// Number of steps.
        steps: usize,
        /// Relative residual that was reached.
        residual: f64,
        /// Relative residual that was required.
        target: f64,
    },
    /// No step along the direction of Newton's method decreases the energy of the flow.
    #[error(
        "no Newton step decreases the energy of the generalised Newtonian fluid any more after \
         {steps} steps: residual {residual:.1e}, required {target:.1e}; {}",
        remedy()
    )]
    EnergyNotDecreasing {
        /// Number of steps.
        steps: usize,
        /// Relative residual that was reached.
        residual: f64,
        /// Relative residual that was required.
        target: f64,
    },
    /// A linear system for a viscosity law.
    #[error(
        "a step of a fluid with a viscosity law is no linear system; use Problem::solve_inertial"
    )]
    NotLinear,
    /// An engine outside this crate, which solves Stokes flow only.
    #[error(
        "an engine outside the crate solves Newtonian fluids only; use the solver of the crate"
    )]
    EngineOfNewtonianFluids,
    /// A boundary velocity with a net flux through the boundary of an enclosed domain.
    #[error(
        "the prescribed velocity has the net flux {flux:.3e} out of the domain ({:.1} % of the \
         sum of absolute fluxes); prescribe a velocity without net flux", 100.0 * relative
    )]
    NetFlux {
        /// Net flux out of the domain.
        flux: f64,
        /// The same divided by the sum of the absolute fluxes at the vertices.
        relative: f64,
    },
}

/// What to do if Newton's method fails.
fn remedy() -> &'static str {
    "the stress must increase with the shear rate; increase the regularisation, the infinite-shear \
     viscosity or the index of the fluid, or relax the tolerance of the solver"
}
