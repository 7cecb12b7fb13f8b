//! Results as files: `summary.json`, `trajectory.csv`, ParaView files.

mod folder;
mod machine;
mod memory;
mod paraview;
mod report;
mod trajectory;

pub use folder::Folder;
pub use machine::processor;
pub use memory::peak_rss_mib;
pub use paraview::{FlowSeries, write_flow};
pub use report::{matrix_json, solution_json, summary_json};
pub use trajectory::trajectory_csv;
