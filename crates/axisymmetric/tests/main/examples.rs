//! Runs the examples, which end with assertions on known numbers.

#[path = "../../examples/spheroid_drag.rs"]
mod spheroid_drag;
#[path = "../../examples/squirmers.rs"]
mod squirmers;
#[path = "../../examples/two_spheres.rs"]
mod two_spheres;

use axisymmetric::AxisymmetricError;

#[test]
fn drag_of_spheroids_matches_oberbeck() -> Result<(), AxisymmetricError> {
    spheroid_drag::main()
}

#[test]
fn drag_of_two_spheres_matches_stimson_and_jeffery() -> Result<(), AxisymmetricError> {
    two_spheres::main()
}

#[test]
fn speeds_of_squirmers_with_inertia_match_a_spectral_program() -> Result<(), AxisymmetricError> {
    squirmers::main()
}
