//! Runs the examples, which end with assertions.

#[path = "../../examples/poisson.rs"]
mod poisson;
#[path = "../../examples/saddle_point.rs"]
mod saddle_point;

#[test]
fn poisson_runs() {
    poisson::main().expect("the example runs");
}

#[test]
fn saddle_point_runs() {
    saddle_point::main().expect("the example runs");
}
