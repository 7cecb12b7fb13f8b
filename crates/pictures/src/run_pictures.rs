//! The pictures of a run, drawn while it goes on.

use models::{Hydrodynamics, SolutionFlow};
use scene::{PhaseSpan, Scene};
use serde_json::Value;
use swimmer::output::Folder;
use swimmer::{Outcome, Progress, Report, RunFiles, SpanResult, SpanSolution, SwimError};

use crate::flow_slices::{FLOW_SLICES, SliceSeries, StoredSlices};
use crate::plot::trajectory_svg;
use crate::report_page::{REPORT_PAGE, RunRecord};

/// `trajectory.svg`, `flow_slices.json` and `report.html` of a run.
#[derive(Debug, Default)]
pub struct RunPictures {
    run: Option<Running>,
}

/// A run that has begun.
#[derive(Debug)]
struct Running {
    scene: Scene,
    folder: Folder,
    /// Slices of the flow, until the gait is done.
    series: Option<SliceSeries>,
    stored: StoredSlices,
}

impl RunPictures {
    /// No pictures yet.
    pub fn new() -> Self {
        Self::default()
    }
}

impl RunFiles for RunPictures {
    fn begins(&mut self, scene: &Scene, folder: &Folder, spans: usize) -> Result<(), SwimError> {
        let series = match spans {
            1.. => SliceSeries::resumed(scene, folder, spans)?,
            0 => {
                for name in [REPORT_PAGE, FLOW_SLICES] {
                    folder.remove_old(name)?;
                }
                SliceSeries::new(scene)?
            }
        };
        self.run = Some(Running {
            scene: scene.clone(),
            folder: folder.clone(),
            series: Some(series),
            stored: StoredSlices::default(),
        });
        Ok(())
    }

    fn solved(&mut self, span: &PhaseSpan, solution: &SpanSolution) -> Result<(), SwimError> {
        if let Some(run) = &mut self.run
            && let Some(series) = &mut run.series
        {
            series.add(&run.scene, span, solution)?;
        }
        Ok(())
    }

    fn span_done(
        &mut self,
        span: &PhaseSpan,
        result: &SpanResult,
        first: usize,
        flow: Option<&SolutionFlow>,
    ) -> Result<(), SwimError> {
        if let Some(run) = &mut self.run
            && let Some(series) = &mut run.series
        {
            series.finish_span(&run.scene, span, result, first, flow)?;
        }
        Ok(())
    }

    fn write(&mut self, so_far: &Outcome) -> Result<(), SwimError> {
        if let Some(run) = &self.run {
            if let Some(series) = &run.series {
                series.write(&run.folder)?;
            }
            let svg = trajectory_svg(&run.scene, so_far)?;
            (run.folder).write("trajectory.svg", |file| file.write_all(svg.as_bytes()))?;
        }
        Ok(())
    }

    fn gait_done(
        &mut self,
        model: &mut dyn Hydrodynamics,
        progress: &mut dyn Progress,
    ) -> Result<(), SwimError> {
        if let Some(run) = &mut self.run
            && let Some(series) = run.series.take()
        {
            run.stored = series.finish(&run.folder, &run.scene, model, progress)?;
        }
        Ok(())
    }

    fn run_done(&mut self, report: &Report, summary: &Value) -> Result<(), SwimError> {
        if let Some(run) = self.run.take() {
            let (scene, outcome, folder) = (&report.scene, &report.outcome, &run.folder);
            let record = RunRecord::new(scene, outcome, summary, run.stored, folder.path());
            record.write_page(folder)?;
        }
        Ok(())
    }
}
