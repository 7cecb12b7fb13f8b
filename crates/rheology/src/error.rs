//! Errors of the crate.

/// Parameters that are no law of a fluid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RheologyError {
    /// A parameter outside its range.
    #[error("{parameter} is {value}; it must be {range}")]
    Parameter {
        /// Name of the parameter, as the field of [`Law`](crate::Law).
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// The values that it may have.
        range: &'static str,
    },
    /// Stress that does not increase with the shear rate.
    #[error(
        "the shear stress of the fluid does not increase with the shear rate at {shear_rate:e}; \
         increase infinite_shear_viscosity or index"
    )]
    StressDecreases {
        /// Shear rate at which the derivative of the stress is not positive.
        shear_rate: f64,
    },
}
