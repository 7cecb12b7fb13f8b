//! Results as files: `summary.json`, `trajectory.csv`, `trajectory.svg`, ParaView files.

mod folder;
mod memory;
mod paraview;
#[cfg(feature = "plots")]
mod plot;
mod report;
mod trajectory;

pub use folder::Folder;
pub use memory::peak_rss_mib;
pub use paraview::{FlowSeries, write_flow};
#[cfg(feature = "plots")]
pub use plot::{height_map_svg, learning_curve_svg, policy_svg, trajectory_svg};
pub use report::{matrix_json, solution_json, summary_json};
pub use trajectory::trajectory_csv;
