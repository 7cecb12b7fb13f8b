#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod error;
mod law;
mod potential;

pub use error::RheologyError;
pub use law::Law;

use std::fmt::Debug;

/// Viscosity `eta` of a generalised Newtonian fluid as a function of the shear rate `g = sqrt(2
/// D:D)`.
///
/// The stress of shear, `eta(g) g`, must increase with `g` for all `g > 0`: the potential is then
/// convex, and the flow exists and is unique (Baranger & Najib 1990). A law that decreases
/// somewhere has no unique flow, and solvers stop with an error.
///
/// ```
/// use rheology::ViscosityLaw;
///
/// /// Ellis fluid with exponent 2 at small rates: `eta = 1 / (1 + g / 4)`.
/// #[derive(Debug)]
/// struct Soft;
///
/// impl ViscosityLaw for Soft {
///     fn viscosity(&self, shear_rate: f64) -> f64 {
///         1.0 / (1.0 + shear_rate / 4.0)
///     }
///     fn derivative(&self, shear_rate: f64) -> f64 {
///         -0.25 / (1.0 + shear_rate / 4.0).powi(2)
///     }
///     fn potential(&self, shear_rate: f64) -> f64 {
///         // integral of s / (1 + s / 4)
///         4.0 * shear_rate - 16.0 * (shear_rate / 4.0).ln_1p()
///     }
/// }
/// assert!((Soft.tangent_viscosity(1.0) - 0.8 * 0.8).abs() < 1e-15);
/// ```
pub trait ViscosityLaw: Debug + Send + Sync {
    /// Viscosity `eta(g) > 0` at the shear rate `g >= 0`.
    fn viscosity(&self, shear_rate: f64) -> f64;

    /// Derivative `d eta / d g` at the shear rate `g > 0`.
    fn derivative(&self, shear_rate: f64) -> f64;

    /// Potential `W(g)`, the integral of `eta(s) s` over `s` from 0 to `g`.
    ///
    /// Its gradient with respect to `D` is the stress `2 eta D`; it is power per volume.
    fn potential(&self, shear_rate: f64) -> f64;

    /// Viscosity without regularisation, by default [`Self::viscosity`]; at rest its limit, which
    /// may be infinite or zero.
    fn unregularised_viscosity(&self, shear_rate: f64) -> f64 {
        self.viscosity(shear_rate)
    }

    /// Derivative of the stress of shear, `d (eta g) / d g = eta + g eta'`.
    ///
    /// It is the viscosity that a small change of the flow in the direction of `D` meets.
    fn tangent_viscosity(&self, shear_rate: f64) -> f64 {
        let viscosity = self.viscosity(shear_rate);
        if shear_rate > 0.0 {
            viscosity + shear_rate * self.derivative(shear_rate)
        } else {
            viscosity
        }
    }
}
