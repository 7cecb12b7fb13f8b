//! The study as Markdown, CSV, charts and pictures.

use std::fmt::Write;
use std::path::Path;

use anyhow::Result;

use super::cases::{Case, STEPS_PER_PHASE};
use super::cut::{Window, svg};
use super::methods::{METHODS, Way};
use super::stroke::Stroke;
use super::study::{Run, Sample};
use crate::chart::{LogLog, Series, Style};
use crate::folder;
use crate::machine;
use crate::reference::STROKES;

/// A picture: file name, case, whether cells are curved, method, way, window and title.
type Picture = (
    &'static str,
    &'static str,
    bool,
    &'static str,
    Way,
    Window,
    &'static str,
);

const KANCHI_MASUD: &str = "1 + tau (Kanchi & Masud)";

const PICTURES: [Picture; 6] = [
    (
        "move-kanchi-masud",
        "move-1",
        true,
        KANCHI_MASUD,
        Way::Reference,
        WIDE,
        "1 + tau: the left sphere moved by 4 radii in one step",
    ),
    (
        "move-elastic",
        "move-1",
        true,
        "elastic, nu = 0",
        Way::Reference,
        WIDE,
        "elastic: the same step",
    ),
    (
        "move-biharmonic",
        "move-1",
        true,
        "biharmonic",
        Way::Reference,
        WIDE,
        "biharmonic: the same",
    ),
    (
        "approach-kanchi-masud",
        "approach",
        false,
        KANCHI_MASUD,
        Way::Incremental,
        NEAR,
        "1 + tau, straight cells: the smallest gap reached",
    ),
    (
        "cycles-kanchi-masud",
        "cycles",
        true,
        KANCHI_MASUD,
        Way::Incremental,
        WIDE,
        "1 + tau, incremental: after all cycles, arms of 10 again",
    ),
    (
        "cycles-elastic",
        "cycles",
        true,
        "elastic, nu = 0",
        Way::Incremental,
        WIDE,
        "elastic, incremental: the same",
    ),
];

const WIDE: Window = Window {
    x: [-14.0, 6.0],
    z: 5.0,
};
const NEAR: Window = Window {
    x: [-4.5, 1.5],
    z: 1.8,
};

/// Prints the study and writes its files.
pub fn write(
    cases: &[Case],
    runs: &[Run],
    strokes: &[Stroke],
    size: f64,
    out: &Path,
) -> Result<()> {
    let text = markdown(cases, runs, strokes, size)?;
    println!("{text}");
    let mut files = vec![
        ("ale.md".to_owned(), text),
        ("ale.csv".to_owned(), csv(runs)?),
        ("ale-approach.svg".to_owned(), approach_chart(runs).svg()?),
        ("ale-drift.svg".to_owned(), drift_chart(runs).svg()?),
    ];
    for (name, case, curved, method, way, window, title) in PICTURES {
        if let Some(run) = find(runs, case, curved, method, way) {
            files.push((format!("ale-{name}.svg"), svg(&run.mesh, window, title)));
        }
    }
    folder::write(out, files)
}

fn find<'a>(runs: &'a [Run], case: &str, curved: bool, method: &str, way: Way) -> Option<&'a Run> {
    runs.iter().find(|run| {
        run.case == case && run.curved == curved && run.method == method && run.way == way
    })
}

/// Smallest quality and Jacobian, or the label of the step where a cell was inverted.
fn verdict(run: Option<&Run>) -> String {
    match run {
        None => "-".to_owned(),
        Some(run) => match run.failed_at {
            None if run.curved => format!("{:.3} / {:.2}", run.quality(), run.jacobian()),
            None => format!("{:.3}", run.quality()),
            Some(label) => format!("inverted at {label:.2}"),
        },
    }
}

