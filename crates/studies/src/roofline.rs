//! Bandwidth of every kernel of the block solver, as a fraction of the memory bandwidth.
//!
//! The memory bandwidth is measured as in STREAM (McCalpin 1995), before every run of a kernel: on
//! a shared machine both see the same load, and no kernel finds its data in a cache. The best
//! bandwidth of the whole run is used, so fractions are rather too low than too high.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use linalg::{
    BlockTriangular, CyclePart, LevelSize, LinearOperator, MassInverse, OrthonormalBasis,
    Preconditioner, SaddleSystem,
};
use mesher::Container;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use rigid::{Arms, Articulation, BodyKind, Constrained, Drive, Eliminated, ExternalLoad, Joint};
use stokes::Problem;

use crate::page::{self, Page};
use crate::table::{Table, count, fixed, optional, percent};
use crate::three_spheres::{NAMES, ThreeSpheres};

/// Length of each array of STREAM: 256 MB, far more than any cache.
const STREAM: usize = 1 << 25;

/// Length of the pieces into which arrays of STREAM are cut for the threads.
const CHUNK: usize = 1 << 14;

/// Number of runs; the fastest counts, since other load on the machine can only slow a kernel down.
const RUNS: usize = 12;

/// Element sizes on the spheres: about 100 000, 500 000 and 970 000 dofs.
const SIZES: [f64; 3] = [0.4, 0.19, 0.14];

/// Basis vectors in the measured Gram-Schmidt step: the mean over a solve of about twenty
/// iterations.
const BASIS: usize = 10;

/// Chebyshev steps on the pressure mass matrix in the preconditioner.
const MASS_STEPS: usize = 3;

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

/// Measures all kernels and writes `roofline.md` and `roofline.csv` to `out`.
pub fn run(quick: bool, out: &Path) -> Result<()> {
    let sizes = if quick { &SIZES[..1] } else { &SIZES[..] };
    let mut rows = Vec::new();
    for &size in sizes {
        let system = three_spheres(size)?;
        for threads in [1, rayon::current_num_threads()] {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
            pool.install(|| measure(&system, threads, &mut rows))?;
        }
    }
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let text = format!(
        "The start of `scenes/three-sphere.toml`; average load of the machine over the last minute: {}.\n\n\
         The fastest of {RUNS} runs of each kernel, with data in memory, not in caches. STREAM is the best bandwidth of reading 256 MB, measured before every run. Other load on \
         the machine lowers both. The last column is the kernel's share of the time of an iteration, from its time and the number of its runs.",
        load.split(' ').next().unwrap_or("unknown")
    );
    let mut page = Page::new("Kernels against the bandwidth of memory", "roofline", text);
    let table = table(&rows);
    page::write(out, "roofline.csv", &table.csv())?;
    page.table(table);
    page.write(out, "roofline")
}

fn measure(system: &Constrained, threads: usize, rows: &mut Vec<Row>) -> Result<()> {
    let mut preconditioner = system.preconditioner()?;
    let stream = Stream(vec![1.0; STREAM]);
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
    let mut triad = || stream.triad(&mut c);
    row("STREAM: triad", 24 * STREAM, 0.0, &mut triad);
    drop(c);
    visit_kernels(&system.system, &mut preconditioner, &mut row)?;
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
struct Stream(Vec<f64>);

impl Stream {
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
        black_box(self.0.par_chunks(CHUNK).map(sum).sum::<f64>());
    }

    /// `c = a + s b`.
    fn triad(&self, c: &mut [f64]) {
        let s = black_box(3.0);
        c.par_chunks_mut(CHUNK)
            .zip(self.0.par_chunks(CHUNK))
            .zip(self.0.par_chunks(CHUNK).rev())
            .for_each(|((c, a), b)| {
                for ((c, a), b) in c.iter_mut().zip(a).zip(b) {
                    *c = a + s * b;
                }
            });
    }
}

/// Receives the name of a kernel, the bytes that it must read or write once (a cache line that is
/// overwritten counts once, as in STREAM), its runs per iteration (zero for sums of other kernels),
/// and a function that runs it.
type Measure<'a> = dyn FnMut(&str, usize, f64, &mut dyn FnMut()) + 'a;

