//! One bilinear form a file.

mod divergence;
mod mass;
mod stiffness;
mod vertex_elasticity;
mod vertex_stiffness;
mod viscous;
