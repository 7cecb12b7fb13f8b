//! The tables, charts and pictures of the study.

use std::path::Path;

use anyhow::Result;

use super::cases::{Case, STEPS_PER_PHASE};
use super::methods::{METHODS, Run, Sample, Way};
use crate::chart::{LogLog, Series};
use crate::page::{self, Page};
use crate::table::{Cell, Table, fixed};

/// The runs of all methods.
struct Runs<'a>(&'a [Run]);

impl Runs<'_> {
    fn find(&self, case: &str, is_curved: bool, method: &str, way: Way) -> Option<&Run> {
        self.0.iter().find(|run| {
            run.case == case && run.is_curved == is_curved && run.method == method && run.way == way
        })
    }
}

/// Prints the study and writes its files.
pub fn write(cases: &[Case], runs: &[Run], size: f64, out: &Path) -> Result<()> {
    let runs = Runs(runs);
    let first = runs.0.iter().find(|run| run.case == "move-1");
    let vertices = first.map_or(0, |run| run.vertices);
    let mut page = Page::new(
        "Mesh motions",
        "ale",
        format!(
            "\n\nThree spheres of radius 1 on a line in a ball of radius 30, elements of size {size} on the spheres, {vertices} vertices when the arms are 10 radii long. \
             *From the reference*: extensions are computed once on the first mesh, from which every mesh is computed. *Incremental*: extensions are \
             recomputed on the mesh of every step. Quality is the smallest mean ratio of a cell along the path (1 for a regular tet); Jacobian is the smallest Jacobian of \
             a curved cell over that of the straight one."
        ),
    );
    moves(&mut page, &runs);
    approach(&mut page, &runs)?;
    let labels = cases.iter().filter(|case| case.key == "cycles");
    let labels = labels.flat_map(|case| case.steps.iter().map(|step| step.0));
    cycles(&mut page, &runs, labels.fold(0.0, f64::max))?;
    page.text("[ale-files.md](ale-files.md) has strokes with the mesh motions of the program.");
    page::write(out, "ale.csv", &samples(&runs).csv())?;
    page.write(out, "ale")
}

/// Smallest quality and Jacobian, or the label of the step where a cell was inverted.
fn verdict(run: Option<&Run>) -> Cell {
    let Some(run) = run else {
        return "-".into();
    };
    if let Some(label) = run.failed_at {
        return format!("inverted at {label:.2}").into();
    }
    let least =
        |value: fn(&Sample) -> f64| run.samples.iter().map(value).fold(f64::INFINITY, f64::min);
    let quality = least(|sample| sample.quality);
    match run.is_curved {
        true => format!("{quality:.3} / {:.2}", least(|sample| sample.jacobian)).into(),
        false => format!("{quality:.3}").into(),
    }
}

fn moves(page: &mut Page, runs: &Runs) {
    let curved = "Moves, cells curved at the spheres: smallest quality / Jacobian along the path";
    let straight = "Moves, straight cells: smallest quality along the path";
    for (is_curved, title) in [(true, curved), (false, straight)] {
        page.heading(title);
        page.text("*Inverted at* gives the completed fraction of the motion. One step is from the reference, ten steps are incremental.");
        const HEADINGS: &str = "motion;4 radii, one step;ten steps;close 5 to 2.5, one step;\
             ten steps;open 5 to 9, one step;ten steps";
        let mut table = Table::new(HEADINGS.split(';'));
        for method in &METHODS {
            let mut cells: Vec<Cell> = vec![method.name.into()];
            for key in ["move", "close", "open"] {
                for (steps, way) in [(1, Way::Reference), (10, Way::Incremental)] {
                    let key = format!("{key}-{steps}");
                    cells.push(verdict(runs.find(&key, is_curved, method.name, way)));
                }
            }
            table.push(cells);
        }
        page.table(table);
    }
    page.text(
        "A curved cell at a sphere is inverted before a straight one: its face keeps its curvature while the cell is compressed.",
    );
}

