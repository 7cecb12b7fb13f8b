//! Results as files: `summary.json`, `swimmers.csv`, `trajectory.csv`, ParaView files.

mod folder;
mod paraview;
mod report;
mod sealed;
mod swimmers;
mod trajectory;

pub use folder::{Folder, FolderLock};
pub use paraview::{FlowSeries, write_flow};
pub use report::{ALL_ERRORS, matrix_json, peak_rss_mib, processor, solution_json, summary_json};
pub use sealed::{from_sealed, read_own, read_sealed, sealed, write_sealed};
pub use swimmers::swimmers_csv;
pub use trajectory::{trajectory_csv, trajectory_npy};
