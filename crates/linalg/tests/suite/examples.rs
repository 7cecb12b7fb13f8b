//! Runs the examples, which end with assertions.

#[path = "../../examples/poisson.rs"]
mod poisson;
#[path = "../../examples/rotating_wind.rs"]
mod rotating_wind;
#[path = "../../examples/saddle_point.rs"]
mod saddle_point;
#[path = "../../examples/staggered_stokes.rs"]
mod staggered_stokes;

#[test]
fn rotating_wind_runs() {
    rotating_wind::main().expect("the example runs");
}

#[test]
fn staggered_stokes_runs() {
    staggered_stokes::main().expect("the example runs");
}

#[test]
fn poisson_runs() {
    poisson::main().expect("the example runs");
}

#[test]
fn saddle_point_runs() {
    saddle_point::main().expect("the example runs");
}
