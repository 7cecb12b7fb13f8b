//! Tests of the public interface, in one binary.

mod exact;
mod examples;
mod properties;
mod velocity_field;