fn markdown(cases: &[Case], runs: &[Run], strokes: &[Stroke], size: f64) -> Result<String> {
    let first = runs
        .iter()
        .find(|run| run.case == "move-1")
        .map(|run| &run.mesh);
    let vertices = first.map_or(0, mesh::TetMesh::n_vertices);
    let mut text = format!(
        "# Mesh motions\n\n{}, {}. Made by `cargo xtask ale`.\n\n\
         Three spheres of radius 1 on a line in a ball of radius 30, elements of size {size} on the spheres, {vertices} vertices when the arms are 10 radii long. \
         *From the reference*: extensions are computed once on the first mesh, from which every mesh is computed. *Incremental*: extensions are \
         recomputed on the mesh of every step. Quality is the smallest mean ratio of a cell along the path (1 for a regular tet); Jacobian is the smallest Jacobian of \
         a curved cell over that of the straight one.\n",
        machine::today(),
        machine::processor(),
    );
    moves(&mut text, runs)?;
    approach(&mut text, cases, runs)?;
    cycles(&mut text, runs)?;
    if !strokes.is_empty() {
        stroke(&mut text, strokes)?;
    }
    Ok(text)
}

fn moves(text: &mut String, runs: &[Run]) -> Result<()> {
    for (curved, title) in [
        (
            true,
            "Moves, cells curved at the spheres: smallest quality / Jacobian along the path",
        ),
        (
            false,
            "Moves, straight cells: smallest quality along the path",
        ),
    ] {
        write!(
            text,
            "\n## {title}\n\n*Inverted at* gives the completed fraction of the motion. One step is from the reference, ten steps are incremental.\n\n\
             | motion | 4 radii, one step | ten steps | close 5 to 2.5, one step | ten steps | open 5 to 9, one step | ten steps |\n|:--|:-:|:-:|:-:|:-:|:-:|:-:|\n"
        )?;
        for method in &METHODS {
            write!(text, "| {} |", method.name)?;
            for key in ["move", "close", "open"] {
                let run =
                    |steps, way| find(runs, &format!("{key}-{steps}"), curved, method.name, way);
                let (one, ten) = (run(1, Way::Reference), run(10, Way::Incremental));
                write!(text, " {} | {} |", verdict(one), verdict(ten))?;
            }
            text.push('\n');
        }
    }
    text.push_str(
        "\nA curved cell at a sphere is inverted before a straight one: its face keeps its curvature while the cell is compressed. \
         Pictures: the plane through the spheres' centres, cells coloured by quality.\n\n\
         ![1 + tau](ale-move-kanchi-masud.svg)\n![elastic](ale-move-elastic.svg)\n![biharmonic](ale-move-biharmonic.svg)\n",
    );
    Ok(())
}

fn approach(text: &mut String, cases: &[Case], runs: &[Run]) -> Result<()> {
    let title = cases
        .iter()
        .find(|case| case.key == "approach")
        .map_or("", |case| case.title);
    write!(
        text,
        "\n## Approach: {title}\n\nThe smallest gap that was reached, and the quality of the mesh there.\n\n\
         | motion | curved, reference | curved, incremental | straight, reference | straight, incremental |\n|:--|:-:|:-:|:-:|:-:|\n"
    )?;
    for method in &METHODS {
        write!(text, "| {} |", method.name)?;
        for curved in [true, false] {
            for way in Way::ALL {
                let run = find(runs, "approach", curved, method.name, way);
                match run.and_then(|run| run.samples.last()) {
                    Some(s) => write!(text, " {:.3}: {:.3} |", s.label, s.quality)?,
                    None => text.push_str(" none |"),
                }
            }
        }
        text.push('\n');
    }
    text.push_str(
        "\nA valid mesh is not necessarily accurate: cells for a gap of three radii do not resolve the flow in a much smaller gap. The program therefore remeshes \
         when cells become 1.5 times as long as the gap is wide, and before a curved cell is inverted.\n\n\
         ![quality against gap](ale-approach.svg)\n![the smallest gap](ale-approach-kanchi-masud.svg)\n",
    );
    Ok(())
}

