//! `flow_slices.json`: the flow in a plane at some times of a run, for the report.

use std::io::ErrorKind;
use std::path::Path;

use models::{Configuration, FlowField, Hydrodynamics, SolutionFlow};
use nalgebra::{Isometry3, UnitQuaternion};
use rayon::prelude::*;
use rigid::State;
use scene::{PhaseSpan, Scene};
use serde::{Deserialize, Serialize};
use swimmer::output::{read_sealed, write_sealed};
use swimmer::{Folder, Progress, SpanResult, SpanSolution};

use crate::error::PictureError;
use crate::flow_slice::{FlowSlice, SliceFrame, SlicePlane};
use crate::packed;

/// Name of the file.
pub(crate) const FLOW_SLICES: &str = "flow_slices.json";

/// Number of slices of the first cycle, for models with a mesh.
const TIMES: usize = 12;

/// The same for models that evaluate the flow point by point, after the run.
const TIMES_BY_POINTS: usize = 6;

/// Number of points of a slice of a flow on a mesh, and of one that is evaluated point by point.
///
/// The first kind takes 10 ms per slice, the second kind 30 ms.
const POINTS: usize = 3000;
const POINTS_ONE_BY_ONE: usize = 2400;

/// The flow in a plane at one time.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(crate) struct StoredSlice {
    pub time: f64,
    /// Number of its phase span.
    span: usize,
    pub plane: SlicePlane,
    pub columns: usize,
    pub rows: usize,
    /// Unit of the velocities.
    pub unit: f64,
    /// Velocity components to the right, upwards and towards the viewer, one grid per component
    /// ([`packed::steps`]).
    pub velocity: String,
    /// Unit of the pressures.
    pub pressure_unit: f64,
    /// Pressures; `None` for models that do not compute them.
    pub pressure: Option<String>,
}

/// A configuration of the trajectory whose flow is evaluated after the run.
#[derive(Clone, Debug, Deserialize, Serialize)]
struct Unsolved {
    time: f64,
    /// Number of its phase span.
    span: usize,
    frames: Vec<Isometry3<f64>>,
    attitudes: Vec<UnitQuaternion<f64>>,
    joints: Vec<f64>,
    shape: Vec<f64>,
    rates: Vec<f64>,
}

/// Number of phases per cycle from which only the last solution of each phase is sampled.
const MANY_PHASES: usize = 13;

/// Largest mesh, in nodes, whose flows are kept until the end of the phase span: a few megabytes
/// each.
///
/// On larger meshes every solution is sampled at once: a slice costs little compared to the solve.
const KEPT_NODES: usize = 60_000;

/// A solve of the current phase span, with its flow if the model provides one.
#[derive(Debug)]
struct Solved {
    number: usize,
    configuration: Unsolved,
    flow: Option<Flow>,
}

#[derive(Debug)]
enum Flow {
    Field(Box<FlowField>),
    Slice(Box<StoredSlice>),
}

impl Solved {
    /// Keeps the slice of a flow instead of the flow.
    fn sample(&mut self, frame: &SliceFrame, scene: &Scene) -> Result<(), PictureError> {
        if let Some(Flow::Field(field)) = &self.flow {
            let slice = self.configuration.sampled(frame, scene, field)?;
            self.flow = Some(Flow::Slice(Box::new(slice)));
        }
        Ok(())
    }
}

/// Contents of the file.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub(crate) struct StoredSlices {
    pub slices: Vec<StoredSlice>,
    #[serde(default)]
    unsolved: Vec<Unsolved>,
    /// Why there are no slices, or fewer than there could be.
    #[serde(default)]
    pub missing: Option<String>,
}

impl StoredSlices {
    /// Reads the file of a folder; without slices, but with the reason, if that fails.
    pub fn read(folder: &Path) -> Self {
        let path = folder.join(FLOW_SLICES);
        read_sealed(&path).unwrap_or_else(|error| Self {
            missing: Some(match error.kind() {
                ErrorKind::NotFound => format!("the folder has no file {FLOW_SLICES}"),
                _ => format!("{FLOW_SLICES} is damaged: {error}; repeat the run"),
            }),
            ..Self::default()
        })
    }

