#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod axial_shape;
mod canonical;
mod collar;
mod curve;
mod deformed_sphere;
mod deforming;
mod delaunay;
mod element;
mod error;
mod flow;
mod forms;
mod generate;
mod geometry_map;
mod meridian;
mod mesh;
mod nonlinear;
mod open_boundary;
mod quadrature;
mod resistance;
mod solver;
mod space;
mod spheroid;
mod stokes;
mod surface_modes;
mod swirl;
mod system;

pub use deformed_sphere::{DeformedSphere, RADIAL_DEGREES};
pub use deforming::{DeformationRates, deforming_resistance};
pub use error::AxisymmetricError;
pub use flow::{BodyVelocity, MeridianFlow, MeridianValue};
pub use meridian::{MAX_ASPECT, Surroundings};
pub use nonlinear::{
    AddedMass, AxialBody, AxialChange, AxialForceSolver, AxialForces, AxialForcing,
    AxialIntegrator, AxialMotion, AxialState, AxialStep, Convection, Impedance,
    ImpedanceParameters, LawChange, REGULARISATION_FACTOR, Slip, SteadyDrive, SteadyParameters,
    SteadyState, TransientParameters, added_mass, impedance, law_change, steady_state,
};
pub use resistance::{AxialResistance, SurfaceResistance};
pub use solver::{ResistanceSolver, axial_resistance, spin_resistance};
pub use spheroid::AxialSpheroid;
pub use surface_modes::SurfaceMode;

pub use {nalgebra, rheology};
