//! The study on mesh files as Markdown.

use std::fmt::Write;

use anyhow::Result;

use super::file_cases::FileMesh;
use super::file_study::Reach;
use crate::machine;

/// One table per mesh.
pub fn markdown(meshes: &[(FileMesh, Vec<Reach>)]) -> Result<String> {
    let mut text = format!(
        "# Mesh motions on the meshes of files\n\n{}, {}. Made by `cargo xtask ale --files FOLDER` on meshes of Gmsh \
         (`scenes/three-sphere.geo`; size, growth and largest size: *coarse* about 0.65, 0.3, 8; *fast* 0.4, 0.6, 12; *middle* 0.4, 0.25, 6; *fine* 0.25, 0.2, 5; \
         *near* 0.3, 0.3, 8 with arms of 4; *close* 0.25, 0.3, 8 with arms of 3; some with -optimize_netgen).\n\n\
         Three spheres of radius 1 on a line, cells curved at the spheres, extensions computed once on the mesh of the file. \
         *Cycle*: the arms close by four tenths one after the other and open again (from 10 to 6: the default stroke); the smallest quality \
         and Jacobian and the largest gap ratio. *Accepted*: the program uses all meshes of this cycle / of the same cycle after the swimmer has moved by \
         3.2 radii, the distance of twenty default strokes. The last columns say how far the program follows until a cell is too poor or too long for its gap: \
         smallest gap when both arms close / the left one only; distance by which both open / the left sphere moves sideways (at most 6).\n",
        machine::today(),
        machine::processor(),
    );
    for (file, rows) in meshes {
        let [left, right] = file.arms();
        writeln!(
            text,
            "\n## {}: arms {left:.0} and {right:.0}, {} vertices\n\n\
             | motion | cycle: quality / Jacobian / gap ratio | accepted | gap, both / left | opens / sideways | iterations | seconds |\n\
             |:--|:-:|:-:|:-:|:-:|--:|--:|",
            file.name,
            file.mesh.n_vertices(),
        )?;
        for row in rows {
            let yes = |accepted: bool| if accepted { "yes" } else { "no" };
            let gap = |gap: Option<f64>| gap.map_or("-".to_owned(), |gap| format!("{gap:.2}"));
            let cycle = row.stroke.map_or("inverted".to_owned(), |s| {
                format!("{:.3} / {:.2} / {:.2}", s.quality, s.jacobian, s.gap_ratio)
            });
            writeln!(
                text,
                "| {} | {cycle} | {} / {} | {} / {} | {:.1} / {:.1} | {} | {:.2} |",
                row.method,
                yes(row.accepted[0]),
                yes(row.accepted[1]),
                gap(row.gaps[0]),
                gap(row.gaps[1]),
                row.distances[0],
                row.distances[1],
                row.iterations,
                row.setup,
            )?;
        }
    }
    let returns = (meshes.iter()).all(|(_, rows)| rows.iter().all(|row| row.returns));
    writeln!(
        text,
        "\nAfter all motions the mesh of the initial configuration is that of the file, bit for bit: {}.",
        if returns { "always" } else { "NOT always" }
    )?;
    Ok(text)
}
