//! Any bytes are a Gmsh file or refused, and so is the mesh they describe.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| fuzz::msh::read(bytes));
