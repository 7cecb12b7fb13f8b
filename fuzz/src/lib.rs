//! What the fuzz targets do with their bytes. Tests of the workspace include these files and replay
//! the corpus with them.
#![forbid(unsafe_code)]

pub mod checkpoint;
pub mod gait_table;
pub mod msh;
pub mod own_files;
pub mod scene;
pub mod surface;
