//! The examples run to their last assertion.

#[path = "../../examples/build_a_scene.rs"]
mod build_a_scene;
#[path = "../../examples/key_table.rs"]
mod key_table;

#[test]
fn build_a_scene_runs() {
    build_a_scene::main().unwrap();
}

#[test]
fn key_table_runs() {
    key_table::main();
}
