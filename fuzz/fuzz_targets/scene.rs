//! Any text is a scene or refused; what is a scene can be written and read again.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| fuzz::scene::read(bytes));
