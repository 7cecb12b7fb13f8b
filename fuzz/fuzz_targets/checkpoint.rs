//! Any text is a checkpoint or refused, also one that has a checksum of its own.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| fuzz::checkpoint::read(bytes));
