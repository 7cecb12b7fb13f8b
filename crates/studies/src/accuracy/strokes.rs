//! Net displacement of a stroke, by all methods.

use std::time::Instant;

use anyhow::Result;
use swimmer::{Method, Observer, Outcome, Scene, choose, simulate, simulate_to_target};

use super::parameters::{MESHES, axisymmetric_overrides, mesh_overrides, sizes, targets};
use super::quantity::{Point, Quantity};
use crate::reference::STROKES;
use crate::scene_files;

/// Exact net displacement of the default stroke in unbounded fluid, by a spectral solution.
const UNBOUNDED_NET: f64 = 0.159_805_340_4;

/// Explicit Euler with the paper's time step, a tenth of a phase.
const PAPER_STEPS: usize = 10;

/// Largest number of dofs of a solve of a stroke.
#[derive(Default)]
pub struct Largest(pub usize);

impl Observer for Largest {
    fn solved(
        &mut self,
        _: &swimmer::PhaseSpan,
        solved: &swimmer::SpanSolution,
        _: &dyn swimmer::models::Hydrodynamics,
    ) -> std::result::Result<(), swimmer::SwimError> {
        self.0 = self.0.max(solved.solution.dofs.total);
        Ok(())
    }
}

fn stroke(scene: &Scene, method: Method, names: [&str; 2], exact: f64) -> Result<Point> {
    let clock = Instant::now();
    let mut model = choose(scene)?.model;
    let mut largest = Largest::default();
    let outcome = simulate(scene, model.as_mut(), method, &mut largest)?;
    Ok(point(names, &outcome, largest.0, &clock, exact))
}

/// The point of a stroke that `clock` has timed.
fn point(
    [name, choice]: [&str; 2],
    outcome: &Outcome,
    dofs: usize,
    clock: &Instant,
    exact: f64,
) -> Point {
    let net = outcome.displacement[1].x;
    let error = |net: f64| (net / exact - 1.0).abs();
    Point {
        method: name.to_owned(),
        choice: choice.to_owned(),
        size: None,
        dofs,
        seconds: clock.elapsed().as_secs_f64(),
        error: error(net),
        uncorrected: (outcome.mesh_error.as_ref()).map(|removed| error(net + removed[1].x)),
        // Without an estimate of the integration error, the sum of the others is no error bar.
        bar: outcome
            .error_estimate
            .integration
            .map(|_| outcome.error_estimate.total() / net.abs()),
    }
}

/// Stroke with element sizes that the program chooses for a target error; the time includes strokes
/// that miss it.
fn stroke_for_target(name: &str, target: f64, exact: f64) -> Result<Point> {
    let clock = Instant::now();
    let scene = scene_files::read(name, &[format!("fem.target={target:e}")])?;
    let mut largest = Largest::default();
    let (_, outcome) = simulate_to_target(&scene, Method::Collocation, &mut largest)?;
    let choice = format!("target {target:e}");
    let names = ["sizes chosen for a target error, curved", &choice];
    Ok(point(names, &outcome, largest.0, &clock, exact))
}

/// The net displacement of the default stroke.
pub fn net(quick: bool) -> Result<Quantity> {
    let exact = STROKES[0].net;
    let mut points = Vec::new();
    let name = "three-sphere.toml";
    for [method, geometry, symmetry] in MESHES {
        // With finer meshes of the whole fluid, a stroke takes minutes.
        for &size in sizes(quick).iter().filter(|&&size| size >= 0.2) {
            let scene = scene_files::read(name, &mesh_overrides(geometry, symmetry, size))?;
            let names = [method, &format!("size {size}")];
            points.push(Point {
                size: Some(size),
                ..stroke(&scene, Method::Collocation, names, exact)?
            });
        }
    }
    if !quick {
        for &target in targets(quick) {
            points.push(stroke_for_target(name, target, exact)?);
        }
    }
    for tolerance in [1e-2, 1e-4] {
        let scene = scene_files::read(name, &axisymmetric_overrides(tolerance))?;
        let choice = format!("tolerance {tolerance:e}");
        points.push(stroke(
            &scene,
            Method::Collocation,
            ["axisymmetric elements", &choice],
            exact,
        )?);
    }
    let paper = scene_files::read(
        name,
        &[
            "fem.geometry=straight".to_owned(),
            "fem.surface_size=0.4".to_owned(),
        ],
    )?;
    points.push(stroke(
        &paper,
        Method::Euler { steps: PAPER_STEPS },
        [
            "the paper's choices: straight elements, Euler, time step 0.1",
            "size 0.4",
        ],
        exact,
    )?);
    for steps in if quick { vec![4] } else { vec![4, 16] } {
        let scene = scene_files::read(name, &["fem.surface_size=0.5".to_owned()])?;
        points.push(stroke(
            &scene,
            Method::Euler { steps },
            [
                "curved, Euler",
                &format!("size 0.5, {steps} steps per phase"),
            ],
            exact,
        )?);
    }
    for tolerance in [1e-1, 1e-2, 1e-4] {
        let scene = scene_files::read(
            name,
            &[
                format!("model.tolerance={tolerance}"),
                "fem.surface_size=0.5".to_owned(),
            ],
        )?;
        points.push(stroke(
            &scene,
            Method::Collocation,
            [
                "curved, other tolerances",
                &format!("size 0.5, tolerance {tolerance:e}"),
            ],
            exact,
        )?);
    }
    for kind in ["oseen", "rpy", "multipole"] {
        let scene = scene_files::read(
            name,
            &[
                format!("model.kind={kind}"),
                "domain.kind=unbounded".to_owned(),
            ],
        )?;
        points.push(stroke(
            &scene,
            Method::Collocation,
            [&format!("{kind}, unbounded")[..], "-"],
            UNBOUNDED_NET,
        )?);
    }
    Ok(Quantity {
        key: "net",
        title: format!("net displacement of the default stroke, exactly {exact:.10}"),
        points,
    })
}
