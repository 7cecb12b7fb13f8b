//! The examples run and find the numbers that they assert.

#[path = "../../examples/read_gmsh.rs"]
mod read_gmsh;
#[path = "../../examples/write_vtu.rs"]
mod write_vtu;

#[test]
fn read_gmsh_runs() {
    read_gmsh::main().unwrap();
}

#[test]
fn write_vtu_runs() {
    write_vtu::main().unwrap();
}
