//! Every example runs and ends with its assertions.

#[path = "../../examples/falling_sphere.rs"]
mod falling_sphere;
#[path = "../../examples/one_step.rs"]
mod one_step;

#[test]
fn falling_sphere_runs() {
    falling_sphere::main().unwrap();
}

#[test]
fn one_step_runs() {
    one_step::main().unwrap();
}
