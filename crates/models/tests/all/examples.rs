//! Every example runs and ends with its assertions.

#[path = "../../examples/own_model.rs"]
mod own_model;

#[test]
fn own_model_runs() {
    own_model::main().unwrap();
}
