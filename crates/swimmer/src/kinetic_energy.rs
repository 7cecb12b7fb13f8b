//! Kinetic energy of a fluid with inertia and of the bodies in it.

use serde::{Deserialize, Serialize};

/// Kinetic energy of fluid and bodies at one time, in the units of the scene.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[non_exhaustive]
pub struct KineticEnergy {
    /// That of the fluid, `ρ/2 ∫ |u|²`, without its estimated error by the mesh.
    pub fluid: f64,
    /// That of the bodies, `sum_b (m U² + ω · I ω) / 2`, likewise.
    pub bodies: f64,
    /// Uncertainty of each by the mesh, in space without the errors of steps; none where it is not
    /// estimated.
    pub mesh_error: Option<[f64; 2]>,
}

impl KineticEnergy {
    /// That of fluid and bodies together.
    pub fn total(&self) -> f64 {
        self.fluid + self.bodies
    }

    /// Energies without an estimate of their errors.
    pub(crate) fn new([fluid, bodies]: [f64; 2]) -> Self {
        Self {
            fluid,
            bodies,
            mesh_error: None,
        }
    }

    /// These energies minus their errors, `share` of the differences of those on a coarser mesh to
    /// them, with an uncertainty relative to that.
    pub(crate) fn corrected(&self, differences: [f64; 2], share: f64, uncertainty: f64) -> Self {
        let [fluid, bodies] = differences.map(|difference| share * difference);
        Self {
            // No energy is negative, whatever its error.
            fluid: (self.fluid - fluid).max(0.0),
            bodies: (self.bodies - bodies).max(0.0),
            mesh_error: Some([fluid, bodies].map(|error| uncertainty * error.abs())),
        }
    }
}
