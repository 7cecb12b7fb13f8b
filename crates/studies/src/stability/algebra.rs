//! Stress cases that cannot be described by a scene, for the linear systems of a scene.

use std::collections::BTreeMap;

use anyhow::{Result, ensure};
use linalg::{
    BorderPlacement, Bordered, Csr, Csr3, Identity, KrylovParams, LinalgError, LinearOperator,
    Multigrid, MultigridParams, Preconditioner, SaddleSystem, Schwarz, SchwarzParams, cg, fgmres,
    minres,
};
use nalgebra::DMatrix;
use rigid::{Constrained, DirectRows, Eliminated, Formulation, Lagrange};
use swimmer::models::{Configuration, FemModel};

use super::faults;
use super::inf_sup::InfSup;
use super::map::{Map, Outcome, Row};
use super::stress_cases::Setup;

/// Smallest inf-sup constant of an accepted pair of spaces.
///
/// P2-P1 has 0.4 to 0.5, equal orders 0.08 on coarse meshes and less on fine ones.
const MIN_INF_SUP: f64 = 0.1;

/// The map.
pub fn map() -> Result<Map> {
    let eliminated = system(&Eliminated)?;
    let lagrange = system(&Lagrange)?;
    let direct_rows = system(&DirectRows)?;
    let mut rows = vec![
        quadratic(&eliminated)?,
        equal_order(&eliminated)?,
        separated_multipliers(&lagrange),
        exact_velocities(&eliminated)?,
    ];
    let saddle = solved(&eliminated, |a, b, x, params| {
        cg(a, &mut Identity(b.len()), b, x, params).map(drop)
    });
    let asymmetric = solved(&direct_rows, |a, b, x, params| {
        minres(a, &mut Identity(b.len()), b, x, params).map(drop)
    });
    let schwarz = Schwarz::new(&eliminated.system, &cut(2, BorderPlacement::Eliminated));
    let with_schwarz = schwarz.and_then(|mut schwarz| {
        solved(&eliminated, |a, b, x, params| {
            minres(a, &mut schwarz, b, x, params).map(drop)
        })
    });
    let poisoned = scaled(&eliminated.system, f64::NAN).map(drop);
    for (name, result, part) in [
        (
            "conjugate gradients on the saddle-point system",
            saddle,
            "definite",
        ),
        ("MINRES on direct rows", asymmetric, "symmetric"),
        (
            "MINRES with additive Schwarz, which is not symmetric",
            with_schwarz,
            "PositiveDefinite",
        ),
        ("a NaN in the stiffness", poisoned, "NaN"),
    ] {
        rows.push(Row::refusal(name, result, part));
    }
    rows.extend([1e-9, 1e9].map(|viscosity| viscous_matrices(&eliminated, viscosity)));
    rows.push(no_preconditioner(&eliminated));
    rows.extend(faults::rhs_and_guesses(&eliminated)?);
    rows.extend(faults::meshes()?);
    Ok(Map {
        key: "algebra",
        title: "Algebra",
        note: "Stress cases that cannot be described by a scene, for the systems of the bent chain.",
        columns: vec!["outcome".to_owned()],
        rows,
    })
}

/// The block solver with an exact solve of the velocity block in the place of the V-cycle, which
/// must need fewer iterations, but not fewer than half.
fn exact_velocities(system: &Constrained) -> Result<Row> {
    let exact = Multigrid::new(system.system.velocity_block(), &MultigridParams::direct())?;
    let with_cycle = iterations(system, &mut system.preconditioner()?)?;
    let with_exact = iterations(system, &mut system.preconditioner_with(exact)?)?;
    Ok(Row::test(
        "exact velocity solves instead of V-cycles",
        format!("right after {with_exact} instead of {with_cycle} iterations"),
        with_exact <= with_cycle && with_cycle <= 2 * with_exact,
    ))
}

/// The system of the bent chain on a mesh small enough for dense eigenproblems.
fn system(formulation: &dyn Formulation) -> Result<Constrained> {
    let mut setup = Setup::bent_chain();
    setup.size = Some(1.5);
    let scene = setup.scene(formulation.name(), "block")?;
    let mut model = FemModel::new(&scene)?;
    let state = scene.initial_state();
    let configuration = Configuration::new(&state, scene.articulation().initial_shape());
    Ok(model.system(configuration, &[-0.5, 0.0], formulation)?)
}

fn quadratic(system: &Constrained) -> Result<Row> {
    let measured = InfSup::new(&system.system)?;
    // The constant pressure of enclosed flow, and the bound of the full gradient.
    let is_stable = measured.require(MIN_INF_SUP).is_ok()
        && measured.null_space_dimension <= 1
        && measured.largest <= 1.0 + 1e-6;
    let constant = format!("{:.3}", measured.constant);
    Ok(Row::test("inf-sup constant of P2-P1", constant, is_stable))
}

fn equal_order(system: &Constrained) -> Result<Row> {
    let nodes = system.prolongation.nodes();
    let linear = SaddleSystem::new(
        Bordered::scalar(system.vertex_stiffness.clone())?,
        vector_product(system.system.divergence(), nodes),
        Csr::zero((system.system.pressure_range().len(), 0)),
        None,
        system.system.pressure_mass().clone(),
    )?;
    Ok(Row::refusal(
        "P1 velocities with P1 pressures",
        InfSup::new(&linear)?.require(MIN_INF_SUP),
        "inf-sup constant",
    ))
}

