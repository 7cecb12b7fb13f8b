//! The examples run and find the numbers that they assert.

#[path = "../../examples/bent_channel.rs"]
mod bent_channel;
#[path = "../../examples/generate.rs"]
mod generate;

#[test]
fn bent_channel_runs() {
    bent_channel::main().unwrap();
}

#[test]
fn generate_runs() {
    generate::main().unwrap();
}
