//! The tests of this crate in one binary.

mod bars;
mod examples;
mod flows;
mod history;
mod many_swimmers;
mod mesh_files;
mod neglected_terms;
mod periodic;
mod query;
mod remeshed_files;
mod scenes;
mod stresslets;
mod superposition;
mod surface_files;
mod table_errors;
mod tables;
mod tabulated;
mod thermal_noise;
mod thinning;
mod units;
mod viscosity_laws;
