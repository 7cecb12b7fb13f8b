//! The flow in a plane: values on a regular grid, outlines of bodies, streamlines.

mod body_surface;
mod grid;
mod plane;
mod section;
mod streamlines;
mod walls;

pub use body_surface::body_surface;
pub use grid::{FlowSlice, start_slice};
pub use plane::{SliceFrame, SlicePlane};
pub use section::section;
pub use streamlines::{Streamline, streamlines};
pub use walls::{is_beyond_wall, is_inside, wall_lines, walls_of_file};
