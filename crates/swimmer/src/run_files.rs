//! The files of a run: flows, trajectory and checkpoint, while it goes on.

use std::io::Write as _;
use std::time::{Duration, Instant};

use models::{Hydrodynamics, SolutionFlow};
use scene::{PhaseSpan, Scene};

use crate::checkpoint::Checkpoint;
use crate::error::SwimError;
use crate::integrate::{SpanResult, SpanSolution};
use crate::observer::Observer;
use crate::outcome::Outcome;
#[cfg(feature = "plots")]
use crate::output::trajectory_svg;
use crate::output::{FlowSeries, Folder, SliceSeries, trajectory_csv};
use crate::progress::Progress;

/// Smallest ratio of the time between two checkpoints to the time that the first of them took.
///
/// In runs of many short phases, files that grow with every phase would otherwise take most of the
/// time.
const CHECKPOINT_INTERVAL: u32 = 4;

/// Writes the files of a run, if it has a folder, after its phases and at its end, so that a run
/// that ends early leaves all completed phases.
pub(crate) struct Files<'a> {
    pub scene: &'a Scene,
    pub output: Option<Output<'a>>,
    pub progress: &'a mut dyn Progress,
    /// Number of completed phase spans.
    pub done: usize,
}

/// The folder of a run, and the flows in it.
pub(crate) struct Output<'a> {
    pub folder: &'a Folder,
    flows: FlowSeries,
    /// Flow of the last solution.
    last_flow: Option<SolutionFlow>,
    pub slices: SliceSeries,
    /// The last completed phase, if it is not yet written.
    pending: Option<Checkpoint>,
    /// End and duration of the last writing.
    written: Option<(Instant, Duration)>,
}

impl<'a> Output<'a> {
    pub fn new(scene: &Scene, folder: &'a Folder) -> Result<Self, SwimError> {
        Ok(Self {
            folder,
            flows: FlowSeries::new(folder, scene.fem().flows),
            last_flow: None,
            slices: SliceSeries::new(scene)?,
            pending: None,
            written: None,
        })
    }

    pub fn resumed(
        scene: &Scene,
        folder: &'a Folder,
        flows: &[(f64, String)],
    ) -> Result<Self, SwimError> {
        Ok(Self {
            folder,
            flows: FlowSeries::resumed(folder, scene.fem().flows, flows),
            last_flow: None,
            slices: SliceSeries::resumed(scene, folder)?,
            pending: None,
            written: None,
        })
    }

    /// Whether enough time has passed since the last writing.
    fn is_due(&self) -> bool {
        (self.written).is_none_or(|(end, took)| end.elapsed() >= CHECKPOINT_INTERVAL * took)
    }

    /// Writes trajectory and checkpoint of the last completed phase, unless they are written.
    fn write_pending(&mut self, scene: &Scene) -> Result<(), SwimError> {
        let Some(checkpoint) = self.pending.take() else {
            return Ok(());
        };
        let begin = Instant::now();
        let so_far = checkpoint.outcome();
        let csv = trajectory_csv(scene, &so_far.samples);
        (self.folder).write("trajectory.csv", |file| file.write_all(csv.as_bytes()))?;
        #[cfg(feature = "plots")]
        {
            let svg = trajectory_svg(scene, so_far)?;
            (self.folder).write("trajectory.svg", |file| file.write_all(svg.as_bytes()))?;
        }
        // The checkpoint is written last, so that every file that it names is complete.
        checkpoint.write(self.folder)?;
        self.written = Some((Instant::now(), begin.elapsed()));
        Ok(())
    }
}

impl Files<'_> {
    /// Writes the last completed phase, unless it is written.
    pub fn write_pending(&mut self) -> Result<(), SwimError> {
        let output = self.output.as_mut();
        output.map_or(Ok(()), |output| output.write_pending(self.scene))
    }
}

impl Observer for Files<'_> {
    fn wants_flows(&self) -> bool {
        self.output.is_some()
    }

    fn solved(
        &mut self,
        span: &PhaseSpan,
        solution: &SpanSolution,
        _: &dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        if self.progress.is_interrupted() {
            let gait = self.scene.gait();
            return Err(SwimError::Interrupted {
                phases: self.done,
                all: gait.phases.len() * gait.cycles as usize,
            });
        }
        self.progress.solved(span, solution);
        let Some(output) = &mut self.output else {
            return Ok(());
        };
        output.flows.solved(solution)?;
        output.last_flow.clone_from(&solution.solution.flow);
        output.slices.add(self.scene, span, solution)
    }

    fn span_done(
        &mut self,
        span: &PhaseSpan,
        result: &SpanResult,
        so_far: &Outcome,
        model: &mut dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        if let Some(output) = &mut self.output {
            let first = so_far.solves - result.solves;
            let flow = output.last_flow.take();
            let flow = flow.as_ref();
            (output.flows).finish_span(span, result, first, flow, model)?;
            (output.slices).finish_span(output.folder, self.scene, span, result, first, flow)?;
            let flows = output.flows.files();
            let checkpoint = Checkpoint::new(self.scene, &result.end, so_far, model, flows)?;
            output.pending = Some(checkpoint);
            if output.is_due() {
                output.write_pending(self.scene)?;
            }
        }
        self.done = so_far.spans.len();
        self.progress.span_done(span, result);
        Ok(())
    }
}
