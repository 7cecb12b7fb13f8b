//! Iterations of Newton's method and of its linear solves for fluids with a viscosity law.

use std::path::Path;

use anyhow::{Context, Result};
use axisymmetric::rheology::Law;
use mesh::{TetMesh, Vec3};
use mesher::Container;
use rigid::{Arms, Articulation, BodyKind, Drive, ExternalLoad, Twist};
use stokes::{InitialGuesses, Options, Problem};

use crate::oseen::{BODIES, sphere_mesh};
use crate::page::{self, Page};
use crate::table::{Table, count, fixed};

/// Element sizes on the sphere.
const SIZES: [f64; 4] = [0.4, 0.2, 0.085, 0.022];

/// The laws and their names.
fn laws() -> [(&'static str, Law); 5] {
    let carreau = |index: f64, relaxation_time: f64| Law::Carreau {
        zero_shear_viscosity: 1.0,
        infinite_shear_viscosity: 0.0,
        relaxation_time,
        index,
    };
    let power_law = |index: f64| Law::PowerLaw {
        consistency: 1.0,
        index,
        regularisation: 1e-3,
    };
    [
        ("Carreau 0.5, shear number 1", carreau(0.5, 1.0)),
        ("Carreau 0.5, shear number 10", carreau(0.5, 10.0)),
        ("Carreau 0.3, shear number 10", carreau(0.3, 10.0)),
        ("power law 0.5", power_law(0.5)),
        ("power law 0.3", power_law(0.3)),
    ]
}

/// One line of the table.
struct Row {
    law: &'static str,
    size: f64,
    dofs: usize,
    /// Iterations of Stokes flow, of the first flow, and of each Newton step.
    stokes: usize,
    first: usize,
    steps: Vec<usize>,
    /// Iterations per decimal digit that linear solves gain: Stokes flow, largest and mean of the
    /// steps.
    per_digit: [f64; 3],
    /// Largest ratio of the iterations of a step to those of Stokes flow to the same residual.
    same_residual: f64,
    /// Processor seconds of the Stokes flow and of the flow with the law, estimates not included.
    seconds: [f64; 2],
}

/// Measures the iterations and writes `newton.md` and `newton.csv` to `out`, after each mesh.
pub fn run(quick: bool, out: &Path) -> Result<()> {
    let mut rows = Vec::new();
    for &size in if quick { &SIZES[..1] } else { &SIZES[..] } {
        rows.extend(rows_of(size)?);
        write(&rows, out)?;
    }
    Ok(())
}

fn write(rows: &[Row], out: &Path) -> Result<()> {
    let text = "A sphere of radius 1 that moves with speed 1 in the middle of a ball of radius 10, solved \
        to 1e-8 from nothing; a quarter of the fluid is meshed. The shear number is that of the speed, the \
        radius and the relaxation time, power laws are regularised at a shear rate of 1e-3. Newton's \
        method solves each linear system as accurately as its convergence needs. So its iterations are \
        compared with those of Stokes flow in two ways: per decimal digit of the residual, for the \
        step with the most and for all steps, where Stokes flow is solved to 1e-8 and one digit of a \
        short solve takes more than one of a long one; and for the step with the largest ratio with \
        those of Stokes flow solved to the same residual. The last column is the processor time of \
        the whole solve over that of the Stokes flow, both with their assembly, in one run.";
    let mut page = Page::new("Iterations for fluids with a viscosity law", "newton", text);
    let headings = [
        "law",
        "size",
        "dofs",
        "Stokes",
        "first flow",
        "each step",
        "all",
        "per digit: Stokes",
        "worst step",
        "all steps",
        "over Stokes to the same residual",
        "time over Stokes",
    ];
    let mut table = Table::new(headings);
    for row in rows {
        let steps: Vec<String> = row.steps.iter().map(usize::to_string).collect();
        let all = row.first + row.steps.iter().sum::<usize>();
        let [stokes, worst, all_steps] = row.per_digit;
        table.push([
            row.law.into(),
            fixed(row.size, 3),
            count(row.dofs),
            count(row.stokes),
            count(row.first),
            steps.join(" ").as_str().into(),
            count(all),
            fixed(stokes, 1),
            fixed(worst, 1),
            fixed(all_steps, 1),
            fixed(row.same_residual, 2),
            fixed(row.seconds[1] / row.seconds[0], 1),
        ]);
    }
    page::write(out, "newton.csv", &table.csv())?;
    page.table(table);
    page.write(out, "newton")
}

fn rows_of(size: f64) -> Result<Vec<Row>> {
    let mesh = sphere_mesh("ball", size)?;
    on_mesh(&mesh, size).with_context(|| format!("size {size}"))
}

fn on_mesh(mesh: &TetMesh, size: f64) -> Result<Vec<Row>> {
    let set = Articulation::new(&[BodyKind::Rigid], vec![], Arms::Clamped, &[Vec3::zeros()])?;
    let set = set.with_held(&[0], &[0])?;
    let twist = Twist {
        linear: Vec3::z(),
        angular: Vec3::zeros(),
    };
    let constraints = set.constraints(&set.initial_state(), &[], &[])?;
    let drive = Drive {
        set: &set,
        constraints: &constraints.with_held_velocity(0, twist)?,
        loads: &[ExternalLoad::default()],
    };
    let problem = Problem::new(mesh, &BODIES, &[Container::TAG])?;
    let options = Options::default();
    let (stokes, of_stokes) = timed(|| Ok(problem.solve(&drive, &options)?))?;
    let mut same_residual = Vec::new();
    for digits in 1..=8 {
        let rtol = 10.0_f64.powi(-digits);
        let solved = problem.solve(&drive, &options.with_rtol(rtol))?.solver;
        same_residual.push((solved.true_relative_residual, solved.iterations));
    }
    let digits = |residual: f64| -residual.log10();
    let row = |(name, law): (&'static str, Law)| {
        let mut guesses = InitialGuesses::new(0);
        let solve = || {
            Ok(problem.solve_generalised_newtonian(&drive, &law, &options, &mut guesses, None)?)
        };
        let (found, of_law) = timed(solve).with_context(|| name)?;
        let newton = found.newton;
        let (mut worst, mut over_stokes, mut sums) = (0.0_f64, 0.0_f64, [0.0; 2]);
        for step in &newton.steps {
            let (iterations, gained) = (step.iterations as f64, digits(step.linear_residual));
            worst = worst.max(iterations / gained);
            sums = [sums[0] + iterations, sums[1] + gained];
            // on the line through the residuals of Stokes flow
            let reached = interpolated(&same_residual, gained);
            over_stokes = over_stokes.max(iterations / reached);
        }
        let solver = &stokes.solver;
        Ok(Row {
            law: name,
            size,
            dofs: stokes.dofs.total,
            stokes: solver.iterations,
            first: newton.first_iterations,
            steps: newton.steps.iter().map(|step| step.iterations).collect(),
            per_digit: [
                solver.iterations as f64 / digits(solver.true_relative_residual),
                worst,
                sums[0] / sums[1],
            ],
            same_residual: over_stokes,
            seconds: [of_stokes, of_law],
        })
    };
    laws().into_iter().map(row).collect()
}

/// Iterations that gain this number of digits, by those that reached some residuals.
fn interpolated(solved: &[(f64, usize)], gained: f64) -> f64 {
    let points = std::iter::once((1.0, 0)).chain(solved.iter().copied());
    let points: Vec<[f64; 2]> = points
        .map(|(residual, iterations)| [-residual.log10(), iterations as f64])
        .collect();
    let after = points.partition_point(|point| point[0] < gained);
    let [from, to] = [
        points[after.clamp(1, points.len() - 1) - 1],
        points[after.clamp(1, points.len() - 1)],
    ];
    from[1] + (gained - from[0]) / (to[0] - from[0]) * (to[1] - from[1])
}

/// A result, and the processor seconds that it took, of all threads.
fn timed<T>(compute: impl FnOnce() -> Result<T>) -> Result<(T, f64)> {
    let before = processor_seconds()?;
    let result = compute()?;
    Ok((result, processor_seconds()? - before))
}

/// Processor seconds of this process, to a hundredth.
fn processor_seconds() -> Result<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").context("processor time needs Linux")?;
    // Fields 14 and 15; the second one is a name in parentheses. Ticks are hundredths of a second
    // on all architectures (proc(5), sysconf(3)).
    let fields = stat
        .rsplit(')')
        .next()
        .unwrap_or_default()
        .split_whitespace();
    let ticks = fields.skip(11).take(2).map(str::parse::<f64>);
    Ok(ticks.sum::<Result<f64, _>>()? / 100.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_solves_of_newton_steps_take_as_many_iterations_as_the_table_says() {
        for row in rows_of(SIZES[0]).unwrap() {
            let [stokes, law, _] = row.per_digit;
            println!(
                "{}: {} + {:?}, {stokes:.1} {law:.1}",
                row.law, row.first, row.steps
            );
            // docs/newton.md has the same numbers of up to 5 steps
            assert!(row.steps.len() <= 6, "{}: {:?}", row.law, row.steps);
            assert!(law < 2.5 * stokes, "{}: {law} {stokes}", row.law);
        }
    }
}
