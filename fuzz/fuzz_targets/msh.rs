//! Any bytes are a Gmsh file or refused, and so is the mesh they describe.
#![no_main]

use libfuzzer_sys::fuzz_target;
use mesh::MshFile;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(file) = MshFile::parse("fuzzed.msh", bytes) {
        drop(file.into_mesh(&[]));
    }
});
