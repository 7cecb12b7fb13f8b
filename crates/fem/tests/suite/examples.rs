//! Every example runs as a test.

#[path = "../../examples/manufactured_stokes.rs"]
mod manufactured_stokes;

#[test]
fn manufactured_stokes_runs() {
    manufactured_stokes::main().unwrap();
}
