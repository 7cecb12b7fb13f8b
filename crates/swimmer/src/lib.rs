#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod added_mass;
pub mod checkpoint;
mod decision;
mod efficiency;
mod error;
mod gauss;
mod holding_loads;
mod inertia_numbers;
mod integrate;
mod kinetic_energy;
mod linkage_works;
mod mean_flow;
mod moment;
mod motion;
mod neglected;
mod noise_numbers;
mod observer;
mod outcome;
pub mod output;
mod periodic;
mod periodic_flow;
mod planning;
mod run;
mod run_files;
mod run_report;
mod simulate;
mod start;
mod steady;
mod swimmers;
mod templates;
mod threads;
mod turning;

pub use added_mass::AddedMassForces;
pub use checkpoint::Checkpoint;
pub use decision::{StartSolution, solve_start_with_terms};
pub use efficiency::Efficiency;
pub use error::SwimError;
pub use gauss::{Gauss, lagrange};
pub use holding_loads::HoldingLoads;
pub use inertia_numbers::InertiaNumbers;
pub use integrate::{
    Integrator, Method, ObserveSolution, PathPiece, SpanResult, SpanSolution,
    TYPICAL_SOLVES_PER_SPAN, UnsteadyScene, UnsteadyState,
};
pub use kinetic_energy::KineticEnergy;
pub use linkage_works::LinkageWork;
pub use mean_flow::MeanFlowInTime;
pub use models;
pub use moment::{Moment, check_model};
pub use motion::Motion;
pub use neglected::{
    Neglected, NeglectedEffect, fastest_body, mean_effect, resolved_net, start_neglected,
};
pub use noise_numbers::NoiseNumbers;
pub use observer::{MissedTarget, Observer, Progress};
pub use outcome::{
    Interim, Outcome, PeriodicStart, Sample, ShapeChange, SpanOutcome, mean_of_moving, positions,
};
pub use output::Folder;
pub use periodic::{periodic_state, start_of_gait};
pub use planning::{
    Choice, ModelOfScene, SizeSearch, choose, choose_for_run, choose_for_start, simulate_to_target,
    with_tables,
};
pub use run::{run, run_with, run_without_files};
pub use run_files::RunFiles;
pub use run_report::Report;
pub use scene::{self, Gait, Phase, PhaseSpan, Scene, SceneError, spans};
pub use simulate::{continue_from, simulate};
pub use start::{
    solve_start, start_flow, start_flow_at, start_resistance, start_resistance_errors,
};
pub use steady::{SteadySolution, solve_steady};
pub use swimmers::SwimmerOutcome;
pub use templates::TEMPLATES;
pub use threads::check_threads;
pub use turning::Turning;
