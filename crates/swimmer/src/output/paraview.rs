//! ParaView files: flows of a run, and the collection with their times.

use std::path::Path;

use mesh::{MeshError, Pvd, Vtu};
use models::{Configuration, FlowField, Hydrodynamics, ModelError, SolutionFlow};
use scene::{FlowsKind, PhaseSpan};

use super::folder::Folder;
use crate::error::SwimError;
use crate::integrate::{SpanResult, SpanSolution};

/// The flows of a simulation as `trajectory.pvd`, a collection of `.vtu` files.
///
/// With [`FlowsKind::All`] a flow is written after its solve. The flows of solves that the
/// integration discards are removed at the end of the phase span, so the collection contains the
/// trajectory only. A model with a mesh solves again for those of its solutions that were
/// interpolated. With [`FlowsKind::Phase`] only the last flow of a phase span is computed, if it
/// was solved for.
#[derive(Debug)]
pub struct FlowSeries {
    folder: Folder,
    which: FlowsKind,
    /// Numbers of the solves of this phase span whose flows are written.
    pending: Vec<usize>,
    /// Number of the last solve and its position on the phase span.
    last: Option<(usize, f64)>,
    kept: Pvd,
}

impl FlowSeries {
    /// An empty collection in a folder.
    pub fn new(folder: &Folder, which: FlowsKind) -> Self {
        Self {
            folder: folder.clone(),
            which,
            pending: Vec::new(),
            last: None,
            kept: Pvd::new(),
        }
    }

    /// Continues a collection with the files that [`FlowSeries::files`] returned.
    pub fn resumed(folder: &Folder, which: FlowsKind, files: &[(f64, String)]) -> Self {
        let mut series = Self::new(folder, which);
        for (time, name) in files {
            series.kept.push(*time, name.clone());
        }
        series
    }

    /// Times and names of the files that belong to the trajectory.
    pub fn files(&self) -> &[(f64, String)] {
        self.kept.frames()
    }

    /// Notes a solve, whose number counts over the whole simulation, and writes its flow if all
    /// are wanted.
    ///
    /// # Errors
    /// [`SwimError::Write`], or a model error for fields that do not fit the mesh.
    pub fn solved(&mut self, solution: &SpanSolution) -> Result<(), SwimError> {
        self.last = Some((solution.number, solution.s));
        if let (FlowsKind::All, Some(flow)) = (self.which, &solution.solution.flow) {
            self.write(solution.number, flow.field()?, Some(solution))?;
            self.pending.push(solution.number);
        }
        Ok(())
    }

    /// Writes a flow, with the numbers of the solution that it belongs to if that is known.
    fn write(
        &self,
        number: usize,
        flow: &FlowField,
        solution: Option<&SpanSolution>,
    ) -> Result<(), SwimError> {
        let numbers = solution.map_or_else(Vec::new, numbers_of_inertia);
        write_with(flow, &numbers, &self.folder.path().join(file_name(number)))
    }

