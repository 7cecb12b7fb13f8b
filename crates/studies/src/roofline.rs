//! Bandwidth of every kernel of the block solver, as a fraction of the memory bandwidth.
//!
//! The memory bandwidth is measured as in STREAM (McCalpin 1995), before every run of a kernel: on
//! a shared machine both see the same load, and no kernel finds its data in a cache. The best
//! bandwidth of the whole run is used, so fractions are rather too low than too high.

use std::fmt::Write;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use linalg::roofline::visit_kernels;
use mesh::{NamedSurface, TetMesh};
use mesher::{Container, GenerateParams, MeshedBody, Sphere};
use nalgebra::Vector3;
use rayon::prelude::*;
use rigid::{Arms, Articulation, BodyKind, Constrained, Drive, Eliminated, ExternalLoad, Joint};
use stokes::Problem;

use crate::{folder, machine};

/// Length of each array of STREAM: 256 MB, far more than any cache.
const STREAM: usize = 1 << 25;

/// Length of the pieces into which arrays of STREAM are cut for the threads.
const CHUNK: usize = 1 << 14;

/// Number of runs; the fastest counts, since other load on the machine can only slow a kernel down.
const RUNS: usize = 12;

/// Element sizes on the spheres: about 100 000, 500 000 and 970 000 dofs.
const SIZES: [f64; 3] = [0.4, 0.19, 0.14];

const NAMES: [&str; 3] = ["left", "centre", "right"];

/// One line of the table.
struct Row {
    dofs: usize,
    threads: usize,
    name: String,
    bytes: usize,
    runs: f64,
    seconds: f64,
    /// Best bandwidth of reading with this number of threads, in bytes per second.
    stream: f64,
}

impl Row {
    fn fraction(&self) -> f64 {
        self.bytes as f64 / self.seconds / self.stream
    }
}

/// Measures all kernels and writes `roofline.md` and `roofline.csv` to `out`.
pub fn run(quick: bool, out: &Path) -> Result<()> {
    let sizes = if quick { &SIZES[..1] } else { &SIZES[..] };
    let mut rows = Vec::new();
    for &size in sizes {
        let system = three_spheres(size)?;
        for threads in [1, rayon::current_num_threads()] {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()?;
            pool.install(|| measure(&system, threads, &mut rows))?;
        }
    }
    let text = markdown(&rows)?;
    println!("{text}");
    folder::write(out, [("roofline.md", text), ("roofline.csv", csv(&rows)?)])
}

fn measure(system: &Constrained, threads: usize, rows: &mut Vec<Row>) -> Result<()> {
    let mut preconditioner = system.preconditioner()?;
    let stream = Stream::new();
    let first = rows.len();
    let mut row = |name: &str, bytes, runs, run: &mut dyn FnMut()| {
        let (seconds, reading) = stream.compare(run);
        rows.push(Row {
            dofs: system.rhs.len(),
            threads,
            name: name.into(),
            bytes,
            runs,
            seconds,
            stream: 8.0 * STREAM as f64 / reading,
        });
    };
    row("STREAM: sum", 8 * STREAM, 0.0, &mut || stream.sum());
    let mut c = vec![0.0; STREAM];
    row("STREAM: triad", 24 * STREAM, 0.0, &mut || {
        stream.triad(&mut c)
    });
    drop(c);
    visit_kernels(&system.system, &mut preconditioner, &mut |kernel, run| {
        row(kernel.name, kernel.bytes, kernel.runs, run);
    });
    let rows = &mut rows[first..];
    let best = rows.iter().map(|row| row.stream).fold(0.0, f64::max);
    rows.iter_mut().for_each(|row| row.stream = best);
    Ok(())
}

fn seconds(run: impl FnOnce()) -> f64 {
    let clock = Instant::now();
    run();
    clock.elapsed().as_secs_f64()
}

/// Array that is read and written at the bandwidth of memory.
struct Stream {
    x: Vec<f64>,
}

impl Stream {
    fn new() -> Self {
        Stream {
            x: vec![1.0; STREAM],
        }
    }

    /// Seconds of `run` and of a sum over the array, alternating, each the fastest of [`RUNS`].
    fn compare(&self, run: &mut dyn FnMut()) -> (f64, f64) {
        (0..RUNS).fold((f64::INFINITY, f64::INFINITY), |(kernel, sum), _| {
            // The sum comes first, because it evicts the kernel's data from the caches.
            let sum = sum.min(seconds(|| self.sum()));
            (kernel.min(seconds(&mut *run)), sum)
        })
    }

    fn sum(&self) {
        let sum = |chunk: &[f64]| {
            let mut lanes = [0.0; 16];
            for values in chunk.as_chunks::<16>().0 {
                for lane in 0..16 {
                    lanes[lane] += values[lane];
                }
            }
            lanes.iter().sum::<f64>()
        };
        black_box(self.x.par_chunks(CHUNK).map(sum).sum::<f64>());
    }

