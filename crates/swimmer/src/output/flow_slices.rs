//! `flow_slices.json`: the flow in a plane at some times of a run, for its page.

use std::path::Path;

use models::{Configuration, FlowField, Hydrodynamics};
use nalgebra::{Isometry3, UnitQuaternion};
use rigid::State;
use scene::{Leg, Scene};
use serde::{Deserialize, Serialize};

use super::folder::Folder;
use super::packed;
use crate::error::SwimError;
use crate::flow_slice::{FlowSlice, SliceFrame, SlicePlane};
use crate::integrate::{LegResult, LegSolution};

/// Name of the file.
const FILE: &str = "flow_slices.json";

/// Number of times in the first cycle, for models with a mesh.
const TIMES: usize = 12;

/// The same for models that evaluate the flow point by point, after the run.
const TIMES_BY_POINTS: usize = 6;

/// Number of points of a slice, and of one that is evaluated point by point.
///
/// A slice of the first kind takes 1 % of a solve, one of the second kind 30 ms.
const POINTS: usize = 4000;
const POINTS_ONE_BY_ONE: usize = 2400;

/// The flow in a plane at one time.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(crate) struct StoredSlice {
    pub time: f64,
    pub plane: SlicePlane,
    pub columns: usize,
    pub rows: usize,
    /// Unit of the velocities.
    pub unit: f64,
    /// Components to the right, upwards and towards the viewer, one grid after the other
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
    frames: Vec<Isometry3<f64>>,
    attitudes: Vec<UnitQuaternion<f64>>,
    joints: Vec<f64>,
    lengths: Vec<f64>,
    rates: Vec<f64>,
}

#[derive(Clone, Debug)]
enum Flow {
    Known(Box<StoredSlice>),
    Unsolved(Box<Unsolved>),
}

/// Contents of the file.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub(crate) struct StoredSlices {
    pub slices: Vec<StoredSlice>,
    #[serde(default)]
    unsolved: Vec<Unsolved>,
    /// Why there are no slices.
    #[serde(default)]
    pub missing: Option<String>,
}

impl StoredSlices {
    /// Reads the file of a folder; no slices if there is none, or one that is damaged.
    pub fn read(folder: &Path) -> Self {
        let text = std::fs::read_to_string(folder.join(FILE)).ok();
        let stored = text.and_then(|text| serde_json::from_str(&text).ok());
        stored.unwrap_or_else(|| Self {
            missing: Some(format!("the folder has no file {FILE}")),
            ..Self::default()
        })
    }

    fn write(&self, folder: &Folder) -> Result<(), SwimError> {
        folder
            .write(FILE, |file| Ok(serde_json::to_writer(file, self)?))
            .map(drop)
    }
}

/// Slices of the flow at about evenly distributed times of the first cycle, while it is run.
///
/// The flow of a model with a mesh is sampled after its solve. That of other models is evaluated
/// after the run, at the same configurations. Solutions that the integration discards are left out.
#[derive(Debug)]
pub(crate) struct SliceSeries {
    frame: SliceFrame,
    /// Duration of a cycle.
    cycle: f64,
    pending: Vec<(usize, Flow)>,
    stored: StoredSlices,
}

impl SliceSeries {
    /// An empty series.
    ///
    /// # Errors
    /// Those of [`SliceFrame::of`].
    pub fn new(scene: &Scene) -> Result<Self, SwimError> {
        let gait = scene.gait();
        Ok(Self {
            frame: SliceFrame::of(scene)?,
            cycle: gait.phases.iter().map(|phase| phase.duration).sum(),
            pending: Vec::new(),
            stored: StoredSlices::default(),
        })
    }

    /// Continues the series of an interrupted run.
    ///
    /// # Errors
    /// Those of [`SliceFrame::of`].
    pub fn resumed(scene: &Scene, folder: &Folder) -> Result<Self, SwimError> {
        Ok(Self {
            stored: StoredSlices::read(folder.path()),
            ..Self::new(scene)?
        })
    }

    /// Records a solve in the first cycle, with its flow for models with a mesh.
    ///
    /// # Errors
    /// A state in which a loop does not close.
    pub fn add(
        &mut self,
        scene: &Scene,
        leg: &Leg,
        solved: &LegSolution,
        field: Option<&FlowField>,
    ) -> Result<(), SwimError> {
        let time = leg.time(solved.s);
        if time > self.cycle {
            return Ok(());
        }
        let lengths = leg.lengths(solved.s);
        let flow = match field {
            Some(field) => {
                let poses = scene.articulation().place(&solved.state, &lengths)?;
                let plane = self.frame.around(scene, &poses);
                let slice = FlowSlice::of_field(plane, POINTS, field)?;
                Flow::Known(Box::new(StoredSlice::new(time, &slice)))
            }
            None => Flow::Unsolved(Box::new(Unsolved {
                time,
                frames: solved.state.frames.clone(),
                attitudes: solved.state.attitudes.clone(),
                joints: solved.state.joints.clone(),
                rates: leg.rates(solved.s),
                lengths,
            })),
        };
        self.pending.push((solved.number, flow));
        Ok(())
    }

