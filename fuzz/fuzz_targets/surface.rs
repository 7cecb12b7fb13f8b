//! Any bytes are a surface in each format or refused, and so is the closed surface they describe.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| fuzz::surface::read(bytes));
