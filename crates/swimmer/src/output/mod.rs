//! What a simulation leaves behind: `summary.json`, `trajectory.csv`, `trajectory.svg`, ParaView files.

mod folder;
mod paraview;
mod picture;
mod report;
mod snapshots;
mod trajectory;

pub use folder::Folder;
pub use paraview::{FlowSeries, write_flow};
pub use picture::trajectory_svg;
pub use report::{matrix_json, peak_rss_mib, solution_json, summary_json};
pub use trajectory::trajectory_csv;
