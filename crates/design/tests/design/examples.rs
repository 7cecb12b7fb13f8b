//! The examples run.

#[path = "../../examples/frequency_of_an_elastic_arm.rs"]
mod frequency_of_an_elastic_arm;

#[test]
fn the_best_frequency_of_an_elastic_arm() {
    frequency_of_an_elastic_arm::main().unwrap();
}
