//! ParaView files: the flow at every solved instant, and the collection that puts them in time.

use std::path::Path;

use mesh::{Pvd, Vtu};

use crate::{Folder, LegResult, SwimError};
use models::{FlowField, ModelError};
use scene::Leg;

/// The flows of a simulation as `trajectory.pvd`, a collection of `.vtu` files.
///
/// Flows are written when they are solved; those of instants that the integration then discards are removed at the
/// end of their leg, so the collection holds the trajectory alone.
#[derive(Debug)]
pub struct FlowSeries {
    folder: Folder,
    pending: Vec<usize>,
    kept: Pvd,
}

impl FlowSeries {
    /// An empty collection in a folder.
    pub fn new(folder: &Folder) -> Self {
        Self {
            folder: folder.clone(),
            pending: Vec::new(),
            kept: Pvd::new(),
        }
    }

    /// Goes on with a collection, as [`FlowSeries::files`] gave it.
    pub fn resumed(folder: &Folder, files: &[(f64, String)]) -> Self {
        let mut series = Self::new(folder);
        for (time, name) in files {
            series.kept.push(*time, name.clone());
        }
        series
    }

    /// Times and names of the files that belong to the trajectory.
    pub fn files(&self) -> &[(f64, String)] {
        self.kept.frames()
    }

    /// Writes the flow of a solve: velocity at all nodes, pressure at vertices (midside nodes get the mean of their edge).
    ///
    /// # Errors
    /// [`SwimError::Write`], or what the mesh says of fields that do not fit it.
    pub fn add(&mut self, solve: usize, flow: &FlowField) -> Result<(), SwimError> {
        write_flow(flow, &self.folder.path().join(file_name(solve)))?;
        self.pending.push(solve);
        Ok(())
    }

    /// Keeps the flows that a finished leg is made of, removes the others and writes the collection.
    ///
    /// `first` is the number of the leg's first solve.
    ///
    /// # Errors
    /// [`SwimError::Write`].
    pub fn finish_leg(
        &mut self,
        leg: &Leg,
        result: &LegResult,
        first: usize,
    ) -> Result<(), SwimError> {
        for solve in std::mem::take(&mut self.pending) {
            match result
                .solved
                .iter()
                .find(|solved| first + solved.number == solve)
            {
                Some(solved) => self.kept.push(leg.time(solved.s), file_name(solve)),
                None => self.folder.remove(&file_name(solve))?,
            }
        }
        if self.kept.frames().is_empty() {
            return Ok(());
        }
        self.kept
            .write(self.folder.path().join("trajectory.pvd"))
            .map_err(from_mesh)
    }
}

/// Writes a flow as a `.vtu` file: velocity at all nodes, and the pressure, if it is known, at vertices.
///
/// # Errors
/// [`SwimError::Write`], or what the mesh says of fields that do not fit it.
pub fn write_flow(flow: &FlowField, path: &Path) -> Result<(), SwimError> {
    let velocity: Vec<f64> = flow.velocity.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
    let write = || {
        let file = Vtu::cells(&flow.mesh).point_field("velocity", 3, &velocity)?;
        match flow.pressure.is_empty() {
            true => file.write(path),
            false => file.vertex_field("pressure", &flow.pressure)?.write(path),
        }
    };
    write().map_err(from_mesh)
}

/// A file that cannot be written is the folder's fault, not the model's.
fn from_mesh(error: mesh::MeshError) -> SwimError {
    match error {
        mesh::MeshError::Io { path, source } => SwimError::Write { path, source },
        error => ModelError::from(error).into(),
    }
}

fn file_name(solve: usize) -> String {
    format!("flow_{solve:05}.vtu")
}
