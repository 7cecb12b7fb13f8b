//! Physical properties and exact values: what the models compute, independent of the integration.
//!
//! Properties that the discretisation preserves are tested to the error of the solver, other
//! properties to the order of the discretisation.

mod axisymmetric;
mod balance;
mod breathing_masses;
mod cylinder;
mod deformation_properties;
mod deforming;
mod deforming_laws;
mod dragged;
mod equivalence;
mod error_bars;
mod far_field;
mod fem_strokes;
mod flows;
mod formulations;
mod frames;
mod harmonics;
mod joints;
mod mesh_files;
mod mobility;
mod model_choice;
mod reproducible;
mod scenes;
mod several_rates;
mod shape_space;
mod shapes;
mod sphere_instants;
mod sphere_strokes;
mod surface_frames;
mod surroundings;
mod symmetry_planes;
mod target;
mod undulating;
