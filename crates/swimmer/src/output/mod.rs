//! Results as files: `summary.json`, `trajectory.csv`, `trajectory.svg`, `report.html`, ParaView
//! files.

mod flow_slices;
mod folder;
mod machine;
mod memory;
pub mod numbers;
mod packed;
mod paraview;
#[cfg(feature = "plots")]
mod plot;
mod report;
#[cfg(feature = "plots")]
mod report_page;
mod trajectory;

pub(crate) use flow_slices::{SliceSeries, StoredSlices};
pub use folder::Folder;
pub use machine::processor;
pub use memory::peak_rss_mib;
pub use paraview::{FlowSeries, write_flow};
#[cfg(feature = "plots")]
pub use plot::{
    flow_svg, height_map_svg, learning_curve_svg, policy_svg, size_slices_svg, trajectory_svg,
};
pub use report::{matrix_json, solution_json, summary_json};
#[cfg(feature = "plots")]
pub use report_page::{REPORT_PAGE, RunRecord};
pub use trajectory::trajectory_csv;
