//! Integration of gaits, checkpoints, error codes and examples.

mod accumulated;
mod bad_checkpoints;
mod bookkeeping;
mod contacts;
mod corrections;
mod driven;
#[path = "../../../scene/tests/all/edits.rs"]
mod edits;
mod efficiency;
mod euler_bars;
mod examples;
mod exit_codes;
mod extreme_numbers;
mod fuzz;
mod harmonic;
mod hostile;
mod inertia;
mod inertia_bars;
mod integrators;
mod joints;
mod loops;
mod many_cycles;
mod neglected_terms;
mod paths;
mod periodic;
mod periodic_flow;
mod reports;
mod resumed_fluid;
mod strokes;
mod support;
mod swimmers;
mod thermal_noise;
mod tolerances;
mod trajectories;
mod unsteady;
