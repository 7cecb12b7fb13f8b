//! Drag, resistance of a pair and swimming speed, by all methods.

use std::f64::consts::PI;
use std::time::Instant;

use anyhow::{Context, Result};
use swimmer::Scene;
use swimmer::models::InstantaneousSolution;

use super::quantity::{Point, Quantity};
use super::{MESHES, axisymmetric_overrides, mesh_overrides, sizes, targets};
use crate::reference::{INSTANTANEOUS, OPPOSITE, concentric_drag};
use crate::scenes::{self, UNIT_RATE, solve};

/// Reads the scene of a quantity with these overrides.
type Base<'a> = &'a dyn Fn(&[String]) -> Result<Scene>;

/// Computes the value of a quantity from a solution.
type Value<'a> = &'a dyn Fn(&InstantaneousSolution) -> f64;

/// A quantity at the start of a scene.
struct Measured<'a> {
    base: Base<'a>,
    value: Value<'a>,
    exact: f64,
    points: Vec<Point>,
}

impl Measured<'_> {
    /// Adds the point of a method.
    fn add(
        &mut self,
        method: &str,
        choice: String,
        overrides: &[String],
        size: Option<f64>,
    ) -> Result<()> {
        let scene = (self.base)(overrides)?;
        let clock = Instant::now();
        let solved = solve(&scene)?;
        let error =
            |solution: &InstantaneousSolution| ((self.value)(solution) / self.exact - 1.0).abs();
        let bar = solved.error_estimate.total();
        // All quantities belong to the body in the middle.
        let speed = solved.bodies[solved.bodies.len() / 2].velocity.norm();
        self.points.push(Point {
            method: method.to_owned(),
            choice,
            size,
            dofs: solved.dofs.total,
            seconds: clock.elapsed().as_secs_f64(),
            error: error(&solved),
            uncorrected: (solved.mesh_error.as_ref()).map(|_| error(&solved.uncorrected())),
            bar: (bar > 0.0).then_some(bar / speed),
        });
        Ok(())
    }

    /// Adds all element sizes, with curved and straight elements, with and without symmetry planes;
    /// meshes that are adapted to a target error; and axisymmetric elements.
    fn add_methods(&mut self, quick: bool, targets: &[f64]) -> Result<()> {
        for [method, geometry, symmetry] in MESHES {
            for &size in sizes(quick) {
                let overrides = mesh_overrides(geometry, symmetry, size);
                self.add(method, format!("size {size}"), &overrides, Some(size))?;
            }
        }
        for target in targets {
            let overrides = [format!("fem.target={target:e}")];
            let choice = format!("target {target:e}");
            self.add("finite elements, curved, adapted", choice, &overrides, None)?;
        }
        for tolerance in [1e-2, 1e-4, 1e-6] {
            let overrides = axisymmetric_overrides(tolerance);
            let choice = format!("tolerance {tolerance:e}");
            self.add("axisymmetric elements", choice, &overrides, None)?;
        }
        Ok(())
    }
}

/// Drag of a sphere in a ball.
pub fn drag(quick: bool) -> Result<Quantity> {
    // A sphere with a force in a ball of ten radii: force over velocity.
    let exact = concentric_drag(0.1) * 6.0 * PI;
    let mut measured = Measured {
        base: &|more| {
            let more = [&["domain.radius=10".to_owned()], more].concat();
            scenes::read("sphere-in-ball.toml", &more)
        },
        value: &|solved| solved.bodies[0].force.x / solved.bodies[0].velocity.x,
        exact,
        points: Vec::new(),
    };
    measured.add_methods(quick, targets(quick))?;
    Ok(Quantity {
        key: "drag",
        title: format!("drag of a sphere in a ball of ten radii, exactly {exact:.6}"),
        points: measured.points,
    })
}

/// Resistance of two spheres that approach each other.
pub fn pair(quick: bool) -> Result<Quantity> {
    // Two spheres pushed towards each other with a gap of half a radius: Stimson & Jeffery 1926.
    // The forces add up to zero, so the wall at 800 radii changes the speed by less than
    // `(2.5 / 800)^3`.
    let opposite = OPPOSITE.iter().find(|(distance, _)| *distance == 2.5);
    let exact = opposite.context("the distance is tabulated")?.1 * 6.0 * PI;
    let mut measured = Measured {
        base: &|more| {
            let overrides = [
                "domain.radius=800",
                "bodies.front.position=[1.25, 0, 0]",
                "bodies.front.force=[-1, 0, 0]",
                "bodies.back.position=[-1.25, 0, 0]",
                "bodies.back.force=[1, 0, 0]",
            ];
            scenes::read(
                "two-spheres.toml",
                &[&overrides.map(str::to_owned), more].concat(),
            )
        },
        value: &|solved| {
            let [front, back] = [0, 1].map(|body| solved.bodies[body]);
            (front.force.x - back.force.x) / (front.velocity.x - back.velocity.x)
        },
        exact,
        points: Vec::new(),
    };
    measured.add_methods(quick, targets(quick))?;
    Ok(Quantity {
        key: "pair",
        title: format!(
            "resistance of two spheres half a radius apart, pushed together, exactly {exact:.6} to 3e-8"
        ),
        points: measured.points,
    })
}

/// Swimming speed of three spheres.
pub fn speed(quick: bool) -> Result<Quantity> {
    let exact = INSTANTANEOUS[0].centre_velocity;
    let mut measured = Measured {
        base: &|more| {
            let more = [&[UNIT_RATE.to_owned()], more].concat();
            scenes::read("three-sphere.toml", &more)
        },
        value: &|solved| solved.bodies[1].velocity.x,
        exact,
        points: Vec::new(),
    };
    measured.add_methods(quick, &[])?;
    for formulation in ["lagrange", "direct-row"] {
        let overrides = [format!("fem.formulation={formulation}")];
        let method = format!("curved, {formulation}");
        measured.add(&method, "size 0.4".to_owned(), &overrides, None)?;
    }
    for rtol in [1e-3, 1e-5] {
        let overrides = [format!("fem.rtol={rtol:e}")];
        let choice = format!("size 0.4, rtol {rtol:e}");
        measured.add(
            "curved, larger tolerance of the solver",
            choice,
            &overrides,
            None,
        )?;
    }
    Ok(Quantity {
        key: "speed",
        title: format!(
            "velocity of the three-sphere swimmer's centre in a ball of radius 40, exactly {exact:.9}"
        ),
        points: measured.points,
    })
}
