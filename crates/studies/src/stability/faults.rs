//! Invalid meshes, and unusual right-hand sides.

use anyhow::{Context, Result};
use linalg::{KrylovParams, WarmStart, fgmres};
use mesh::{LinearTets, TetMesh, Vec3};
use rigid::Constrained;

use super::map::Row;

/// Tests invalid meshes.
pub fn meshes() -> Result<Vec<Row>> {
    let cube = || LinearTets::cube(2);
    let whole = TetMesh::straight(cube())?;
    let inner = (0..whole.n_vertices())
        .find(|&v| {
            whole
                .facets()
                .iter()
                .all(|f| !f.nodes.contains(&(v as u32)))
        })
        .context("the cube has no vertex inside")?;
    let middle = whole.cells()[0][4] as usize;
    let moved = |node: usize, to: Vec3| {
        let mut points = whole.points().to_vec();
        points[node] = to;
        whole.with_points(points)
    };
    let place = whole.points()[inner];
    let mut twice = cube();
    let vertex = twice.points.iter().position(|p| *p == place);
    twice.points.push(place);
    let doubled = (twice.points.len() - 1) as u32;
    // Half of the cells around the vertex use its copy: a crack without a tag.
    for tet in twice.tets.iter_mut().step_by(2) {
        tet.iter_mut()
            .filter(|v| Some(**v as usize) == vertex)
            .for_each(|v| *v = doubled);
    }
    let mut flat = cube();
    let corner = flat.tets[0];
    flat.points[corner[3] as usize] = flat.points[corner[0] as usize];
    let center = whole.points()[middle];
    Ok([
        (
            "a cell turned inside out by a vertex",
            moved(inner, place + Vec3::new(0.6, 0.0, 0.0)),
            "inverted",
        ),
        (
            "a curved cell folded by a midside node",
            moved(middle, center + Vec3::repeat(0.3)),
            "inverted",
        ),
        (
            "a node at NaN",
            moved(inner, Vec3::repeat(f64::NAN)),
            "finite",
        ),
        (
            "two vertices in one place, a flat cell",
            TetMesh::straight(flat),
            "",
        ),
        (
            "a vertex doubled, a crack without a tag",
            TetMesh::straight(twice),
            "",
        ),
    ]
    .map(|(name, result, part)| Row::refusal(name, result, part))
    .to_vec())
}

/// Tests right-hand sides and initial guesses that are difficult for Krylov methods.
pub fn rhs_and_guesses(system: &Constrained) -> Result<Vec<Row>> {
    let params = KrylovParams::default();
    let mut preconditioner = system.preconditioner()?;
    let mut solve =
        |b: &[f64], x: &mut [f64]| fgmres(&system.system, &mut preconditioner, b, x, &params);
    let n = system.rhs.len();
    let mut x = vec![1.0; n];
    let nothing = solve(&vec![0.0; n], &mut x)?.iterations;
    let mut rows = vec![Row::test(
        "a right-hand side of zeros, started from ones",
        format!("right: zeros after {nothing} iterations"),
        nothing == 0 && x.iter().all(|v| *v == 0.0),
    )];
    let mut x = vec![0.0; n];
    solve(&system.rhs, &mut x)?;
    let again = solve(&system.rhs, &mut x.clone())?.iterations;
    let outcome = format!("right after {again} iterations");
    rows.push(Row::test("started from the solution", outcome, again == 0));
    // The same shape three times: the remembered solutions are one.
    let mut warm = WarmStart::new(5);
    (0..3).for_each(|_| warm.remember(&x));
    let mut guess = vec![0.0; n];
    let left = warm.guess(&system.system, &system.rhs, &mut guess)?;
    rows.push(Row::test(
        "a basis of earlier solutions that are all the same",
        format!("right: dependent ones dropped, residual {left:.0e}"),
        left <= 2.0 * params.rel_tol,
    ));
    let mut poisoned = system.rhs.clone();
    poisoned[n / 2] = f64::NAN;
    let refused = solve(&poisoned, &mut vec![0.0; n]);
    rows.push(Row::refusal("a NaN in the right-hand side", refused, "NaN"));
    Ok(rows)
}