fn cycles(text: &mut String, runs: &[Run]) -> Result<()> {
    let all = runs.iter().filter(|run| run.case == "cycles");
    let cycles = all
        .filter_map(|run| run.samples.last())
        .map(|s| s.label)
        .fold(0.0, f64::max);
    write!(
        text,
        "\n## Closed cycles: {cycles:.0} of the stroke, arms 10 and 6, {STEPS_PER_PHASE} steps per phase, curved cells\n\nDrift is the largest distance of a node from its position \
         at the start of the first cycle; from the reference it is zero by construction.\n\n\
         | motion | drift after 1 | after {cycles:.0} | quality after 1 | after {cycles:.0} | reference: smallest quality / Jacobian | preparation, s | reference: s per step | incremental: s per step |\n\
         |:--|--:|--:|--:|--:|--:|--:|--:|--:|\n"
    )?;
    for method in &METHODS {
        let run = |way| find(runs, "cycles", true, method.name, way);
        let (Some(reference), Some(steps)) = (run(Way::Reference), run(Way::Incremental)) else {
            continue;
        };
        let at = |cycle: f64, value: fn(&Sample) -> f64| match steps
            .samples
            .iter()
            .find(|s| s.label == cycle)
        {
            Some(sample) => format!("{:.3}", value(sample)),
            None => format!("inverted at {:.2}", steps.failed_at.unwrap_or(f64::NAN)),
        };
        writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {:.3} | {:.3} | {:.3} |",
            method.name,
            at(1.0, |s| s.displacement),
            at(cycles, |s| s.displacement),
            at(1.0, |s| s.quality),
            at(cycles, |s| s.quality),
            verdict(Some(reference)),
            reference.setup,
            reference.step,
            steps.step,
        )?;
    }
    text.push_str("\n![drift](ale-drift.svg)\n![1 + tau](ale-cycles-kanchi-masud.svg)\n![elastic](ale-cycles-elastic.svg)\n");
    Ok(())
}

fn stroke(text: &mut String, strokes: &[Stroke]) -> Result<()> {
    text.push_str(
        "\n## The default stroke\n\n`scenes/three-sphere.toml` with `fem.mesh_motion` set (the default, `auto`, is `biharmonic` here; [ale-files.md](ale-files.md) has meshes of files): number of meshes, which are generated when the moved one would have a poor quality, \
         and the net displacement.\n\n\
         | fem.mesh_motion | meshes | solves | net displacement | error | bar | seconds for meshes | seconds in total |\n|:--|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for s in strokes {
        writeln!(
            text,
            "| {} | {} | {} | {:.6} | {:.1e} | {:.1e} | {:.1} | {:.1} |",
            s.motion,
            s.meshes,
            s.solves,
            s.net,
            (s.net - STROKES[0].net).abs(),
            s.bar,
            s.mesh_seconds,
            s.seconds
        )?;
    }
    Ok(())
}

fn approach_chart(runs: &[Run]) -> LogLog {
    let chosen = runs
        .iter()
        .filter(|run| run.case == "approach" && !run.curved && run.way == Way::Incremental);
    LogLog {
        title: "Two spheres approach, 15 % of the gap per step, straight cells moved incrementally"
            .into(),
        x: "gap in radii".into(),
        y: "smallest quality".into(),
        series: chosen.map(|run| series(run, |s| s.quality)).collect(),
    }
}

fn drift_chart(runs: &[Run]) -> LogLog {
    let chosen = runs
        .iter()
        .filter(|run| run.case == "cycles" && run.way == Way::Incremental);
    let series = chosen.map(|run| Series {
        points: run
            .samples
            .iter()
            .filter(|s| s.label.fract() == 0.0)
            .map(|s| (s.label, s.displacement))
            .collect(),
        ..series(run, |_| 0.0)
    });
    LogLog {
        title: "Drift of the mesh after closed cycles, moved incrementally".into(),
        x: "cycles".into(),
        y: "largest displacement of a node, in radii".into(),
        series: series.collect(),
    }
}

fn series(run: &Run, value: fn(&Sample) -> f64) -> Series {
    Series {
        name: run.method.to_owned(),
        points: run.samples.iter().map(|s| (s.label, value(s))).collect(),
        style: Style::Curve,
    }
}

fn csv(runs: &[Run]) -> Result<String> {
    let mut text = String::from(
        "case,cells,motion,way,label,quality,jacobian,displacement,complete,setup_seconds,step_seconds\n",
    );
    for run in runs {
        for s in &run.samples {
            writeln!(
                text,
                "{},{},{},{},{:.6},{:.6},{:.6},{:.6},{},{:.4},{:.4}",
                run.case,
                if run.curved { "curved" } else { "straight" },
                run.method.replace(',', ";"),
                run.way.name(),
                s.label,
                s.quality,
                s.jacobian,
                s.displacement,
                run.complete,
                run.setup,
                run.step
            )?;
        }
    }
    Ok(text)
}
