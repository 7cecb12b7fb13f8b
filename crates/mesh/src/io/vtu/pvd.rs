//! PVD files: the VTU files of a time series.

use std::path::Path;

use super::super::atomic_file::write_file;
use super::xml::escape;
use crate::MeshError;

/// A time series for ParaView: times and the names of their files, relative to the PVD file.
///
/// Write it again after each step: the file on disk is complete at any time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pvd {
    frames: Vec<(f64, String)>,
}

impl Pvd {
    /// Series without frames.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds the file of one time.
    pub fn push(&mut self, time: f64, file: impl Into<String>) {
        self.frames.push((time, file.into()));
    }

    /// The times and their files.
    pub fn frames(&self) -> &[(f64, String)] {
        &self.frames
    }

    /// Writes the file; it is complete or absent, never half written.
    ///
    /// # Errors
    /// [`MeshError::BadValue`] for a time that is NaN or infinite, [`MeshError::Io`].
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), MeshError> {
        if let Some(index) = self.frames.iter().position(|frame| !frame.0.is_finite()) {
            return Err(MeshError::BadValue {
                what: "list of times".into(),
                index,
                value: self.frames[index].0,
            });
        }
        write_file(path.as_ref(), |out| {
            writeln!(out, "<?xml version=\"1.0\"?>")?;
            writeln!(
                out,
                "<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>"
            )?;
            for (time, file) in &self.frames {
                let file = escape(file);
                writeln!(
                    out,
                    "<DataSet timestep=\"{time}\" part=\"0\" file=\"{file}\"/>"
                )?;
            }
            writeln!(out, "</Collection>\n</VTKFile>")
        })
    }
}
