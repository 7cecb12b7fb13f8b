//! The `swim` command.
fn main() {}
