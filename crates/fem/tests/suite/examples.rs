//! Every example runs as a test and checks its orders.

// Each example is a program of its own, with its copy of `orders`.
#![allow(clippy::duplicate_mod)]

#[path = "../../examples/convection_diffusion.rs"]
mod convection_diffusion;
#[path = "../../examples/elasticity.rs"]
mod elasticity;
#[path = "../../examples/heat.rs"]
mod heat;
#[path = "../../examples/manufactured_stokes.rs"]
mod manufactured_stokes;
#[path = "../../examples/picard_step.rs"]
mod picard_step;

#[test]
fn convection_diffusion_runs() {
    convection_diffusion::main().unwrap();
}

#[test]
fn elasticity_runs() {
    elasticity::main().unwrap();
}

#[test]
fn heat_runs() {
    heat::main().unwrap();
}

#[test]
fn manufactured_stokes_runs() {
    manufactured_stokes::main().unwrap();
}

#[test]
fn picard_step_runs() {
    picard_step::main().unwrap();
}
