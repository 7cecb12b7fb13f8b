//! N: bodies that deform: the pushmepullyou, and spheres with waves of their shape.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use anyhow::Result;
use swimmer::{Method, Outcome, Scene, choose, simulate};

use super::row::{Basis, Cost, Estimated, Row};
use crate::reference::{PUSHMEPULLYOUS, Pushmepullyou, SHAPE_WAVES, ShapeWave, TANGENTIAL_WAVES};

/// Tolerance of the net displacement by multipoles, and in the meridian plane.
const BY_MULTIPOLES: f64 = 1e-8;
const IN_THE_PLANE: f64 = 1e-6;

/// Relative error of strokes of a tolerance of the net displacement: of single values with ten
/// digits, and of waves whose displacement is a small difference.
const OF_STROKES: f64 = 5e-8;
const OF_WAVES: f64 = 2e-6;

/// Tolerance of strokes by elements in space, which limits the error of the integration alone.
const OF_INTEGRATION: f64 = 1e-3;

/// Promise for net displacements by elements in space, whose error bars are of this order.
const BY_ELEMENTS: f64 = 2e-3;

/// The same of waves, whose displacement is the small difference of large ones.
const WAVES_BY_ELEMENTS: f64 = 2e-2;

/// All rows; one stroke and one wave in the quick part.
pub fn rows(quick: bool) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let strokes = if quick { 1 } else { PUSHMEPULLYOUS.len() };
    for stroke in &PUSHMEPULLYOUS[..strokes] {
        rows.push(pushmepullyou(
            stroke,
            "multipole",
            BY_MULTIPOLES,
            OF_STROKES,
        )?);
        rows.push(pushmepullyou(
            stroke,
            "axisymmetric",
            IN_THE_PLANE,
            IN_THE_PLANE,
        )?);
        rows.push(pushmepullyou(stroke, "fem", OF_INTEGRATION, BY_ELEMENTS)?);
    }
    let waves = if quick { 1 } else { SHAPE_WAVES.len() };
    for wave in &SHAPE_WAVES[..waves] {
        let plane = ("axisymmetric", IN_THE_PLANE, OF_WAVES);
        rows.push(shape_wave(wave, plane)?);
        if !quick {
            rows.push(shape_wave(
                wave,
                ("fem", OF_INTEGRATION, WAVES_BY_ELEMENTS),
            )?);
        }
    }
    if !quick {
        for wave in &TANGENTIAL_WAVES {
            rows.push(shape_wave(wave, ("multipole", 1e-7, OF_WAVES))?);
        }
    }
    Ok(rows)
}

/// The domain of a scene: unbounded, or a ball.
fn domain(ball: Option<f64>) -> String {
    ball.map_or_else(String::new, |radius| {
        format!("domain = {{ kind = \"ball\", radius = {radius} }}\n")
    })
}

/// In words.
fn place(ball: Option<f64>) -> String {
    ball.map_or_else(String::new, |radius| format!(", ball of {radius}"))
}

/// The net displacement of the left centre.
fn pushmepullyou(stroke: &Pushmepullyou, model: &str, tolerance: f64, allowed: f64) -> Result<Row> {
    let [near, far] = stroke.lengths;
    let (small, large) = (4.0 * PI / 3.0, 8.0 * PI / 3.0);
    let text = format!(
        r#"
        {}
        model = {{ kind = "{model}", tolerance = {tolerance:e} }}
        bodies = [
            {{ name = "left", radius = 1, position = [{}, 0, 0] }},
            {{ name = "right", radius = {:?}, position = [{}, 0, 0] }},
        ]
        links = [{{ name = "arm", body = "right", to = "left" }}]
        gait.phases = [
            {{ link = "arm", length = {far} }},
            {{ targets = {{ "left.volume" = {large:?}, "right.volume" = {small:?} }} }},
            {{ link = "arm", length = {near} }},
            {{ targets = {{ "left.volume" = {small:?}, "right.volume" = {large:?} }} }},
        ]
        "#,
        domain(stroke.ball),
        -0.5 * near,
        2.0_f64.cbrt(),
        0.5 * near,
    );
    let outcome = run(&text)?;
    let formula = stroke
        .far_field
        .map_or_else(String::new, |value| format!(" (far-field formula {value})"));
    let name = format!(
        "pushmepullyou {near} to {far}{}, {model}: displacement{formula}",
        place(stroke.ball)
    );
    let values = [stroke.net, outcome.displacement[0].x];
    Ok(Row::relative(
        "N",
        name,
        values,
        // An exact value of few digits decides no more than they say.
        (allowed + stroke.digits, Basis::Promised),
        cost(&outcome),
    )
    .with(Estimated::bound(outcome.error_estimate.total()))
    .with_exact_bar(stroke.digits))
}

/// The displacement of a sphere with two modes `eps cos t` and `eps sin t` in a period.
fn shape_wave(wave: &ShapeWave, (model, tolerance, allowed): (&str, f64, f64)) -> Result<Row> {
    let (eps, motion) = (wave.amplitude, wave.motion);
    let text = format!(
        r#"
        {}
        model = {{ kind = "{model}", tolerance = {tolerance:e} }}
        [[bodies]]
        name = "sphere"
        radius = 1
        position = [0, 0, 0]
        deformation = {{ motion = "{motion}", modes = {{ a = 2, b = 3 }}, axis = [0, 0, 1] }}
        [gait]
        period = {TAU:?}
        harmonics = [
            {{ link = "sphere.a", mean = 0, amplitude = {eps}, phase = {FRAC_PI_2:?} }},
            {{ link = "sphere.b", mean = 0, amplitude = {eps} }},
        ]
        "#,
        domain(wave.ball),
    );
    let outcome = run(&text)?;
    let name = format!(
        "{motion} wave, amplitude {eps}{}, {model}: displacement",
        place(wave.ball)
    );
    let values = [wave.net, outcome.displacement[0].z];
    Ok(Row::relative(
        "N",
        name,
        values,
        (allowed, Basis::Promised),
        cost(&outcome),
    )
    .with(Estimated::bound(outcome.error_estimate.total()))
    .with_exact_bar(wave.digits))
}

fn run(text: &str) -> Result<Outcome> {
    let scene = Scene::parse(text)?;
    let mut model = choose(&scene)?.model;
    Ok(simulate(
        &scene,
        model.as_mut(),
        Method::from_scene(&scene),
        &mut (),
    )?)
}

fn cost(outcome: &Outcome) -> Cost {
    Cost {
        dofs: 0,
        iterations: 0,
        seconds: outcome.seconds.total,
    }
}
