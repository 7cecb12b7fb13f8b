//! The examples run to their last assertion.

#[path = "../../examples/key_table.rs"]
mod key_table;

#[test]
fn key_table_runs() {
    key_table::main();
}