    /// Keeps, for each time of the leg, the flow of the nearest solution in its result.
    ///
    /// `first` is the number of the first solve of the leg.
    ///
    /// # Errors
    /// [`SwimError::Write`].
    pub fn finish_leg(
        &mut self,
        folder: &Folder,
        leg: &Leg,
        result: &LegResult,
        first: usize,
    ) -> Result<(), SwimError> {
        let in_result = |solve: usize| {
            let mut solutions = result.solutions.iter();
            solutions.any(|solution| first + solution.number == solve)
        };
        let mut pending = std::mem::take(&mut self.pending);
        pending.retain(|(solve, _)| in_result(*solve));
        let count = match pending.first() {
            None => return Ok(()),
            Some((_, Flow::Known(_))) => TIMES,
            Some((_, Flow::Unsolved(_))) => TIMES_BY_POINTS,
        };
        let time_of = |flow: &Flow| match flow {
            Flow::Known(slice) => slice.time,
            Flow::Unsolved(unsolved) => unsolved.time,
        };
        let times = (0..count).map(|k| self.cycle * (k as f64 + 0.5) / count as f64);
        let mut chosen: Vec<usize> = times
            .filter(|time| (leg.start..leg.start + leg.duration).contains(time))
            .filter_map(|time| {
                let off = |k: &usize| (time_of(&pending[*k].1) - time).abs();
                (0..pending.len()).min_by(|a, b| off(a).total_cmp(&off(b)))
            })
            .collect();
        chosen.sort_by(|a, b| time_of(&pending[*a].1).total_cmp(&time_of(&pending[*b].1)));
        chosen.dedup();
        if chosen.is_empty() {
            return Ok(());
        }
        for k in chosen {
            match pending[k].1.clone() {
                Flow::Known(slice) => self.stored.slices.push(*slice),
                Flow::Unsolved(unsolved) => self.stored.unsolved.push(*unsolved),
            }
        }
        self.stored.missing = None;
        self.stored.write(folder)
    }

    /// Evaluates the flows that are still missing and writes the file.
    ///
    /// A model that cannot evaluate its flow leaves the reason instead of slices.
    ///
    /// # Errors
    /// [`SwimError::Write`].
    pub fn finish(
        mut self,
        folder: &Folder,
        scene: &Scene,
        model: &mut dyn Hydrodynamics,
    ) -> Result<StoredSlices, SwimError> {
        for unsolved in std::mem::take(&mut self.stored.unsolved) {
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
    fn solve(
        &self,
        frame: &SliceFrame,
        scene: &Scene,
        model: &mut dyn Hydrodynamics,
    ) -> Result<StoredSlice, SwimError> {
        let state = State {
            frames: self.frames.clone(),
            attitudes: self.attitudes.clone(),
            joints: self.joints.clone(),
        };
        let lengths = &self.lengths[..];
        let poses = scene.articulation().place(&state, lengths)?;
        let configuration = Configuration {
            state: &state,
            lengths,
        };
        let plane = frame.around(scene, &poses);
        let slice = FlowSlice::sample(plane, POINTS_ONE_BY_ONE, |points| {
            model.flow_at(configuration, &self.rates, points)
        })?;
        Ok(StoredSlice::new(self.time, &slice))
    }
}

impl StoredSlice {
    fn new(time: f64, slice: &FlowSlice) -> Self {
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
            plane,
            columns: slice.columns,
            rows: slice.rows,
            unit,
            velocity,
            pressure_unit,
            pressure: has_pressure.then_some(pressure),
        }
    }

    /// The slice to the digits that are stored; `None` for damaged data.
    #[cfg(feature = "plots")]
    pub fn slice(&self) -> Option<FlowSlice> {
        let count = self.columns.checked_mul(self.rows)?;
        let components = packed::from_steps(self.unit, &self.velocity)?;
        let stored = self.pressure.as_deref();
        let pressures = match stored {
            Some(text) => packed::from_steps(self.pressure_unit, text)?,
            None => vec![None; count],
        };
        let fits = self.columns > 1 && self.rows > 1;
        if !fits || components.len() != 3 * count || pressures.len() != count {
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
        })
    }
}
