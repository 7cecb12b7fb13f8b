//! Speed and quality of the mesh generator, and the error of the answer on its meshes, compared
//! with those of Gmsh where its command is installed.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result};
use mesh::{MshFile, Quality, TetMesh};
use rayon::ThreadPoolBuilder;
use swimmer::models::FemModel;
use swimmer::solve_start;

use crate::page::Page;
use crate::reference::INSTANTANEOUS;
use crate::scenes::{self, UNIT_RATE};
use crate::table::{Table, count, exp, fixed, missing, optional};
use crate::three_spheres::ThreeSpheres;

/// Number of rounds; the fastest one counts, since other load on the machine can only slow it down.
const ROUNDS: usize = 5;

/// Growth of the edge length with the distance from the spheres, in both programs: that of scenes.
fn growth(size: f64) -> f64 {
    (8.0 / 7.0 * size).min(0.3)
}

/// Names and arguments of the algorithms of Gmsh; only the first one is parallel.
const GMSH: [(&str, &str, usize); 3] = [
    ("Gmsh, HXT", "hxt", 1),
    ("Gmsh, HXT", "hxt", 2),
    ("Gmsh, Delaunay", "del3d", 1),
];

/// One mesh.
struct Row {
    size: f64,
    program: String,
    threads: usize,
    quality: Quality,
    /// From surfaces to the linear tets, and to the checked curved mesh.
    seconds: [Option<f64>; 2],
    /// Degrees of freedom, and relative errors of the speed without and with correction; `None` if
    /// curved cells of the mesh are inverted.
    answer: Option<(usize, [f64; 2])>,
}

/// Generates meshes of all sizes and writes `mesher.md` to `out`.
pub fn run(quick: bool, out: &Path) -> Result<()> {
    let sizes: &[f64] = if quick {
        &[0.4]
    } else {
        &[0.4, 0.2, 0.14, 0.11]
    };
    let mut rows = Vec::new();
    for &size in sizes {
        rows.extend(ours(size)?);
        for (program, algorithm, threads) in GMSH {
            match gmsh(size, program, algorithm, threads) {
                Ok(row) => rows.push(row),
                Err(problem) => eprintln!("{program} at size {size}: {problem:#}"),
            }
        }
    }
    let mut page = Page::new(
        "Speed of the mesh generator",
        "mesher",
        format!(
            "\n\nThree unit spheres with arms of 10 in a ball of radius 40; edges of the given size on the spheres, growing by 8/7 of it, at most 0.3, per unit of distance. Thousand tets per second, from\n\
             surfaces to tets, and to the checked curved mesh; the fastest of {ROUNDS} rounds. The times of Gmsh are its own, for curves, surfaces and volume, without start and files.\n\
             Angles in degrees. The error is that of the velocity of the middle sphere while one arm closes, relative to the exact value, without and with the correction by cubic elements\n\
             (-: some curved cells are inverted)."
        ),
    );
    page.table(table(&rows));
    page.write(out, "mesher")
}

/// Relative errors of the velocity of the middle sphere when the left arm closes.
fn answer(file: &str, overrides: &[String]) -> Result<(usize, [f64; 2])> {
    let overrides = [overrides, &[UNIT_RATE.to_owned()]].concat();
    let scene = scenes::read(file, &overrides)?;
    let solved = solve_start(&scene, &mut FemModel::new(&scene)?)?;
    let exact = INSTANTANEOUS[0].centre_velocity;
    let errors = [&solved.uncorrected(), &solved]
        .map(|solution| (solution.bodies[1].velocity.x / exact - 1.0).abs());
    Ok((solved.dofs.total, errors))
}

fn ours(size: f64) -> Result<Vec<Row>> {
    let three = ThreeSpheres::new([10.0; 2], 40.0);
    let overrides = [
        format!("fem.surface_size={size}"),
        "fem.symmetry=off".to_owned(),
    ];
    let answer = answer("three-sphere.toml", &overrides)?;
    let row = |threads: usize| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
        let mut seconds = [f64::INFINITY; 2];
        let mut quality = None;
        for _ in 0..ROUNDS {
            let clock = Instant::now();
            let tets = pool.install(|| three.tets(size, growth(size)))?;
            let generated = clock.elapsed().as_secs_f64();
            let mesh: TetMesh = pool.install(|| three.curved(tets))?;
            let checked = clock.elapsed().as_secs_f64();
            seconds = [seconds[0].min(generated), seconds[1].min(checked)];
            quality = Some(mesh.quality());
        }
        Ok(Row {
            size,
            program: "this project".to_owned(),
            threads,
            quality: quality.context("no round")?,
            seconds: seconds.map(Some),
            answer: Some(answer),
        })
    };
    [1, 2].into_iter().map(row).collect()
}