    /// Keeps the flows of the solutions in the result of a phase span, removes the others and
    /// writes the collection.
    ///
    /// `first` is the number of the first solve of the phase span, `flow` the flow of the last one.
    /// The state of the model remains the same.
    ///
    /// # Errors
    /// [`SwimError::Write`], or a model error for fields that do not fit the mesh.
    pub fn finish_span(
        &mut self,
        span: &PhaseSpan,
        result: &SpanResult,
        first: usize,
        flow: Option<&SolutionFlow>,
        model: &mut dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        if let (FlowsKind::Phase, Some((number, s)), Some(flow)) =
            (self.which, self.last.take(), flow)
        {
            let mut solutions = result.solutions.iter();
            let solution = solutions.find(|solution| first + solution.number == number);
            self.write(number, flow.field()?, solution)?;
            self.kept.push(span.time(s), file_name(number));
        }
        if self.which == FlowsKind::All && model.capabilities().has_mesh {
            self.solve_missing(span, result, first, model)?;
        }
        for solve in std::mem::take(&mut self.pending) {
            match result
                .solutions
                .iter()
                .find(|solution| first + solution.number == solve)
            {
                Some(solution) => self.kept.push(span.time(solution.s), file_name(solve)),
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

    /// Writes the flows of solutions in the result that came without one, such as those of a table.
    fn solve_missing(
        &mut self,
        span: &PhaseSpan,
        result: &SpanResult,
        first: usize,
        model: &mut dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        let is_written =
            |solution: &&SpanSolution| self.pending.contains(&(first + solution.number));
        let missing: Vec<&SpanSolution> = (result.solutions.iter())
            .filter(|solution| !is_written(solution))
            .collect();
        if missing.is_empty() {
            return Ok(());
        }
        let history = model.history()?;
        for solution in missing {
            let number = first + solution.number;
            let shape = span.shape(solution.s);
            let configuration =
                Configuration::new(&solution.state, &shape).at_time(span.time(solution.s));
            let flow = (model.flows()?).flow(configuration, &span.rates(solution.s))?;
            self.write(number, &flow, Some(solution))?;
            self.pending.push(number);
        }
        Ok(model.restore(&history)?)
    }
}

/// Writes a flow as a `.vtu` file: velocity and vorticity at all nodes, the latter linear between
/// vertices as the pressure, which is written if it is known.
///
/// # Errors
/// [`SwimError::Write`], or a model error for fields that do not fit the mesh.
pub fn write_flow(flow: &FlowField, path: impl AsRef<Path>) -> Result<(), SwimError> {
    write_with(flow, &[], path.as_ref())
}

/// Name, numbers per row and numbers of an array that belongs to a whole file.
type FileField = (&'static str, usize, Vec<f64>);

/// Kinetic energies of fluid and bodies, and a row per body of its force and torque by added mass
/// ([`AddedMassForces`](crate::AddedMassForces)), where the fluid has inertia.
fn numbers_of_inertia(solution: &SpanSolution) -> Vec<FileField> {
    let energy = solution.kinetic_energy.iter();
    let energy = energy.map(|energy| ("kinetic_energy", 2, vec![energy.fluid, energy.bodies]));
    let names = ["added_mass_force", "added_mass_torque"];
    let added_mass = solution.added_mass.iter().flat_map(|added_mass| {
        names.into_iter().enumerate().map(|(part, name)| {
            let bodies = added_mass.bodies.iter();
            (
                name,
                3,
                bodies
                    .flat_map(|loads| loads[part].iter().copied())
                    .collect(),
            )
        })
    });
    energy.chain(added_mass).collect()
}

fn write_with(flow: &FlowField, numbers: &[FileField], path: &Path) -> Result<(), SwimError> {
    let velocity: Vec<f64> = flow.velocity.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
    let vorticity = flow.vorticity()?;
    let vorticity: Vec<f64> = vorticity.iter().flat_map(|w| [w.x, w.y, w.z]).collect();
    let write = || {
        let mut file = Vtu::cells(&flow.mesh).point_field("velocity", 3, &velocity)?;
        for (name, components, values) in numbers {
            file = file.file_field(name, *components, values)?;
        }
        let file = file.vertex_field("vorticity", 3, &vorticity)?;
        match flow.pressure.is_empty() {
            true => file.write(path),
            false => file
                .vertex_field("pressure", 1, &flow.pressure)?
                .write(path),
        }
    };
    write().map_err(from_mesh)
}

/// Reports a file that cannot be written as such, and any other error as one of the model.
fn from_mesh(error: MeshError) -> SwimError {
    match error {
        MeshError::Io { path, source } => SwimError::Write { path, source },
        error => ModelError::from(error).into(),
    }
}

fn file_name(solve: usize) -> String {
    format!("flow_{solve:05}.vtu")
}
