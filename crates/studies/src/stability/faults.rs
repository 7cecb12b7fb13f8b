//! Invalid meshes, and unusual right-hand sides.

use anyhow::{Context, Result};
use linalg::{KrylovParams, WarmStart, fgmres};
use mesh::{LinearTets, TetMesh, Vec3};
use rigid::Constrained;

use super::map::Tried;

/// Tests invalid meshes.
pub fn meshes() -> Result<Vec<Tried>> {
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
    twice.points.push(place);
    let doubled = (twice.points.len() - 1) as u32;
    // Half of the cells around the vertex use its copy: a crack without a tag.
    for tet in twice.tets.iter_mut().step_by(2) {
        tet.iter_mut()
            .filter(|v| **v as usize == vertex_of(&cube(), place))
            .for_each(|v| *v = doubled);
    }
    let mut flat = cube();
    let corner = flat.tets[0];
    flat.points[corner[3] as usize] = flat.points[corner[0] as usize];
    Ok(vec![
        refusal(
            "a cell turned inside out by a vertex",
            moved(inner, place + Vec3::new(0.6, 0.0, 0.0)),
            "inverted",
        ),
        refusal(
            "a curved cell folded by a midside node",
            moved(middle, whole.points()[middle] + Vec3::repeat(0.3)),
            "inverted",
        ),
        refusal(
            "a node at NaN",
            moved(inner, Vec3::repeat(f64::NAN)),
            "finite",
        ),
        refusal(
            "two vertices in one place, a flat cell",
            TetMesh::straight(flat),
            "",
        ),
        refusal(
            "a vertex doubled, a crack without a tag",
            TetMesh::straight(twice),
            "",
        ),
    ])
}

fn vertex_of(tets: &LinearTets, place: Vec3) -> usize {
    tets.points
        .iter()
        .position(|p| *p == place)
        .unwrap_or(usize::MAX)
}

/// Tests right-hand sides and initial guesses that are difficult for Krylov methods.
pub fn rhs_and_guesses(system: &Constrained) -> Result<Vec<Tried>> {
    let params = KrylovParams::default();
    let mut preconditioner = system.preconditioner()?;
    let n = system.rhs.len();
    let mut x = vec![1.0; n];
    let nothing = fgmres(
        &system.system,
        &mut preconditioner,
        &vec![0.0; n],
        &mut x,
        &params,
    )?;
    let mut rows = vec![Tried {
        name: "a right-hand side of zeros, started from ones".into(),
        outcome: format!("right: zeros after {} iterations", nothing.iterations),
        as_expected: nothing.iterations == 0 && x.iter().all(|v| *v == 0.0),
    }];
    let mut x = vec![0.0; n];
    fgmres(
        &system.system,
        &mut preconditioner,
        &system.rhs,
        &mut x,
        &params,
    )?;
    let again = fgmres(
        &system.system,
        &mut preconditioner,
        &system.rhs,
        &mut x.clone(),
        &params,
    )?;
    rows.push(Tried {
        name: "started from the solution".into(),
        outcome: format!("right after {} iterations", again.iterations),
        as_expected: again.iterations == 0,
    });
    // The same shape three times: the remembered solutions are one.
    let mut warm = WarmStart::new(5);
    (0..3).for_each(|_| warm.remember(&x));
    let mut guess = vec![0.0; n];
    let left = warm.guess(&system.system, &system.rhs, &mut guess)?;
    rows.push(Tried {
        name: "a basis of earlier solutions that are all the same".into(),
        outcome: format!("right: dependent ones dropped, residual {left:.0e}"),
        as_expected: left <= 2.0 * params.rel_tol,
    });
    let mut poisoned = system.rhs.clone();
    poisoned[n / 2] = f64::NAN;
    let mut x = vec![0.0; n];
    rows.push(refusal(
        "a NaN in the right-hand side",
        fgmres(
            &system.system,
            &mut preconditioner,
            &poisoned,
            &mut x,
            &params,
        ),
        "NaN",
    ));
    Ok(rows)
}

fn refusal<T, E: std::error::Error>(
    name: &str,
    result: std::result::Result<T, E>,
    part: &str,
) -> Tried {
    match result {
        Ok(_) => Tried {
            name: name.into(),
            outcome: "**accepted**".into(),
            as_expected: false,
        },
        Err(error) => {
            let message = error.to_string();
            Tried {
                name: name.into(),
                as_expected: message.contains(part),
                outcome: format!("*no*: {message}"),
            }
        }
    }
}
