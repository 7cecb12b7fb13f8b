//! Bilinear and linear forms, one per file.

mod divergence;
mod load_vector;
mod mass;
mod stiffness;
mod vertex_elasticity;
mod vertex_stiffness;
mod viscous;

pub use load_vector::load_vector;