fn approach(page: &mut Page, runs: &Runs) -> Result<()> {
    page.heading("Approach: gaps close from 3 to 0.02, 15 % per step");
    page.text("The smallest gap that was reached, and the quality of the mesh there.");
    const HEADINGS: &str = "motion;curved, reference;curved, incremental;straight, reference;\
         straight, incremental";
    let mut table = Table::new(HEADINGS.split(';'));
    for method in &METHODS {
        let mut cells: Vec<Cell> = vec![method.name.into()];
        for is_curved in [true, false] {
            for way in Way::ALL {
                let run = runs.find("approach", is_curved, method.name, way);
                cells.push(match run.and_then(|run| run.samples.last()) {
                    Some(s) => format!("{:.3}: {:.3}", s.label, s.quality).into(),
                    None => "none".into(),
                });
            }
        }
        table.push(cells);
    }
    page.table(table);
    page.text(
        "A valid mesh is not necessarily accurate: cells for a gap of three radii do not resolve the flow in a much smaller gap. The program therefore remeshes \
         when cells become 1.5 times as long as the gap is wide, and before a curved cell is inverted.",
    );
    let straight = |run: &&Run| run.case == "approach" && !run.is_curved;
    let series = (runs.0.iter().filter(straight))
        .filter(|run| run.way == Way::Incremental)
        .map(|run| {
            let points = run.samples.iter().map(|s| (s.label, s.quality));
            Series::new(run.method, points)
        });
    let title =
        "Two spheres approach, 15 % of the gap per step, straight cells moved incrementally";
    let chart = LogLog::new(title, ["gap in radii", "smallest quality"], series, true);
    page.chart("ale-approach", "quality against gap", &chart)?;
    Ok(())
}

fn cycles(page: &mut Page, runs: &Runs, cycles: f64) -> Result<()> {
    page.heading(format!(
        "Closed cycles: {cycles:.0} of the stroke, arms 10 and 6, {STEPS_PER_PHASE} steps per phase, curved cells"
    ));
    page.text(
        "Drift is the largest distance of a node from its position \
         at the start of the first cycle; from the reference it is zero by construction.",
    );
    let headings = format!(
        "motion;drift after 1;after {cycles:.0};quality after 1;after {cycles:.0};\
         reference: smallest quality / Jacobian;preparation, s;reference: s per step;\
         incremental: s per step"
    );
    let mut table = Table::new(headings.split(';'));
    for method in &METHODS {
        let run = |way| runs.find("cycles", true, method.name, way);
        let (Some(reference), Some(steps)) = (run(Way::Reference), run(Way::Incremental)) else {
            continue;
        };
        let at = |cycle: f64, value: fn(&Sample) -> f64| -> Cell {
            match steps.samples.iter().find(|s| s.label == cycle) {
                Some(sample) => fixed(value(sample), 3),
                None => format!("inverted at {:.2}", steps.failed_at.unwrap_or(f64::NAN)).into(),
            }
        };
        table.push([
            method.name.into(),
            at(1.0, |s| s.displacement),
            at(cycles, |s| s.displacement),
            at(1.0, |s| s.quality),
            at(cycles, |s| s.quality),
            verdict(Some(reference)),
            fixed(reference.setup, 3),
            fixed(reference.step, 3),
            fixed(steps.step, 3),
        ]);
    }
    page.table(table);
    let incremental = |run: &&Run| run.case == "cycles" && run.way == Way::Incremental;
    let series = runs.0.iter().filter(incremental).map(|run| {
        let whole = run.samples.iter().filter(|s| s.label.fract() == 0.0);
        let points = whole.map(|s| (s.label, s.displacement));
        Series::new(run.method, points)
    });
    let title = "Drift of the mesh after closed cycles, moved incrementally";
    let y = "largest displacement of a node, in radii";
    let chart = LogLog::new(title, ["cycles", y], series, true);
    page.chart("ale-drift", "drift", &chart)?;
    Ok(())
}

/// All valid steps.
fn samples(runs: &Runs) -> Table {
    const HEADINGS: &str = "case cells motion way label quality jacobian displacement complete \
         setup_seconds step_seconds";
    let mut table = Table::new(HEADINGS.split(' '));
    for run in runs.0 {
        for s in &run.samples {
            let cells = if run.is_curved { "curved" } else { "straight" };
            let numbers = [s.label, s.quality, s.jacobian, s.displacement];
            let mut row: Vec<Cell> = vec![run.case.clone().into(), cells.into()];
            row.extend([run.method.into(), run.way.name().into()]);
            row.extend(numbers.map(|number| fixed(number, 6)));
            row.push(run.failed_at.is_none().to_string().into());
            row.extend([run.setup, run.step].map(|seconds| fixed(seconds, 4)));
            table.push(row);
        }
    }
    table
}
