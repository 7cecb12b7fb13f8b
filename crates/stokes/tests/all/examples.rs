//! Every example runs and ends with its assertions.

#[path = "../../examples/drag.rs"]
mod drag;

#[test]
fn drag_runs() {
    drag::main().unwrap();
}