/// Passes every kernel of an iteration of FGMRES to `measure`.
///
/// The ratio of bytes to time should equal the memory bandwidth: nothing else should limit a
/// kernel.
fn visit_kernels(
    system: &SaddleSystem,
    preconditioner: &mut BlockTriangular,
    measure: &mut Measure,
) -> Result<()> {
    let dofs = system.rows();
    let x: Vec<f64> = (0..dofs).map(|i| (i as f64).sin()).collect();
    let mut y = vec![0.0; dofs];
    let a = system.velocity_block();
    let (nodes, vertices) = (a.nodes(), system.pressure_range().len());
    let stiffness = a.stiffness().nnz() * 12 + nodes * 8;
    // the matrix and its transpose have the same nonzeros, and one row pointer per row
    let entries = system.divergence().nnz() * 28;
    let (divergence, gradient) = (entries + vertices * 8, entries + nodes * 8);
    let vectors = 24 * nodes + 8 * vertices;
    let (u, v) = (&x[system.velocity_range()], &x[system.border_range()]);
    let p = &x[system.pressure_range()];
    let bytes = stiffness + 48 * nodes;
    measure("K, three components, f64", bytes, 1.0, &mut || {
        a.apply(&x[..a.cols()], &mut y[..a.rows()]);
    });
    measure("B, f64", divergence + vectors, 1.0, &mut || {
        system.apply_divergence(u, v, &mut y[..vertices]);
    });
    measure("B^T, f64", gradient + vectors, 2.0, &mut || {
        system.apply_gradient(p, &mut y[..3 * nodes]);
    });
    visit_cycle(preconditioner, measure);
    let mut mass = MassInverse::new(system.pressure_mass(), MASS_STEPS)?;
    let pass = 12 * system.pressure_mass().nnz() + (8 + 4 * 8) * vertices;
    let mass_bytes = (MASS_STEPS - 1) * pass + 24 * vertices;
    let (r, mut z) = (vec![1.0; vertices], vec![0.0; vertices]);
    let name = "mass matrix, three steps, f64";
    measure(name, mass_bytes, 1.0, &mut || mass.apply(&r, &mut z));
    visit_orthogonalisation(dofs, system.residual_weights(), measure);
    measure("y + alpha x", 24 * dofs, 0.0, &mut || add(1e-9, &x, &mut y));
    let whole = stiffness + divergence + gradient + 16 * dofs;
    let mut apply = || system.apply(&x, &mut y);
    measure("whole operator", whole, 0.0, &mut apply);
    let levels = preconditioner.velocity().level_sizes();
    let finest = levels.first().map_or(0, |finest| 2 * 40 * finest.nodes);
    let cycle = cycle_bytes(levels) + finest;
    let whole = cycle + mass_bytes + gradient + 16 * dofs;
    measure("whole preconditioner", whole, 0.0, &mut || {
        preconditioner.apply(&x, &mut y);
    });
    Ok(())
}

/// Bytes of one smoothing step: the matrix, three vectors, the diagonal.
fn smoothing_bytes(level: &LevelSize) -> usize {
    8 * level.nnz + level.nodes * (8 + 48 + 4)
}

/// Bytes of a residual and its restriction to the next level.
fn restriction_bytes(level: &LevelSize, coarse: &LevelSize) -> usize {
    let residual = 8 * level.nnz + level.nodes * (8 + 48);
    residual + 8 * level.prolongation_nnz + 16 * level.nodes + 24 * coarse.nodes
}

/// Bytes of a prolongation from the next level.
fn prolongation_bytes(level: &LevelSize, coarse: &LevelSize) -> usize {
    8 * level.prolongation_nnz + level.nodes * (8 + 32) + 16 * coarse.nodes
}

/// Bytes of a cycle on levels, without its input and output.
fn cycle_bytes(levels: &[LevelSize]) -> usize {
    let pairs = levels.windows(2).map(|pair| (&pair[0], &pair[1]));
    let bytes = pairs.map(|(level, coarse)| {
        (2 * level.sweeps - 1) * smoothing_bytes(level)
            + restriction_bytes(level, coarse)
            + prolongation_bytes(level, coarse)
    });
    bytes.sum()
}

