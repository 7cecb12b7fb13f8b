//! Matrices of the finite-element space as input of the crate `rigid`.

use fem::StokesMatrices;
use rigid::FluidMatrices;

/// Matrices of Stokes flow in the form that [`rigid::RigidFluid::new`] takes.
///
/// The crates `fem` and `rigid` do not depend on each other; their fields correspond one to one.
pub fn fluid_matrices(matrices: StokesMatrices) -> FluidMatrices {
    let StokesMatrices {
        stiffness,
        divergence,
        pressure_mass,
        interpolation,
        vertex_stiffness,
    } = matrices;
    FluidMatrices {
        stiffness,
        divergence,
        pressure_mass,
        interpolation,
        vertex_stiffness,
    }
}
