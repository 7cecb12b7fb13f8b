//! Stokes flow around rigid spheres without a mesh.
//!
//! Three models of the same question, how forces on spheres follow from their motion: point forces ([`oseen`]), Rotne-Prager-Yamakawa
//! ([`rpy`]), and multipole expansions to any accuracy with an error estimate ([`multipole`]); in unbounded fluid, in a
//! spherical container, beside a plane wall ([`Medium`]). Viscosity is 1: multiply resistances, divide mobilities by it. Forces are those
//! that spheres exert on the fluid.
//!
//! ```
//! use microhydro::{Accuracy, Medium, Spheres, multipole};
//! use nalgebra::{DVector, Vector3};
//!
//! // Two equal spheres that follow each other, three radii apart from centre to centre.
//! let pair = Spheres::new(vec![Vector3::zeros(), Vector3::new(3.0, 0.0, 0.0)], vec![1.0; 2])?;
//! let resistance = multipole::resistance(&pair, &Medium::Unbounded, &Accuracy::relative(1e-10))?;
//!
//! let mut velocities = DVector::zeros(12); // (U, omega) of each sphere
//! (velocities[0], velocities[6]) = (1.0, 1.0);
//! let drag = resistance.forces(&velocities)[0] / (6.0 * std::f64::consts::PI);
//! assert!((drag - 0.6983045602500371).abs() < 1e-10); // Stimson & Jeffery (1926)
//! assert!(resistance.relative_error() < 1e-10);
//! # Ok::<(), microhydro::HydroError>(())
//! ```
#![forbid(unsafe_code)]

mod error;
mod inverse;
pub mod multipole;
pub mod oseen;
mod point;
mod resistance;
pub mod rpy;
mod spheres;
pub mod wall;

pub use error::HydroError;
pub use multipole::Accuracy;
pub use resistance::Resistance;
pub use spheres::{Medium, Spheres};