/// The parts of the V-cycle.
fn visit_cycle(preconditioner: &mut BlockTriangular, measure: &mut Measure) {
    let levels = preconditioner.velocity().level_sizes().to_vec();
    let [fine, coarse, ..] = &levels[..] else {
        return;
    };
    let smoothing_steps = (2 * fine.sweeps - 1) as f64;
    let [smoothing, coarser] = [smoothing_bytes(fine), cycle_bytes(&levels[1..])];
    let restriction = restriction_bytes(fine, coarse);
    let prolongation = prolongation_bytes(fine, coarse);
    use CyclePart::{CoarserLevels, Prolongation, Restriction, SmoothingStep};
    let mut run = |part, name, bytes, runs| {
        measure(name, bytes, runs, &mut || {
            preconditioner.velocity_mut().run_part(part);
        });
    };
    run(
        SmoothingStep,
        "smoothing step, f32",
        smoothing,
        smoothing_steps,
    );
    run(
        Restriction,
        "residual and its restriction, f32",
        restriction,
        1.0,
    );
    run(Prolongation, "prolongation, f32", prolongation, 1.0);
    run(CoarserLevels, "coarser levels, f32", coarser, 1.0);
}

/// The orthogonalisation of a vector of length `n` against [`BASIS`] others.
///
/// For a solve to 1e-8 a third of the vectors is stored in f64, the others in f32.
fn visit_orthogonalisation(n: usize, weights: Option<&[f32]>, measure: &mut Measure) {
    let mut w: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();
    let mut h = vec![0.0; BASIS];
    for (single, name, share) in [
        (false, "Gram-Schmidt against ten, f64", 1.0 / 3.0),
        (true, "Gram-Schmidt against ten, f32", 2.0 / 3.0),
    ] {
        let mut basis = OrthonormalBasis::new(weights);
        for j in 0..BASIS {
            // nearly orthogonal to the measured vector, so that one round is enough
            let sparse: Vec<f64> = (0..n).map(|i| f64::from(i % BASIS == j)).collect();
            basis.store(j, &sparse, n as f64, single);
        }
        let vectors = BASIS * if single { 4 } else { 8 };
        let bytes = 2 * n * (vectors + 4) + 24 * n;
        measure(name, bytes, share, &mut || {
            basis.orthogonalise(BASIS, &mut w, &mut h);
        });
    }
}

/// `y <- y + alpha x`.
fn add(alpha: f64, x: &[f64], y: &mut [f64]) {
    let pairs = y.par_chunks_mut(CHUNK).zip(x.par_chunks(CHUNK));
    pairs.for_each(|(y, x)| y.iter_mut().zip(x).for_each(|(y, x)| *y += alpha * x));
}

/// System of the three-sphere scene at its start, with elements of `size` on the spheres.
fn three_spheres(size: f64) -> Result<Constrained> {
    let three = ThreeSpheres::new([10.0; 2], 40.0);
    let centres = three.spheres.map(|sphere| sphere.centre);
    let growth = swimmer::models::FemModel::default_growth(size);
    let mesh = three.curved(three.tets(size, growth)?)?;
    let parts: Vec<_> = NAMES.into_iter().zip(centres).collect();
    let problem = Problem::new(&mesh, &parts, &[Container::TAG])?;
    let joints = [0, 2]
        .map(|body| Joint::slide(NAMES[body], body, 1))
        .to_vec();
    let set = Articulation::new(&[BodyKind::Rigid; 3], joints, Arms::Clamped, &centres)?;
    let constraints = set.constraints(&set.initial_state(), set.initial_shape(), &[-1.0, 0.0])?;
    let drive = Drive {
        set: &set,
        constraints: &constraints,
        loads: &[ExternalLoad::default(); 3],
    };
    Ok(problem.assemble(&drive, &Eliminated)?)
}

fn table(rows: &[Row]) -> Table {
    const HEADINGS: &str = "dofs,threads,kernel,MB,ms,GB/s,STREAM GB/s,fraction,share of iteration";
    let mut table = Table::new(HEADINGS.split(','));
    for row in rows {
        let same = |other: &&Row| (other.dofs, other.threads) == (row.dofs, row.threads);
        let others = rows.iter().filter(same);
        let iteration: f64 = others.map(|other| other.runs * other.seconds).sum();
        let part = row.runs * row.seconds / iteration;
        let bytes = row.bytes as f64;
        table.push([
            count(row.dofs),
            count(row.threads),
            row.name.as_str().into(),
            fixed(bytes / 1e6, 1),
            fixed(1e3 * row.seconds, 2),
            fixed(bytes / row.seconds / 1e9, 1),
            fixed(row.stream / 1e9, 1),
            percent(bytes / row.seconds / row.stream),
            optional((row.runs > 0.0).then_some(part), percent),
        ]);
    }
    table
}