    fn write(&self, folder: &Folder) -> Result<(), PictureError> {
        Ok(write_sealed(folder, FLOW_SLICES, self)?)
    }
}

/// Slices of the flow at about evenly distributed times of the first cycle.
///
/// The flow of a model with a mesh is sampled at the end of each phase span, because the
/// integration discards half of the solutions of a phase span. In cycles with many phases only the
/// last solution of each phase is sampled. The flow of models without a mesh is evaluated after the
/// run.
#[derive(Debug)]
pub(crate) struct SliceSeries {
    frame: SliceFrame,
    /// Duration of a cycle.
    cycle: f64,
    /// Whether only the last solution of a phase span is sampled: the model computes one flow per
    /// phase span.
    takes_last: bool,
    pending: Vec<Solved>,
    stored: StoredSlices,
}

impl SliceSeries {
    /// An empty series.
    ///
    /// # Errors
    /// Those of [`SliceFrame::from_scene`].
    pub fn new(scene: &Scene) -> Result<Self, PictureError> {
        let gait = scene.gait();
        Ok(Self {
            frame: SliceFrame::from_scene(scene)?,
            cycle: gait.cycle_duration(),
            takes_last: gait.phases.len() >= MANY_PHASES,
            pending: Vec::new(),
            stored: StoredSlices::default(),
        })
    }

    /// Continues the series of an interrupted run with some completed phase spans.
    ///
    /// Slices of later phase spans are left out: that run may have ended after it had written them
    /// and before its checkpoint. Where its file cannot be read, the reason stays in the new one.
    ///
    /// # Errors
    /// Those of [`SliceFrame::from_scene`].
    pub fn resumed(scene: &Scene, folder: &Folder, spans: usize) -> Result<Self, PictureError> {
        let mut stored = StoredSlices::read(folder.path());
        stored.slices.retain(|slice| slice.span < spans);
        stored.unsolved.retain(|unsolved| unsolved.span < spans);
        Ok(Self {
            stored,
            ..Self::new(scene)?
        })
    }

    /// Records a solve in the first cycle, with its flow for models with a mesh.
    ///
    /// # Errors
    /// A state in which a loop does not close; a flow that cannot be converted.
    pub fn add(
        &mut self,
        scene: &Scene,
        span: &PhaseSpan,
        solved: &SpanSolution,
    ) -> Result<(), PictureError> {
        let time = span.time(solved.s);
        if time > self.cycle {
            return Ok(());
        }
        let configuration = Unsolved {
            time,
            span: span.number,
            frames: solved.state.frames.clone(),
            attitudes: solved.state.attitudes.clone(),
            joints: solved.state.joints.clone(),
            rates: span.rates(solved.s),
            shape: span.shape(solved.s),
        };
        let field = match (self.takes_last, &solved.solution.flow) {
            (false, Some(flow)) => Some(flow.field()?.clone()),
            _ => None,
        };
        let is_large = (field.as_ref()).is_some_and(|field| field.mesh.n_points() > KEPT_NODES);
        let mut solved = Solved {
            number: solved.number,
            configuration,
            flow: field.map(|field| Flow::Field(Box::new(field))),
        };
        if is_large {
            solved.sample(&self.frame, scene)?;
        }
        self.pending.push(solved);
        Ok(())
    }

