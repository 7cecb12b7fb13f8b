//! Runs the examples, which end with assertions.

#[path = "../../examples/move_mesh.rs"]
mod move_mesh;

#[test]
fn mesh_stays_valid_while_a_sphere_moves() -> Result<(), Box<dyn std::error::Error>> {
    move_mesh::main()
}
