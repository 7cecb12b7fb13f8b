//! Every example runs and ends with its assertions.

#[path = "../../examples/chain_swimmer.rs"]
mod chain_swimmer;
#[path = "../../examples/two_bodies.rs"]
mod two_bodies;

#[test]
fn two_bodies_runs() {
    two_bodies::main().unwrap();
}

#[test]
fn chain_swimmer_runs() {
    chain_swimmer::main().unwrap();
}