    /// `c = a + s b`.
    fn triad(&self, c: &mut [f64]) {
        let s = black_box(3.0);
        c.par_chunks_mut(CHUNK)
            .zip(self.x.par_chunks(CHUNK))
            .zip(self.x.par_chunks(CHUNK).rev())
            .for_each(|((c, a), b)| {
                for ((c, a), b) in c.iter_mut().zip(a).zip(b) {
                    *c = a + s * b;
                }
            });
    }
}

/// System of the three-sphere scene at its start, with elements of `size` on the spheres.
fn three_spheres(size: f64) -> Result<Constrained> {
    let centres = [-10.0, 0.0, 10.0].map(|x| Vector3::new(x, 0.0, 0.0));
    let spheres = centres.map(|centre| Sphere {
        centre,
        radius: 1.0,
    });
    let container = Container::Ball(Sphere {
        centre: Vector3::zeros(),
        radius: 40.0,
    });
    let bodies: Vec<MeshedBody> = NAMES
        .iter()
        .zip(&spheres)
        .map(|(name, surface)| MeshedBody {
            name,
            surface,
            size,
        })
        .collect();
    let mut parameters = GenerateParams::default();
    parameters.growth = swimmer::models::FemModel::default_growth(size);
    let tets = mesher::generate(&bodies, &container, &parameters)?.mesh;
    let surfaces: Vec<NamedSurface> = bodies
        .iter()
        .map(|b| (b.name, b.surface))
        .chain([(Container::TAG, container.surface())])
        .collect();
    let mesh = TetMesh::curved(tets, &surfaces)?;
    let parts: Vec<_> = NAMES.into_iter().zip(centres).collect();
    let problem = Problem::new(&mesh, &parts, &[Container::TAG])?;
    let joint = |body: usize| Joint::slide(NAMES[body], body, 1);
    let set = Articulation::new(
        &[BodyKind::Rigid; 3],
        vec![joint(0), joint(2)],
        Arms::Clamped,
        &centres,
    )?;
    let constraints = set.constraints(&set.initial_state(), set.initial_shape(), &[-1.0, 0.0])?;
    let drive = Drive {
        set: &set,
        constraints: &constraints,
        loads: &[ExternalLoad::default(); 3],
    };
    Ok(problem.assemble(&drive, &Eliminated)?)
}

fn markdown(rows: &[Row]) -> Result<String> {
    let mut text = format!(
        "# Kernels against the bandwidth of memory\n\n\
         The start of `scenes/three-sphere.toml`. {}, {}, load {}. Made by `cargo xtask roofline`.\n\n\
         The fastest of {RUNS} runs of each kernel, with data in memory, not in caches. STREAM is the best bandwidth of reading 256 MB, measured before every run. Other load on \
         the machine lowers both. The last column is the kernel's share of the time of an iteration, from its time and the number of its runs.\n\n",
        machine::today(),
        machine::processor(),
        load(),
    );
    text.push_str("| dofs | threads | kernel | MB | ms | GB/s | STREAM GB/s | fraction | share of iteration |\n");
    text.push_str("|--:|--:|:--|--:|--:|--:|--:|--:|--:|\n");
    for row in rows {
        let iteration: f64 = rows
            .iter()
            .filter(|other| other.dofs == row.dofs && other.threads == row.threads)
            .map(|other| other.runs * other.seconds)
            .sum();
        let part = match row.runs {
            0.0 => "-".to_owned(),
            runs => format!("{:.0} %", 100.0 * runs * row.seconds / iteration),
        };
        writeln!(
            text,
            "| {} | {} | {} | {:.1} | {:.2} | {:.1} | {:.1} | {:.0} % | {part} |",
            row.dofs,
            row.threads,
            row.name,
            row.bytes as f64 / 1e6,
            1e3 * row.seconds,
            row.bytes as f64 / row.seconds / 1e9,
            row.stream / 1e9,
            100.0 * row.fraction(),
        )?;
    }
    Ok(text)
}

fn csv(rows: &[Row]) -> Result<String> {
    let mut text =
        "dofs,threads,kernel,bytes,seconds,stream_bytes_per_second,fraction,runs_per_iteration\n"
            .to_owned();
    for row in rows {
        writeln!(
            text,
            "{},{},\"{}\",{},{:e},{:e},{:.4},{:.3}",
            row.dofs,
            row.threads,
            row.name,
            row.bytes,
            row.seconds,
            row.stream,
            row.fraction(),
            row.runs
        )?;
    }
    Ok(text)
}

/// Average load of the machine over the last minute.
fn load() -> String {
    std::fs::read_to_string("/proc/loadavg")
        .ok()
        .and_then(|text| Some(text.split_whitespace().next()?.to_owned()))
        .unwrap_or_else(|| "unknown".to_owned())
}
