//! Drag, resistance of a pair and swimming speed, by all methods.

use std::f64::consts::PI;
use std::time::Instant;

use anyhow::Result;
use swimmer::choose;
use swimmer::models::InstantaneousSolution;
use swimmer::{Scene, solve_start};

use super::parameters::{MESHES, axisymmetric_overrides, mesh_overrides, sizes, targets};
use super::quantity::{Point, Quantity};
use crate::reference::{INSTANTANEOUS, concentric_drag};
use crate::scene_files;

/// Point of a value at the start of a scene.
fn instant(
    scene: &Scene,
    [method, choice]: [&str; 2],
    exact: f64,
    value: impl Fn(&InstantaneousSolution) -> f64,
) -> Result<Point> {
    let clock = Instant::now();
    let mut model = choose(scene)?.model;
    let solved = solve_start(scene, model.as_mut())?;
    let error = |solution: &InstantaneousSolution| (value(solution) / exact - 1.0).abs();
    Ok(Point {
        method: method.to_owned(),
        choice: choice.to_owned(),
        size: None,
        dofs: solved.dofs.total,
        seconds: clock.elapsed().as_secs_f64(),
        error: error(&solved),
        uncorrected: (solved.mesh_error.as_ref()).map(|_| error(&solved.uncorrected())),
        // All quantities belong to the body in the middle.
        bar: (solved.error_estimate.total() > 0.0).then(|| {
            let body = &solved.bodies[solved.bodies.len() / 2];
            solved.error_estimate.total() / body.velocity.norm()
        }),
    })
}

/// Points for all element sizes, with curved and straight elements, with and without symmetry
/// planes.
fn by_size(
    quick: bool,
    base: &dyn Fn(&[String]) -> Result<Scene>,
    exact: f64,
    value: impl Fn(&InstantaneousSolution) -> f64 + Copy,
) -> Result<Vec<Point>> {
    let mut points = Vec::new();
    for [method, geometry, symmetry] in MESHES {
        for &size in sizes(quick) {
            let scene = base(&mesh_overrides(geometry, symmetry, size))?;
            let names = [method, &format!("size {size}")];
            points.push(Point {
                size: Some(size),
                ..instant(&scene, names, exact, value)?
            });
        }
    }
    Ok(points)
}

/// Points for meshes that are adapted to a target error.
fn adapted(
    targets: &[f64],
    base: &dyn Fn(&[String]) -> Result<Scene>,
    exact: f64,
    value: impl Fn(&InstantaneousSolution) -> f64 + Copy,
) -> Result<Vec<Point>> {
    targets
        .iter()
        .map(|target| {
            let scene = base(&[format!("fem.target={target:e}")])?;
            let choice = format!("target {target:e}");
            instant(
                &scene,
                ["finite elements, curved, adapted", &choice],
                exact,
                value,
            )
        })
        .collect()
}

/// Points for axisymmetric elements with several tolerances.
fn meridian(
    base: &dyn Fn(&[String]) -> Result<Scene>,
    exact: f64,
    value: impl Fn(&InstantaneousSolution) -> f64 + Copy,
) -> Result<Vec<Point>> {
    [1e-2, 1e-4, 1e-6]
        .map(|tolerance| {
            let scene = base(&axisymmetric_overrides(tolerance))?;
            let choice = format!("tolerance {tolerance:e}");
            instant(&scene, ["axisymmetric elements", &choice], exact, value)
        })
        .into_iter()
        .collect()
}

/// Drag of a sphere in a ball.
pub fn drag(quick: bool) -> Result<Quantity> {
    // A sphere with a force in a ball of ten radii: force over velocity.
    let exact = concentric_drag(0.1) * 6.0 * PI;
    let value =
        |solved: &InstantaneousSolution| solved.bodies[0].force.x / solved.bodies[0].velocity.x;
    let base = |more: &[String]| -> Result<Scene> {
        let mut overrides = vec!["domain.radius=10".to_owned()];
        overrides.extend_from_slice(more);
        scene_files::read("sphere-in-ball.toml", &overrides)
    };
    let mut points = by_size(quick, &base, exact, value)?;
    points.extend(adapted(targets(quick), &base, exact, value)?);
    points.extend(meridian(&base, exact, value)?);
    Ok(Quantity {
        key: "drag",
        title: format!("drag of a sphere in a ball of ten radii, exactly {exact:.6}"),
        points,
    })
}

/// Resistance of two spheres that approach each other.
pub fn pair(quick: bool) -> Result<Quantity> {
    // Two spheres pushed towards each other with a gap of half a radius: Stimson & Jeffery 1926.
    // The forces add up to zero, so the wall at 800 radii changes the speed by less than
    // `(2.5 / 800)^3`.
    let exact = 2.772418679559134 * 6.0 * PI;
    let value = |solved: &InstantaneousSolution| {
        let [front, back] = [0, 1].map(|body| solved.bodies[body]);
        (front.force.x - back.force.x) / (front.velocity.x - back.velocity.x)
    };
    let base = |more: &[String]| -> Result<Scene> {
        let mut overrides = ["front", "back"]
            .into_iter()
            .zip([1.25, -1.25])
            .flat_map(|(name, x)| {
                [
                    format!("bodies.{name}.position=[{x}, 0, 0]"),
                    format!("bodies.{name}.force=[{}, 0, 0]", -f64::signum(x)),
                ]
            })
            .chain(["domain.radius=800".to_owned()])
            .collect::<Vec<_>>();
        overrides.extend_from_slice(more);
        scene_files::read("two-spheres.toml", &overrides)
    };
    let mut points = by_size(quick, &base, exact, value)?;
    points.extend(adapted(targets(quick), &base, exact, value)?);
    points.extend(meridian(&base, exact, value)?);
    Ok(Quantity {
        key: "pair",
        title: format!(
            "resistance of two spheres half a radius apart, pushed together, exactly {exact:.6} to 3e-8"
        ),
        points,
    })
}

/// Swimming speed of three spheres.
pub fn speed(quick: bool) -> Result<Quantity> {
    let case = &INSTANTANEOUS[0];
    let value = |solved: &InstantaneousSolution| solved.bodies[1].velocity.x;
    let base = |more: &[String]| -> Result<Scene> {
        let overrides = scene_files::with_unit_rate(more);
        scene_files::read("three-sphere.toml", &overrides)
    };
    let mut points = by_size(quick, &base, case.centre_velocity, value)?;
    points.extend(meridian(&base, case.centre_velocity, value)?);
    for formulation in ["lagrange", "direct-row"] {
        let scene = base(&[format!("fem.formulation={formulation}")])?;
        let names = [&format!("curved, {formulation}")[..], "size 0.4"];
        points.push(instant(&scene, names, case.centre_velocity, value)?);
    }
    for rtol in [1e-3, 1e-5] {
        let scene = base(&[format!("fem.rtol={rtol:e}")])?;
        let names = [
            "curved, larger tolerance of the solver",
            &format!("size 0.4, rtol {rtol:e}"),
        ];
        points.push(instant(&scene, names, case.centre_velocity, value)?);
    }
    Ok(Quantity {
        key: "speed",
        title: format!(
            "velocity of the three-sphere swimmer's centre in a ball of radius 40, exactly {:.9}",
            case.centre_velocity
        ),
        points,
    })
}