    /// Stores, for each slice time in the phase span, the accepted solution that is nearest in
    /// time.
    ///
    /// `first` is the number of the first solve of the phase span, `flow` the flow of the last one.
    ///
    /// # Errors
    /// A flow that cannot be converted.
    pub fn finish_span(
        &mut self,
        scene: &Scene,
        span: &PhaseSpan,
        result: &SpanResult,
        first: usize,
        flow: Option<&SolutionFlow>,
    ) -> Result<(), PictureError> {
        let mut pending = std::mem::take(&mut self.pending);
        if let (true, Some(last), Some(flow)) = (self.takes_last, pending.last_mut(), flow) {
            last.flow = Some(Flow::Field(Box::new(flow.field()?.clone())));
        }
        let in_result = |number: usize| {
            let mut solutions = result.solutions.iter();
            solutions.any(|solution| first + solution.number == number)
        };
        pending.retain(|solved| in_result(solved.number));
        let has_flow = pending.iter().any(|solved| solved.flow.is_some());
        if has_flow {
            pending.retain(|solved| solved.flow.is_some());
        }
        let count = if has_flow { TIMES } else { TIMES_BY_POINTS };
        let times = (0..count).map(|k| self.cycle * (k as f64 + 0.5) / count as f64);
        let mut chosen: Vec<usize> = times
            .filter(|time| (span.start..span.start + span.duration).contains(time))
            .filter_map(|time| {
                let off = |k: &usize| (pending[*k].configuration.time - time).abs();
                (0..pending.len()).min_by(|a, b| off(a).total_cmp(&off(b)))
            })
            .collect();
        if chosen.is_empty() {
            return Ok(());
        }
        chosen.sort_unstable();
        chosen.dedup();
        let mut chosen: Vec<Solved> = (pending.into_iter().enumerate())
            .filter(|(k, _)| chosen.binary_search(k).is_ok())
            .map(|(_, solved)| solved)
            .collect();
        chosen.sort_by(|a, b| a.configuration.time.total_cmp(&b.configuration.time));
        // Each slice looks for its cells by itself.
        (chosen.par_iter_mut()).try_for_each(|solved| solved.sample(&self.frame, scene))?;
        for solved in chosen {
            match solved.flow {
                Some(Flow::Slice(slice)) => self.stored.slices.push(*slice),
                _ => self.stored.unsolved.push(solved.configuration),
            }
        }
        Ok(())
    }

    /// Writes the slices so far.
    ///
    /// # Errors
    /// [`PictureError::Write`].
    pub fn write(&self, folder: &Folder) -> Result<(), PictureError> {
        self.stored.write(folder)
    }

    /// Evaluates the flows that are still missing and writes the file.
    ///
    /// If the model cannot evaluate its flow, the reason is stored in `missing`.
    ///
    /// # Errors
    /// [`PictureError::Write`].
    pub fn finish(
        mut self,
        folder: &Folder,
        scene: &Scene,
        model: &mut dyn Hydrodynamics,
        progress: &mut dyn Progress,
    ) -> Result<StoredSlices, PictureError> {
        let unsolved = std::mem::take(&mut self.stored.unsolved);
        let all = unsolved.len() as f64;
        for (done, unsolved) in unsolved.into_iter().enumerate() {
            progress.works("the flow for the report", done as f64, all);
            match unsolved.solve(&self.frame, scene, model) {
                Ok(slice) => self.stored.slices.push(slice),
                Err(error) => {
                    self.stored.missing = Some(error.to_string());
                    break;
                }
            }
        }
        self.stored.write(folder)?;
        Ok(self.stored)
    }
}

impl Unsolved {
    fn state(&self) -> State {
        State {
            frames: self.frames.clone(),
            attitudes: self.attitudes.clone(),
            joints: self.joints.clone(),
        }
    }

    fn plane(&self, frame: &SliceFrame, scene: &Scene) -> Result<SlicePlane, PictureError> {
        let poses = scene.articulation().place(&self.state(), &self.shape)?;
        Ok(frame.around(scene, &self.shape, &poses))
    }

    /// The slice of a flow on a mesh.
    fn sampled(
        &self,
        frame: &SliceFrame,
        scene: &Scene,
        field: &FlowField,
    ) -> Result<StoredSlice, PictureError> {
        let slice = FlowSlice::from_field(self.plane(frame, scene)?, POINTS, field)?;
        Ok(StoredSlice::new((self.time, self.span), &slice))
    }

    /// The slice of the flow that the model evaluates point by point.
    fn solve(
        &self,
        frame: &SliceFrame,
        scene: &Scene,
        model: &mut dyn Hydrodynamics,
    ) -> Result<StoredSlice, PictureError> {
        let state = self.state();
        let configuration = Configuration::new(&state, &self.shape).at_time(self.time);
        let plane = self.plane(frame, scene)?;
        let slice = FlowSlice::sample(plane, POINTS_ONE_BY_ONE, |points| {
            (model.flows()?).flow_at(configuration, &self.rates, points)
        })?;
        Ok(StoredSlice::new((self.time, self.span), &slice))
    }
}

