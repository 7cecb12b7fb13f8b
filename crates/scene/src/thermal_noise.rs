//! Thermal noise: the random forces of a fluid at a temperature.

/// Thermal noise of the fluid, by which bodies diffuse.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ThermalNoise {
    /// `k_B T`, in the scene's units of force times length.
    pub energy: f64,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Largest length of the steps in time; `None` if it follows from the scene.
    pub time_step: Option<f64>,
}
