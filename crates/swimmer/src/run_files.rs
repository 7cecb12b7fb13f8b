//! The files of a run: flows, trajectory and checkpoint, while it goes on.

use std::time::{Duration, Instant};

use models::{Hydrodynamics, SolutionFlow};
use scene::{PhaseSpan, Scene, TrajectoryKind};
use serde_json::Value;

use crate::checkpoint::Checkpoint;
use crate::error::SwimError;
use crate::integrate::{SpanResult, SpanSolution};
use crate::observer::{Observer, Progress, check_interruption};
use crate::outcome::Outcome;
use crate::output::{FlowSeries, Folder, trajectory_csv, trajectory_npy};
use crate::run_report::Report;

/// Files that the caller adds to those of a run, such as pictures.
///
/// They are written after phases and at the end, as the files of the run itself. Errors end the
/// run.
#[allow(unused_variables)]
pub trait RunFiles {
    /// The gait begins; or continues after the first `spans` phase spans with the files that an
    /// interrupted run has left.
    ///
    /// That run may have ended between [`RunFiles::write`] and its checkpoint, so the files may
    /// know more phase spans. The gait begins again if its error bar exceeds `fem.target`.
    ///
    /// # Errors
    /// Any error ends the run.
    fn begins(&mut self, scene: &Scene, folder: &Folder, spans: usize) -> Result<(), SwimError> {
        Ok(())
    }

    /// A solve is done; its solution has the flow, if the model has one.
    ///
    /// # Errors
    /// Any error ends the run.
    fn solved(&mut self, span: &PhaseSpan, solution: &SpanSolution) -> Result<(), SwimError> {
        Ok(())
    }

    /// A phase span is done, whose first solve has the number `first`, with the flow of its last
    /// solve.
    ///
    /// # Errors
    /// Any error ends the run.
    fn span_done(
        &mut self,
        span: &PhaseSpan,
        result: &SpanResult,
        first: usize,
        flow: Option<&SolutionFlow>,
    ) -> Result<(), SwimError> {
        Ok(())
    }

    /// The trajectory and then the checkpoint are written, after some phases: not after each if
    /// they are short.
    ///
    /// # Errors
    /// Any error ends the run.
    fn write(&mut self, so_far: &Outcome) -> Result<(), SwimError> {
        Ok(())
    }

    /// The gait is done, or the motion has ended before.
    ///
    /// # Errors
    /// Any error ends the run.
    fn gait_done(
        &mut self,
        model: &mut dyn Hydrodynamics,
        progress: &mut dyn Progress,
    ) -> Result<(), SwimError> {
        Ok(())
    }

    /// The run is done, and this summary of it is written.
    ///
    /// # Errors
    /// Any error ends the run.
    fn run_done(&mut self, report: &Report, summary: &Value) -> Result<(), SwimError> {
        Ok(())
    }
}

/// No further files.
impl RunFiles for () {}

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
    /// The outcome of a run that stopped within a phase, up to there.
    pub stopped: Option<Outcome>,
}

/// The folder of a run, and the flows in it.
pub(crate) struct Output<'a> {
    pub folder: &'a Folder,
    flows: FlowSeries,
    /// Flow of the last solution.
    last_flow: Option<SolutionFlow>,
    pub files: &'a mut dyn RunFiles,
    /// The last completed phase, if it is not yet written.
    pending: Option<Checkpoint>,
    /// End and duration of the last writing.
    written: Option<(Instant, Duration)>,
}

impl<'a> Output<'a> {
    /// The folder with the flows (times and names) that an interrupted run has written.
    pub fn new(
        scene: &Scene,
        folder: &'a Folder,
        files: &'a mut dyn RunFiles,
        flows: &[(f64, String)],
    ) -> Self {
        Self {
            folder,
            flows: FlowSeries::resumed(folder, scene.fem().flows, flows),
            last_flow: None,
            files,
            pending: None,
            written: None,
        }
    }

    /// Whether enough time has passed since the last writing.
    fn is_due(&self) -> bool {
        (self.written).is_none_or(|(end, took)| end.elapsed() >= CHECKPOINT_INTERVAL * took)
    }

    fn write_trajectory(&mut self, scene: &Scene, so_far: &Outcome) -> Result<(), SwimError> {
        let samples = so_far.trajectory();
        let (name, bytes) = match scene.output().trajectory {
            TrajectoryKind::Csv => (
                "trajectory.csv",
                trajectory_csv(scene, samples).into_bytes(),
            ),
            TrajectoryKind::Npy => ("trajectory.npy", trajectory_npy(scene, samples)),
        };
        self.folder.write(name, |file| file.write_all(&bytes))?;
        self.files.write(so_far)
    }

    /// Writes trajectory and checkpoint of the last completed phase, unless they are written.
    fn write_pending(&mut self, scene: &Scene) -> Result<(), SwimError> {
        let Some(checkpoint) = self.pending.take() else {
            return Ok(());
        };
        let begin = Instant::now();
        let files = self.write_trajectory(scene, checkpoint.outcome());
        // The checkpoint is written last, so that every file that it names is complete; and also
        // without the files of the caller, so that a failed picture loses no phase.
        checkpoint.write(self.folder)?;
        files?;
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
        let gait = self.scene.gait();
        let all = gait.phases.len() * gait.cycles as usize;
        check_interruption(self.progress, self.done, all)?;
        self.progress.solved(span, solution);
        let Some(output) = &mut self.output else {
            return Ok(());
        };
        output.flows.solved(solution)?;
        let flow = solution.solution.flow.as_ref();
        output.last_flow = flow.map(SolutionFlow::without_field);
        output.files.solved(span, solution)
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
            output.files.span_done(span, result, first, flow)?;
            let flows = output.flows.files();
            let checkpoint = Checkpoint::new(self.scene, &result.end, so_far, model, flows)?;
            output.pending = Some(checkpoint.with_fluid(result.fluid.as_ref()));
            if output.is_due() {
                output.write_pending(self.scene)?;
            }
        }
        self.done = so_far.spans.len();
        self.progress.span_done(span, result);
        Ok(())
    }

    fn stopped(
        &mut self,
        span: &PhaseSpan,
        result: &SpanResult,
        so_far: &Outcome,
        model: &mut dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        self.stopped = Some(so_far.clone());
        // The checkpoint is that of the last complete phase, from which a run is resumed.
        self.write_pending()?;
        let Some(output) = &mut self.output else {
            return Ok(());
        };
        let first = so_far.solves - result.solves;
        let flow = output.last_flow.take();
        (output.flows).finish_span(span, result, first, flow.as_ref(), model)?;
        (output.files).span_done(span, result, first, flow.as_ref())?;
        output.write_trajectory(self.scene, so_far)?;
        let checkpoint = Checkpoint::read(output.folder.path())?;
        checkpoint.with_stopped(so_far).write(output.folder)
    }
}
