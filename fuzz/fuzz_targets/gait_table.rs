//! Any bytes are a table of a gait or refused.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| fuzz::gait_table::read(bytes));