/// Product `B I` of a matrix `B` of 3-vectors with an interpolation `I`.
fn vector_product(b: &Csr3, interpolation: &Csr) -> Csr3 {
    let (mut pointers, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
    for row in b.outer_iterator() {
        let mut sums: BTreeMap<u32, [f64; 3]> = BTreeMap::new();
        for (j, entry) in row.iter() {
            let Some(weights) = interpolation.outer_view(j) else {
                continue;
            };
            for (vertex, &weight) in weights.iter() {
                let sum = sums.entry(vertex as u32).or_default();
                (0..3).for_each(|axis| sum[axis] += weight * entry[axis]);
            }
        }
        for (vertex, sum) in sums {
            indices.push(vertex);
            values.push(sum);
        }
        pointers.push(indices.len());
    }
    Csr3::new((b.rows(), interpolation.cols()), pointers, indices, values)
}

/// Schwarz with multipliers in another subdomain than the bodies that they constrain.
///
/// This is the case "gasm + LU fails on Lagrange multipliers" of the paper.
fn separated_multipliers(lagrange: &Constrained) -> Row {
    let m = lagrange.system.border_range().len();
    // Velocities of the bodies come first; the second subdomain gets all multipliers.
    let velocities = 6 * 3 + 3;
    let placement = (0..m).map(|c| usize::from(c >= velocities)).collect();
    Row::refusal(
        "Schwarz on Lagrange, multipliers cut off from their bodies (the paper's failure of gasm+LU)",
        Schwarz::new(
            &lagrange.system,
            &cut(2, BorderPlacement::Assigned(placement)),
        )
        .map(drop),
        "border dof",
    )
}

fn cut(subdomains: usize, border: BorderPlacement) -> SchwarzParams {
    SchwarzParams::default()
        .with_subdomains(subdomains)
        .with_border(border)
}

fn no_preconditioner(system: &Constrained) -> Row {
    let found = iterations(system, &mut Identity(system.rhs.len()));
    let refused = found.map_err(|error| format!("{error:#}"));
    Row::refusal("FGMRES without preconditioner", refused, "FGMRES reached")
}

/// Iterations of a solve whose residual is computed again.
///
/// # Errors
/// No convergence, or convergence that was reported although the residual is too large.
fn iterations(system: &Constrained, preconditioner: &mut dyn Preconditioner) -> Result<usize> {
    let b = &system.rhs;
    let mut x = vec![0.0; b.len()];
    let params = KrylovParams::default();
    let report = fgmres(&system.system, preconditioner, b, &mut x, &params)?;
    let mut product = vec![0.0; b.len()];
    system.system.apply(&x, &mut product);
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|e| e * e).sum::<f64>().sqrt();
    let residual =
        norm(&mut b.iter().zip(&product).map(|(b, p)| b - p)) / norm(&mut b.iter().copied());
    // The residual in the report differs from this one by rounding errors.
    ensure!(
        residual <= 1.001 * params.rel_tol,
        "convergence was reported, but the residual is {residual:e}"
    );
    Ok(report.iterations)
}

fn solved(
    system: &Constrained,
    method: impl FnOnce(&SaddleSystem, &[f64], &mut [f64], &KrylovParams) -> Result<(), LinalgError>,
) -> Result<(), LinalgError> {
    let mut x = vec![0.0; system.rhs.len()];
    let params = KrylovParams::default();
    method(&system.system, &system.rhs, &mut x, &params)
}

/// Solves with the viscosity in the matrices instead of viscosity 1 in scaled units.
///
/// The velocities of a swimmer must not change, or the solver must fail with a reason.
fn viscous_matrices(plain: &Constrained, viscosity: f64) -> Row {
    let momentum = plain.system.border_range().end;
    let mut b = plain.rhs.clone();
    b[..momentum].iter_mut().for_each(|load| *load *= viscosity);
    let solve = |system: &SaddleSystem, b: &[f64]| {
        let mut x = vec![0.0; b.len()];
        let mut schwarz = Schwarz::new(system, &cut(4, BorderPlacement::Eliminated))?;
        fgmres(system, &mut schwarz, b, &mut x, &KrylovParams::default())?;
        Ok::<_, LinalgError>(x)
    };
    let compared = scaled(&plain.system, viscosity)
        .and_then(|system| Ok((solve(&plain.system, &plain.rhs)?, solve(&system, &b)?)));
    let name = format!("viscosity {viscosity:e} in the matrices instead of in the units");
    match compared {
        Err(error) => Row::one(name, Outcome::Refused(error.to_string()), true),
        Ok((exact, found)) => {
            let exact = &exact[..momentum];
            let largest = exact.iter().fold(0.0, |m: f64, e| m.max(e.abs()));
            let pairs = exact.iter().zip(&found);
            let error = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest;
            // Residuals of 1e-8 on both sides, as in the cells of the map.
            Row::test(name, format!("{error:.0e}"), error < 1e-5)
        }
    }
}

/// The same system with the viscosity in its matrices, in unscaled units.
fn scaled(system: &SaddleSystem, viscosity: f64) -> Result<SaddleSystem, LinalgError> {
    let a = system.velocity_block();
    let times = |matrix: &Csr| matrix.map(|value| value * viscosity);
    let corner: DMatrix<f64> = a.corner() * viscosity;
    SaddleSystem::new(
        Bordered::new(times(a.stiffness()), times(a.border()), None, corner)?,
        system.divergence().clone(),
        system.border_divergence().clone(),
        None,
        system.pressure_mass().map(|value| value / viscosity),
    )
}
