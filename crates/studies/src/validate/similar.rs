//! Orders of convergence: a sphere in a concentric ball on similar meshes, by `stokes::Problem`.
//!
//! In scenes the growth rate of elements is limited, so coarse meshes are not similar to fine ones.
//! Orders of convergence are measured on similar meshes, so here all sizes are proportional.

use std::f64::consts::PI;
use std::time::Instant;

use anyhow::{Context, Result};
use fem::SurplusSpace;
use mesh::{NamedSurface, Surface, TetMesh};
use mesher::{Container, GenerateParams, MeshedBody, generate};
use nalgebra::{DVector, Vector3};
use rigid::{Arms, Articulation, BodyKind, Drive, ExternalLoad, Independent};
use stokes::{InitialGuesses, Options, Problem};

use super::row::{Basis, Cost, Row};
use crate::reference::{concentric_drag, concentric_torque};

/// Number of parts of an edge of the icosahedron on the sphere, for each mesh of the family.
const FAMILY: [u32; 3] = [3, 4, 6];

/// Edge length of the icosahedron with corners on the sphere.
///
/// The geodesic spheres of the mesh generator have fractions of it as element sizes.
const ICOSAHEDRON_EDGE: f64 = 1.2045910058552547;

/// Growth rate of the elements over their size on the sphere: 0.3, the default, at size 0.4.
const GROWTH_OVER_SIZE: f64 = 0.75;

/// Radius ratio for the orders of convergence.
///
/// The ball is wide enough that the surfaces hardly interact, and narrow enough for fine meshes.
const LAMBDA: f64 = 0.25;

/// Observed orders of drag and torque over three similar meshes, curved and straight-sided, before
/// the correction; on curved meshes also those of the answer.
pub fn orders(_: bool) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (geometry, is_curved, kinds) in [
        (
            "curved",
            true,
            &[("uncorrected", 4.0, 0.7), ("corrected", 5.0, 1.0)][..],
        ),
        ("straight", false, &[("uncorrected", 2.0, 0.5)]),
    ] {
        let mut cost = Cost::default();
        let mut points = Vec::new();
        for parts in FAMILY {
            let (errors, own) = errors(LAMBDA, parts, is_curved)?;
            points.push((f64::from(parts).ln(), errors));
            cost.add(&own);
        }
        for (kind, &(name, theory, allowed)) in kinds.iter().enumerate() {
            for (which, value) in ["drag", "torque"].into_iter().enumerate() {
                let logarithms = points.iter().map(|(x, e)| (*x, e[kind][which].abs().ln()));
                let name = format!("{value}, {geometry}, {name}, lambda {LAMBDA}");
                let values = [theory, -slope(logarithms)];
                let tolerance = (allowed, Basis::Order);
                rows.push(Row::scaled("order", name, values, 1.0, tolerance, cost));
            }
        }
    }
    Ok(rows)
}

/// Slope of the least-squares line through points.
fn slope(points: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let n = points.clone().count() as f64;
    let (x, y) = points
        .clone()
        .fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let (above, below) = points.fold((0.0, 0.0), |(a, b), (px, py)| {
        (a + (px - x) * (py - y), b + (px - x) * (px - x))
    });
    above / below
}

/// Relative errors of drag and torque, without and with the correction, of the unit sphere at the
/// centre of a ball of radius `1 / lambda`.
fn errors(lambda: f64, parts: u32, is_curved: bool) -> Result<([[f64; 2]; 2], Cost)> {
    let clock = Instant::now();
    let mesh = ball_in_ball(lambda, ICOSAHEDRON_EDGE / f64::from(parts), is_curved)?;
    let (body, wall) = (sphere(1.0), sphere(1.0 / lambda));
    let surfaces: [NamedSurface; 2] = [("sphere", &body), (Container::TAG, &wall)];
    let problem = Problem::new(&mesh, &[("sphere", Vector3::zeros())], &[Container::TAG])?
        .with_surfaces(&surfaces)?;
    let kinds = [BodyKind::Rigid];
    let set = Articulation::new(&kinds, vec![], Arms::Clamped, &[Vector3::zeros()])?;
    let drive = Drive {
        set: &set,
        constraints: &set.constraints(&set.initial_state(), &[], &[])?,
        loads: &[ExternalLoad {
            force: Vector3::x(),
            torque: Vector3::z(),
        }],
    };
    let options = Options::default().with_formulation(&Independent);
    let (mut guesses, space) = (InitialGuesses::new(0), SurplusSpace::new(&mesh)?);
    let solutions = problem.solve_all(&[drive], &options, &mut guesses, Some(&space))?;
    let solution = solutions.first().context("one drive has one solution")?;
    let estimate = solution.estimate.as_ref();
    let estimate = estimate.context("the error was not estimated")?;
    let motion = &solution.flow.bodies;
    // Loads are the inverse of the motion under unit force and torque.
    let errors = |motion: &DVector<f64>| {
        [
            1.0 / motion[0] / (6.0 * PI * concentric_drag(lambda)) - 1.0,
            1.0 / motion[5] / (8.0 * PI * concentric_torque(lambda)) - 1.0,
        ]
    };
    let cost = Cost {
        dofs: solution.dofs.total,
        iterations: solution.solver.iterations,
        seconds: clock.elapsed().as_secs_f64(),
    };
    let corrected = errors(&(motion + &estimate.change.bodies));
    Ok(([errors(motion), corrected], cost))
}

fn sphere(radius: f64) -> mesher::Sphere {
    mesher::Sphere {
        centre: Vector3::zeros(),
        radius,
    }
}

fn ball_in_ball(lambda: f64, size: f64, is_curved: bool) -> Result<TetMesh> {
    let container = Container::Ball(sphere(1.0 / lambda));
    let sphere = sphere(1.0);
    let body = MeshedBody {
        name: "sphere",
        surface: &sphere,
        size,
    };
    let mut params = GenerateParams::default();
    params.growth = GROWTH_OVER_SIZE * size;
    let tets = generate(&[body], &container, &params)?.mesh;
    let surfaces: [(&str, &dyn Surface); 2] =
        [("sphere", &sphere), (Container::TAG, container.surface())];
    Ok(match is_curved {
        true => TetMesh::curved(tets, &surfaces)?,
        false => TetMesh::straight(tets)?,
    })
}
