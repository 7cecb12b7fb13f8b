//! What is computed, in which ways.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::time::Instant as Clock;

use anyhow::{Context, Result, bail};
use swimmer::choose;
use swimmer::models::InstantaneousSolution;
use swimmer::{Scene, solve_start};

use super::{Point, Quantity, strokes};
use crate::validate::reference::{INSTANTANEOUS, concentric_drag};

/// Element sizes on the spheres.
pub(super) fn sizes(quick: bool) -> &'static [f64] {
    if quick {
        &[0.8, 0.5]
    } else {
        &[0.8, 0.6, 0.5, 0.4, 0.3, 0.2, 0.15]
    }
}

/// Errors asked of adapted meshes.
pub(super) fn targets(quick: bool) -> &'static [f64] {
    if quick {
        &[1e-2]
    } else {
        &[1e-2, 3e-3, 1e-3, 3e-4, 1e-4]
    }
}

type Compute = fn(bool) -> Result<Quantity>;

const QUANTITIES: [(&str, Compute); 4] = [
    ("drag", drag),
    ("pair", pair),
    ("speed", speed),
    ("net", strokes::net),
];

/// All quantities, or the one of a key.
pub fn all(quick: bool, only: Option<&str>) -> Result<Vec<Quantity>> {
    if let Some(key) = only
        && !QUANTITIES.iter().any(|(name, _)| *name == key)
    {
        bail!("there is no quantity '{key}'; choose drag, pair, speed or net");
    }
    QUANTITIES
        .iter()
        .filter(|(name, _)| only.is_none_or(|key| key == *name))
        .map(|(_, compute)| compute(quick))
        .collect()
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../scenes")
        .join(name)
}

pub(super) fn scene(name: &str, overrides: &[String]) -> Result<Scene> {
    Scene::read(&file(name), overrides).with_context(|| format!("scene {name}"))
}

/// Solves the start of a scene and measures a value of it.
fn instant(
    scene: &Scene,
    [method, choice]: [&str; 2],
    exact: f64,
    value: impl Fn(&InstantaneousSolution) -> f64,
) -> Result<Point> {
    let clock = Clock::now();
    let mut model = choose(scene)?.model;
    let solved = solve_start(scene, model.as_mut())?;
    Ok(Point {
        method: method.to_owned(),
        choice: choice.to_owned(),
        dofs: solved.dofs.total,
        seconds: clock.elapsed().as_secs_f64(),
        error: (value(&solved) / exact - 1.0).abs(),
        // Quantities are those of the body in the middle.
        claimed: (solved.error_estimate.total() > 0.0).then(|| {
            let body = &solved.bodies[solved.bodies.len() / 2];
            solved.error_estimate.total() / body.velocity.norm()
        }),
    })
}

/// Ways to mesh, by name, geometry and mirror planes.
pub(super) const MESHES: [[&str; 3]; 3] = [
    ["finite elements, curved", "curved", "auto"],
    ["all of the fluid, curved", "curved", "off"],
    ["all of the fluid, straight", "straight", "off"],
];

/// Elements of all sizes, curved and straight, with and without the mirror planes that these scenes have.
fn by_size(
    quick: bool,
    base: &dyn Fn(&[String]) -> Result<Scene>,
    exact: f64,
    value: impl Fn(&InstantaneousSolution) -> f64 + Copy,
) -> Result<Vec<Point>> {
    let mut points = Vec::new();
    for [method, geometry, mirror] in MESHES {
        for &size in sizes(quick) {
            let scene = base(&[
                format!("fem.surface_size={size}"),
                format!("fem.geometry={geometry}"),
                format!("fem.mirror={mirror}"),
            ])?;
            let names = [method, &format!("size {size}")];
            points.push(instant(&scene, names, exact, value)?);
        }
    }
    Ok(points)
}

/// Meshes adapted to an asked error.
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

/// The meridian plane, to a tolerance.
fn meridian(
    base: &dyn Fn(&[String]) -> Result<Scene>,
    exact: f64,
    value: impl Fn(&InstantaneousSolution) -> f64 + Copy,
) -> Result<Vec<Point>> {
    [1e-2, 1e-4, 1e-6]
        .map(|tolerance| {
            let scene = base(&[
                "model.kind=axisymmetric".to_owned(),
                format!("model.tolerance={tolerance:e}"),
            ])?;
            let choice = format!("tolerance {tolerance:e}");
            instant(&scene, ["axisymmetric elements", &choice], exact, value)
        })
        .into_iter()
        .collect()
}

fn drag(quick: bool) -> Result<Quantity> {
    // A pulled sphere in a ball of ten radii: force over velocity.
    let exact = concentric_drag(0.1) * 6.0 * PI;
    let value =
        |solved: &InstantaneousSolution| solved.bodies[0].force.x / solved.bodies[0].velocity.x;
    let base = |more: &[String]| -> Result<Scene> {
        let mut overrides = vec!["domain.radius=10".to_owned()];
        overrides.extend_from_slice(more);
        scene("sphere-in-ball.toml", &overrides)
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

fn pair(quick: bool) -> Result<Quantity> {
    // Two spheres pushed towards each other, half a radius apart: Stimson & Jeffery 1926. Forces add up to zero, so the wall, 800 radii
    // away, changes the speed by less than (2.5 / 800)^3.
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
        scene("two-spheres.toml", &overrides)
    };
    let mut points = by_size(quick, &base, exact, value)?;
    points.extend(adapted(targets(quick), &base, exact, value)?);
    points.extend(meridian(&base, exact, value)?);
    Ok(Quantity {
        key: "pair",
        title: format!(
            "resistance of two spheres half a radius apart, pushed together, exactly {exact:.6}"
        ),
        points,
    })
}

fn speed(quick: bool) -> Result<Quantity> {
    let case = &INSTANTANEOUS[0];
    let value = |solved: &InstantaneousSolution| solved.bodies[1].velocity.x;
    let base = |more: &[String]| -> Result<Scene> {
        // The first phase moves by four: at unit rate when it takes four.
        let mut overrides = vec!["gait.phases.0.duration=4".to_owned()];
        overrides.extend_from_slice(more);
        scene("three-sphere.toml", &overrides)
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
        let names = ["curved, looser solver", &format!("size 0.4, rtol {rtol:e}")];
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
