//! What the tests of several crates share.
//!
//! A test is then what it checks: scenes come from [`SceneText`], exact values with their accuracy
//! and source from [`exact`], models that are observed or disturbed from [`Recording`], and every
//! comparison with a bound says by [`within`] why it has that bound. Errors are panics with all
//! that is known, since nothing here runs outside of tests.

#![forbid(unsafe_code)]

mod bounds;
pub mod exact;
mod recording;
mod runs;
mod scenes;

pub use bounds::{contains, within};
pub use recording::Recording;
pub use runs::{
    at, boxed, forces, interrupted, resumed_after_one_phase, run, run_by, solve_at, start,
    start_by, start_resistance,
};
pub use scenes::{STROKE, SceneText, chain, pair, planar, three_spheres};
