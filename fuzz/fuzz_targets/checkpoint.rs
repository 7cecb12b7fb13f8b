//! Any text is a checkpoint or refused.
#![no_main]

use libfuzzer_sys::fuzz_target;
use swimmer::Checkpoint;

fuzz_target!(|text: &str| drop(Checkpoint::parse(text, "fuzzed".as_ref())));
