//! Net displacement of a stroke, by all methods.

use std::time::Instant;

use anyhow::Result;
use swimmer::models::Hydrodynamics;
use swimmer::{
    Method, Observer, Outcome, PhaseSpan, SpanSolution, SwimError, choose, simulate,
    simulate_to_target,
};

use super::quantity::{Point, Quantity};
use super::{MESHES, axisymmetric_overrides, mesh_overrides, sizes, targets};
use crate::reference::{STROKES, UNBOUNDED_STROKES};
use crate::scenes;

/// Explicit Euler with the paper's time step, a tenth of a phase.
const PAPER_STEPS: usize = 10;

/// Largest number of dofs of a solve of a stroke.
#[derive(Default)]
pub struct Largest(pub usize);

impl Observer for Largest {
    fn solved(
        &mut self,
        _: &PhaseSpan,
        solved: &SpanSolution,
        _: &dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        self.0 = self.0.max(solved.solution.dofs.total);
        Ok(())
    }
}

/// The point of a stroke of the default scene with `overrides`; with `None` for the integrator,
/// element sizes are chosen for the target error of the scene, and the time includes strokes that
/// miss it.
fn stroke<S: AsRef<str>>(
    [method, choice]: [&str; 2],
    overrides: &[S],
    integrator: Option<Method>,
    exact: f64,
) -> Result<Point> {
    let scene = scenes::read("three-sphere.toml", overrides)?;
    let clock = Instant::now();
    let mut largest = Largest::default();
    let outcome: Outcome = match integrator {
        Some(integrator) => {
            let mut model = choose(&scene)?.model;
            simulate(&scene, model.as_mut(), integrator, &mut largest)?
        }
        None => simulate_to_target(&scene, Method::Collocation, &mut largest)?.1,
    };
    let net = outcome.displacement[1].x;
    let error = |net: f64| (net / exact - 1.0).abs();
    let bars = &outcome.error_estimate;
    Ok(Point {
        method: method.to_owned(),
        choice: choice.to_owned(),
        size: None,
        dofs: largest.0,
        seconds: clock.elapsed().as_secs_f64(),
        error: error(net),
        uncorrected: (outcome.mesh_error.as_ref()).map(|removed| error(net + removed[1].x)),
        // Without an estimate of the integration error, the sum of the others is no error bar.
        bar: bars.integration.map(|_| bars.total() / net.abs()),
    })
}

/// The net displacement of the default stroke.
pub fn net(quick: bool) -> Result<Quantity> {
    let exact = STROKES[0].net;
    let collocation = Some(Method::Collocation);
    let mut points = Vec::new();
    for [method, geometry, symmetry] in MESHES {
        // With finer meshes of the whole fluid, a stroke takes minutes.
        for &size in sizes(quick).iter().filter(|&&size| size >= 0.2) {
            let overrides = mesh_overrides(geometry, symmetry, size);
            let choice = format!("size {size}");
            points.push(Point {
                size: Some(size),
                ..stroke([method, &choice], &overrides, collocation, exact)?
            });
        }
    }
    for target in targets(quick).iter().filter(|_| !quick) {
        let choice = format!("target {target:e}");
        let names = ["sizes chosen for a target error, curved", &choice];
        points.push(stroke(
            names,
            &[format!("fem.target={target:e}")],
            None,
            exact,
        )?);
    }
    for tolerance in [1e-2, 1e-4] {
        let choice = format!("tolerance {tolerance:e}");
        let names = ["axisymmetric elements", &choice];
        points.push(stroke(
            names,
            &axisymmetric_overrides(tolerance),
            collocation,
            exact,
        )?);
    }
    let names = [
        "the paper's choices: straight elements, Euler, time step 0.1",
        "size 0.4",
    ];
    let paper = ["fem.geometry=straight", "fem.surface_size=0.4"];
    let steps = PAPER_STEPS;
    points.push(stroke(names, &paper, Some(Method::Euler { steps }), exact)?);
    const COARSE: &str = "fem.surface_size=0.5";
    for &steps in if quick { &[4][..] } else { &[4, 16] } {
        let choice = format!("size 0.5, {steps} steps per phase");
        let euler = Some(Method::Euler { steps });
        points.push(stroke(["curved, Euler", &choice], &[COARSE], euler, exact)?);
    }
    for tolerance in [1e-1, 1e-2, 1e-4] {
        let choice = format!("size 0.5, tolerance {tolerance:e}");
        let names = ["curved, other tolerances", &choice];
        let overrides = [COARSE, &format!("model.tolerance={tolerance}")];
        points.push(stroke(names, &overrides, collocation, exact)?);
    }
    for kind in ["oseen", "rpy", "multipole"] {
        let method = format!("{kind}, unbounded");
        let overrides = ["domain.kind=unbounded", &format!("model.kind={kind}")];
        let exact = UNBOUNDED_STROKES[0].2;
        points.push(stroke([&method, "-"], &overrides, collocation, exact)?);
    }
    Ok(Quantity {
        key: "net",
        title: format!("net displacement of the default stroke, exactly {exact:.10}"),
        points,
    })
}