/// A mesh by the command `gmsh`; the time is that of meshing, without start and writing.
fn gmsh(size: f64, program: &str, algorithm: &str, threads: usize) -> Result<Row> {
    let folder = std::env::temp_dir().join(format!("microswim-gmsh-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let row = gmsh_in(&folder, size, program, algorithm, threads);
    std::fs::remove_dir_all(&folder)?;
    row
}

fn gmsh_in(
    folder: &Path,
    size: f64,
    program: &str,
    algorithm: &str,
    threads: usize,
) -> Result<Row> {
    let file = folder.join("three-sphere.msh");
    let geometry = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/three-sphere.geo");
    let mut seconds = f64::INFINITY;
    for _ in 0..ROUNDS {
        let output = Command::new("gmsh")
            .args(["-3", "-algo", algorithm, "-nt", &threads.to_string()])
            .args(["-setnumber", "size", &size.to_string()])
            .args(["-setnumber", "growth", &growth(size).to_string()])
            .args(["-setnumber", "largest", "20"])
            .arg("-o")
            .args([&file, &geometry])
            .output()
            .context("the command gmsh could not be started")?;
        let log = String::from_utf8_lossy(&output.stdout).into_owned();
        let own = seconds_of_meshing(&log).context("no times in the output of gmsh")?;
        seconds = seconds.min(own);
    }
    let mesh = MshFile::read(&file)?.into_mesh(&[])?;
    let overrides = [format!("domain.file={:?}", file.display().to_string())];
    let answer = answer("three-sphere-mesh.toml", &overrides)
        .inspect_err(|problem| eprintln!("{program} at size {size}: {problem:#}"));
    Ok(Row {
        size,
        program: program.to_owned(),
        threads,
        quality: mesh.quality(),
        seconds: [Some(seconds), None],
        answer: answer.ok(),
    })
}

/// Sum of the wall times of meshing curves, surfaces and volumes in the output of Gmsh.
///
/// The lines are `Info    : Done meshing 3D (Wall 0.800965s, CPU 0.095094s)`.
fn seconds_of_meshing(log: &str) -> Option<f64> {
    let times: Vec<f64> = log
        .lines()
        .filter(|line| line.contains("Done meshing"))
        .filter_map(|line| line.split("Wall ").nth(1)?.split('s').next()?.parse().ok())
        .collect();
    (times.len() == 3).then(|| times.iter().sum())
}

fn table(rows: &[Row]) -> Table {
    let mut table = Table::new([
        "size",
        "program",
        "threads",
        "tets",
        "1000 tets/s",
        "checked",
        "angles",
        "mean ratio",
        "dofs",
        "error",
        "corrected",
    ]);
    for row in rows {
        let quality = &row.quality;
        let rate = |seconds: f64| fixed(1e-3 * quality.cells as f64 / seconds, 0);
        let [generated, checked] = row.seconds.map(|seconds| optional(seconds, rate));
        let (least, most) = (quality.min_dihedral, quality.max_dihedral);
        let error = |which: usize| optional(row.answer, |answer| exp(answer.1[which], 1));
        table.push([
            row.size.to_string().into(),
            row.program.as_str().into(),
            count(row.threads),
            count(quality.cells),
            generated,
            checked,
            format!("{least:.1} to {most:.1}").into(),
            fixed(quality.mean_quality, 3),
            row.answer.map_or_else(missing, |answer| count(answer.0)),
            error(0),
            error(1),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::seconds_of_meshing;

    #[test]
    fn wall_times_of_gmsh_are_summed() {
        let log = "Info    : Done meshing 1D (Wall 0.25s, CPU 0.1s)\n\
                   Info    : Done meshing 2D (Wall 0.5s, CPU 0.1s)\n\
                   Info    : Done meshing 3D (Wall 1.25s, CPU 0.1s)\n";
        assert_eq!(seconds_of_meshing(log), Some(2.0));
        assert_eq!(seconds_of_meshing("Error : no surface"), None);
    }
}
