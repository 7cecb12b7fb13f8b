//! Runs the examples; each asserts a known number.

#[path = "../../examples/mobility_of_three_spheres.rs"]
mod mobility_of_three_spheres;

#[test]
fn mobility_of_three_spheres() {
    mobility_of_three_spheres::main().unwrap();
}
