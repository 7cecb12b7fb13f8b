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
const SIZES: [f64; 3] = [0.4, 0.2, 0.085];

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
    /// Iterations per decimal digit that linear solves gain: Stokes flow, largest of the steps.
    per_digit: [f64; 2],
}

/// Measures the iterations and writes `newton.md` and `newton.csv` to `out`.
pub fn run(quick: bool, out: &Path) -> Result<()> {
    let text = "A sphere of radius 1 that moves with speed 1 in the middle of a ball of radius 10, solved \
        to 1e-8 from nothing; a quarter of the fluid is meshed. The shear number is that of the speed, the \
        radius and the relaxation time, power laws are regularised at a shear rate of 1e-3. Newton's \
        method solves each linear system as accurately as its convergence needs, so that its iterations \
        are compared with those of Stokes flow by decimal digit of the residual.";
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
        "steps",
        "ratio",
    ];
    let mut table = Table::new(headings);
    for row in rows(quick)? {
        let steps: Vec<String> = row.steps.iter().map(usize::to_string).collect();
        let all = row.first + row.steps.iter().sum::<usize>();
        let [stokes, law] = row.per_digit;
        table.push([
            row.law.into(),
            fixed(row.size, 3),
            count(row.dofs),
            count(row.stokes),
            count(row.first),
            steps.join(" ").as_str().into(),
            count(all),
            fixed(stokes, 1),
            fixed(law, 1),
            fixed(law / stokes, 2),
        ]);
    }
    page::write(out, "newton.csv", &table.csv())?;
    page.table(table);
    page.write(out, "newton")
}

fn rows(quick: bool) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for &size in if quick { &SIZES[..1] } else { &SIZES[..] } {
        let mesh = sphere_mesh("ball", size)?;
        rows.extend(on_mesh(&mesh, size).with_context(|| format!("size {size}"))?);
    }
    Ok(rows)
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
    let stokes = problem.solve(&drive, &options)?;
    let digits = |residual: f64| -residual.log10();
    let per_digit = |iterations: usize, residual: f64| iterations as f64 / digits(residual);
    let of_stokes = per_digit(
        stokes.solver.iterations,
        stokes.solver.true_relative_residual,
    );
    let row = |(name, law): (&'static str, Law)| {
        let mut guesses = InitialGuesses::new(0);
        let found = problem.solve_generalised_newtonian(&drive, &law, &options, &mut guesses, None);
        let newton = found.with_context(|| name)?.newton;
        let of_steps = newton.steps.iter();
        let largest = of_steps.map(|step| per_digit(step.iterations, step.linear_residual));
        Ok(Row {
            law: name,
            size,
            dofs: stokes.dofs.total,
            stokes: stokes.solver.iterations,
            first: newton.first_iterations,
            steps: newton.steps.iter().map(|step| step.iterations).collect(),
            per_digit: [of_stokes, largest.fold(0.0, f64::max)],
        })
    };
    laws().into_iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_solves_of_newton_steps_take_as_many_iterations_as_the_table_says() {
        for row in rows(true).unwrap() {
            let [stokes, law] = row.per_digit;
            println!(
                "{}: {} + {:?}, {stokes:.1} {law:.1}",
                row.law, row.first, row.steps
            );
            // docs/newton.md has 3 to 4 steps and up to 2.2 times the iterations per digit; the
            // steep power law takes 11 steps
            let most = if row.law == "power law 0.3" { 14 } else { 6 };
            assert!(row.steps.len() <= most, "{}: {:?}", row.law, row.steps);
            assert!(law < 3.0 * stokes, "{}: {law} {stokes}", row.law);
        }
    }
}
