//! Every example runs and ends with its assertions.

#[path = "../../examples/falling_sphere.rs"]
mod falling_sphere;

#[test]
fn falling_sphere_runs() {
    falling_sphere::main().unwrap();
}