impl StoredSlice {
    fn new((time, span): (f64, usize), slice: &FlowSlice) -> Self {
        let plane = slice.plane;
        let axes = [plane.right, plane.up, plane.normal()];
        let components: Vec<Option<f64>> = (axes.iter())
            .flat_map(|axis| {
                slice
                    .values
                    .iter()
                    .map(|at| Some(at.as_ref()?.velocity.dot(axis)))
            })
            .collect();
        let pressures: Vec<Option<f64>> = (slice.values.iter())
            .map(|at| at.as_ref()?.pressure)
            .collect();
        let (unit, velocity) = packed::steps(&components);
        let (pressure_unit, pressure) = packed::steps(&pressures);
        let has_pressure = pressures.iter().any(Option::is_some);
        Self {
            time,
            span,
            plane,
            columns: slice.columns,
            rows: slice.rows,
            unit,
            velocity,
            pressure_unit,
            pressure: has_pressure.then_some(pressure),
        }
    }

    /// The slice, rounded to the stored precision; `None` for damaged data.
    pub fn slice(&self) -> Option<FlowSlice> {
        let count = self.columns.checked_mul(self.rows)?;
        let components = packed::from_steps(self.unit, &self.velocity)?;
        let stored = self.pressure.as_deref();
        // Before anything of this size is allocated.
        let fits = self.columns > 1 && self.rows > 1;
        if !fits || Some(components.len()) != count.checked_mul(3) {
            return None;
        }
        let pressures = match stored {
            Some(text) => packed::from_steps(self.pressure_unit, text)?,
            None => vec![None; count],
        };
        if pressures.len() != count {
            return None;
        }
        let plane = self.plane;
        let axes = [plane.right, plane.up, plane.normal()];
        let value = |k: usize| {
            let mut velocity = nalgebra::Vector3::zeros();
            for (axis, grid) in axes.iter().zip(components.chunks(count)) {
                velocity += axis * grid[k]?;
            }
            let pressure = pressures[k];
            Some(models::PointFlow { velocity, pressure })
        };
        Some(FlowSlice {
            plane,
            columns: self.columns,
            rows: self.rows,
            values: (0..count).map(value).collect(),
            viscosities: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The slices of the first phase span are lost with the file; those of later ones do not make
    /// the series complete.
    #[test]
    fn bug_a_damaged_file_of_slices_lost_its_reason_when_the_run_was_resumed() {
        let text = "model.kind = \"rpy\"\n\
            bodies = [{ name = \"a\", radius = 1, position = [0, 0, 0], force = [1, 0, 0] }]\n\
            gait.phases = [{ duration = 1 }, { duration = 1 }]";
        let scene = Scene::parse(text).unwrap();
        let temporary = tempfile::tempdir().unwrap();
        let folder = Folder::create(temporary.path()).unwrap();
        std::fs::write(temporary.path().join(FLOW_SLICES), "{}").unwrap();
        let mut series = SliceSeries::resumed(&scene, &folder, 1).unwrap();
        let mut model = swimmer::choose(&scene).unwrap().model;
        let mut spans = scene::spans(scene.gait(), &[]).unwrap();
        let span = spans.nth(1).unwrap();
        let mut solved = Vec::new();
        let method = swimmer::Method::Collocation;
        let result = swimmer::Integrator::new(&scene, model.as_mut(), method)
            .span(&span, &scene.initial_state(), &mut |solution, _| {
                solved.push(solution.clone());
                Ok(())
            })
            .unwrap();
        for solution in &solved {
            series.add(&scene, &span, solution).unwrap();
        }
        series.finish_span(&scene, &span, &result, 0, None).unwrap();
        series.write(&folder).unwrap();
        let stored = series
            .finish(&folder, &scene, model.as_mut(), &mut ())
            .unwrap();
        assert!(!stored.slices.is_empty());
        let reason = stored.missing.expect("the reason");
        assert!(reason.contains("flow_slices.json is damaged"), "{reason}");
        let read = StoredSlices::read(folder.path());
        assert_eq!(read.missing, Some(reason));
    }
}
