//! The examples run and find their known numbers.

#[path = "../../examples/gait_search.rs"]
mod gait_search;
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
