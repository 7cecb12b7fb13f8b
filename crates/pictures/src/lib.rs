#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod error;
pub mod flow_slice;
mod flow_slices;
pub mod numbers;
mod packed;
mod plot;
mod report_page;
mod run_pictures;

pub use error::PictureError;
pub use flow_slice::start_slice;
pub use plot::{
    Policy, SliceCurve, SweptPoints, direction_name, flow_svg, height_map_svg, learning_curve_svg,
    policy_svg, size_slices_svg, sweep_svg, trajectory_svg,
};
pub use report_page::{REPORT_PAGE, RunRecord};
pub use run_pictures::RunPictures;

/// Scenes, models and runs, whose types are part of the interface.
pub use swimmer;
