#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod best_frequency;
pub mod checkpoint;
mod connection;
pub mod design;
mod error;
pub mod flow_slice;
mod gauss;
mod integrate;
mod joint_ranges;
mod observer;
mod outcome;
pub mod output;
mod periodic;
mod planning;
mod progress;
mod run;
mod run_files;
pub mod sensitivities;
mod simulate;
mod start;
mod templates;

pub use best_frequency::{BestFrequency, FrequencyRun, best_frequency};
pub use checkpoint::Checkpoint;
pub use connection::{Connection, connection};
pub use error::SwimError;
pub use integrate::{
    Integrator, Method, PathPiece, SpanResult, SpanSolution, TYPICAL_SOLVES_PER_SPAN,
};
pub use models;
pub use observer::Observer;
pub use outcome::{Interim, Outcome, Sample, SpanOutcome};
pub use output::Folder;
pub use periodic::{periodic_state, start_of_gait};
pub use planning::{Choice, MissedTarget, SizeSearch, choose, simulate_to_target, with_tables};
pub use progress::Progress;
pub use run::{ModelOfScene, Report, run, run_with, run_without_files};
pub use scene::{self, Gait, Phase, PhaseSpan, Scene, SceneError, spans};
pub use simulate::{continue_from, simulate};
pub use start::{
    solve_start, start_flow, start_flow_at, start_resistance, start_resistance_errors, start_slice,
};
pub use templates::TEMPLATES;
