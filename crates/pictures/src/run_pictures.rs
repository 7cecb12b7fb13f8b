//! The pictures of a run, drawn while it goes on.

use models::{Hydrodynamics, SolutionFlow};
use scene::{PhaseSpan, Scene};
use serde_json::Value;
use swimmer::output::Folder;
use swimmer::{Outcome, Report, RunFiles, SpanResult, SpanSolution, SwimError};

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
    flow: Flow,
}

#[derive(Debug)]
enum Flow {
    Series(Box<SliceSeries>),
    Stored(StoredSlices),
}

impl RunPictures {
    /// No pictures yet.
    pub fn new() -> Self {
        Self::default()
    }
}

impl RunFiles for RunPictures {
    fn begins(&mut self, scene: &Scene, folder: &Folder, resumed: bool) -> Result<(), SwimError> {
        let series = match resumed {
            true => SliceSeries::resumed(scene, folder)?,
            false => {
                for name in [REPORT_PAGE, FLOW_SLICES] {
                    folder.remove_old(name)?;
                }
                SliceSeries::new(scene)?
            }
        };
        self.run = Some(Running {
            scene: scene.clone(),
            folder: folder.clone(),
            flow: Flow::Series(Box::new(series)),
        });
        Ok(())
    }

    fn solved(&mut self, span: &PhaseSpan, solution: &SpanSolution) -> Result<(), SwimError> {
        if let Some(Running {
            scene,
            flow: Flow::Series(series),
            ..
        }) = &mut self.run
        {
            series.add(scene, span, solution)?;
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
        if let Some(Running {
            scene,
            folder,
            flow: Flow::Series(series),
        }) = &mut self.run
        {
            series.finish_span(folder, scene, span, result, first, flow)?;
        }
        Ok(())
    }

    fn write(&mut self, so_far: &Outcome) -> Result<(), SwimError> {
        if let Some(Running { scene, folder, .. }) = &self.run {
            let svg = trajectory_svg(scene, so_far)?;
            folder.write("trajectory.svg", |file| file.write_all(svg.as_bytes()))?;
        }
        Ok(())
    }

    fn gait_done(&mut self, model: &mut dyn Hydrodynamics) -> Result<(), SwimError> {
        self.run = match self.run.take() {
            Some(Running {
                scene,
                folder,
                flow: Flow::Series(series),
            }) => Some(Running {
                flow: Flow::Stored(series.finish(&folder, &scene, model)?),
                scene,
                folder,
            }),
            other => other,
        };
        Ok(())
    }

    fn run_done(&mut self, report: &Report, summary: &Value) -> Result<(), SwimError> {
        if let Some(Running {
            folder,
            flow: Flow::Stored(slices),
            ..
        }) = self.run.take()
        {
            let (scene, outcome) = (&report.scene, &report.outcome);
            RunRecord::new(scene, outcome, summary, slices, folder.path()).write_page(&folder)?;
        }
        Ok(())
    }
}
