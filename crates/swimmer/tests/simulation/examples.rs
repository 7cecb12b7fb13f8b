//! The examples run and find their known numbers.

#[path = "../../examples/gait_search.rs"]
mod gait_search;
#[path = "../../examples/own_deformation.rs"]
mod own_deformation;
#[path = "../../examples/stroke.rs"]
mod stroke;

#[test]
fn stroke() {
    stroke::main().unwrap();
}

#[test]
fn gait_search() {
    gait_search::main().unwrap();
}

#[test]
#[ignore = "slow: 60 s"]
fn own_deformation() {
    own_deformation::main().unwrap();
}
