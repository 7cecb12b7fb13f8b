//! Checkpoints.

use swimmer::Checkpoint;
use swimmer::output::sealed;

/// Reads a checkpoint as it is, and with a checksum that belongs to it: otherwise the checksum
/// would keep the fuzzer from everything behind it.
pub fn read(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    drop(Checkpoint::parse(text, "fuzzed"));
    if let Ok(value) = serde_json::from_str::<serde_json::Value>(text)
        && let Ok(text) = sealed(&value)
        && let Ok(checkpoint) = Checkpoint::parse(&text, "fuzzed")
    {
        drop(checkpoint.into_outcome("fuzzed"));
    }
}
