//! Any text is a checkpoint or refused, also one that has a checksum of its own.
#![no_main]

use libfuzzer_sys::fuzz_target;
use swimmer::Checkpoint;
use swimmer::output::sealed;

fuzz_target!(|text: &str| {
    drop(Checkpoint::parse(text, "fuzzed"));
    // The checksum would keep the fuzzer from everything behind it.
    if let Ok(value) = serde_json::from_str::<serde_json::Value>(text)
        && let Ok(text) = sealed(&value)
        && let Ok(checkpoint) = Checkpoint::parse(&text, "fuzzed")
    {
        drop(checkpoint.into_outcome("fuzzed"));
    }
});
