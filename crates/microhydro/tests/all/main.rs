//! Tests of the public interface, in one binary.

mod contract;
mod exact;
mod examples;
mod hostile;
mod properties;
mod squirmers;
mod stresslets;
mod velocity_field;
