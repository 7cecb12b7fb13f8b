//! Random instantaneous solutions against multipoles.

use std::time::Instant;

use anyhow::{Context, Result};
use swimmer::models::{
    BodySolution, Configuration, Hydrodynamics, InstantaneousSolution, Query, SphereModel,
    SpheresModel,
};
use swimmer::{Scene, choose};

use super::arrangement::Arrangement;
use super::comparison::{Case, End, Quantity, of_instant};

/// Tolerance of the multipoles that are compared with, in three dimensions: a thousandth of the
/// usual errors of corrected values.
const EXACT: f64 = 1e-7;

/// The same on an axis, where more digits are cheap and elements in the meridian plane have them.
const EXACT_ON_AXIS: f64 = 1e-12;

/// Gap, in radii of the smaller neighbour, below which a case is counted as narrow.
const NARROW: f64 = 0.2;

/// Tolerance of elements in the meridian plane.
const MERIDIAN_TOLERANCE: f64 = 1e-4;

/// Cases of one arrangement, with or without slip: elements in space, and in the meridian plane
/// where there is one.
///
/// # Errors
/// A scene that is invalid; an arrangement for which there are no exact values.
pub fn cases(seed: u64, has_slip: bool) -> Result<Vec<Case>> {
    let mut drawn = Arrangement::draw(seed);
    if has_slip {
        drawn.draw_slips();
    }
    let tolerance = match drawn.is_axisymmetric {
        true => EXACT_ON_AXIS,
        false => EXACT,
    };
    let scene = drawn.text("multipole", tolerance).parse()?;
    let mut multipoles = SpheresModel::new(&scene, SphereModel::Multipole(tolerance))?;
    let exact = solve(&scene, &drawn, &mut multipoles).context("no exact value")?;
    // The tolerance of elements in space is that of the integration.
    let mut cases = vec![case(&drawn, &exact, "fem", 1e-3)?];
    if drawn.is_axisymmetric {
        cases.push(case(&drawn, &exact, "axisymmetric", MERIDIAN_TOLERANCE)?);
    }
    Ok(cases)
}

fn solve(
    scene: &Scene,
    drawn: &Arrangement,
    model: &mut dyn Hydrodynamics,
) -> Result<InstantaneousSolution> {
    let state = scene.initial_state();
    let configuration = Configuration {
        state: &state,
        shape: scene.articulation().initial_shape(),
    };
    let rates = std::slice::from_ref(&drawn.rates);
    let query = Query::new(configuration, rates).with_stresslets();
    model.solve(&query)?.pop().context("no solution")
}

fn case(
    drawn: &Arrangement,
    exact: &InstantaneousSolution,
    model: &'static str,
    tolerance: f64,
) -> Result<Case> {
    let scene = drawn.text(model, tolerance).parse()?;
    let clock = Instant::now();
    let solved = choose(&scene)
        .map_err(anyhow::Error::from)
        .and_then(|mut choice| solve(&scene, drawn, choice.model.as_mut()));
    let seconds = clock.elapsed().as_secs_f64();
    let end = match solved {
        Ok(solved) => {
            let bars = exact_bars(exact);
            let exact = of_instant(&scene, exact);
            let pairs = of_instant(&scene, &solved).into_iter().zip(&exact);
            let compared = pairs.filter_map(|(found, exact)| found.compare(exact, bars(&found)));
            End::Compared {
                comparisons: compared.collect(),
                dofs: solved.dofs.total,
                seconds,
            }
        }
        Err(error) => End::Refused(format!("{error:#}")),
    };
    let has_slip = !drawn.slips.is_empty();
    Ok(Case {
        kind: if has_slip { "squirmer" } else { "instant" }.to_owned(),
        seed: drawn.seed,
        model: model.to_owned(),
        groups: groups(drawn, model),
        gap: drawn.gap,
        description: drawn.description(),
        end,
    })
}

/// Relative error bar of each quantity of the solution that is compared with.
fn exact_bars(exact: &InstantaneousSolution) -> impl Fn(&Quantity) -> f64 {
    let size = |of: fn(&BodySolution) -> f64| {
        let sizes = exact.bodies.iter().map(of);
        sizes.fold(f64::MIN_POSITIVE, f64::max)
    };
    let of_velocity = exact.error_estimate.total() / size(|b| b.velocity.norm());
    let of_force = exact.force_error.total() / size(|b| b.force.norm());
    let of_power = exact.power_error.total() / exact.power().abs();
    let of_stresslet = exact.stresslets.as_ref().map_or(0.0, |stresslets| {
        let bar = stresslets.error.unwrap_or(f64::INFINITY);
        bar / stresslets.largest().max(f64::MIN_POSITIVE)
    });
    move |quantity| match quantity.name {
        "velocity" | "angular velocity" => of_velocity,
        "power" => of_power,
        "stresslet" => of_stresslet,
        _ => of_force,
    }
}

/// Groups of the table that a case belongs to.
fn groups(drawn: &Arrangement, model: &str) -> Vec<String> {
    let either = |yes: bool, one, other| if yes { one } else { other };
    let mut groups = match model {
        "axisymmetric" => vec!["meridian plane"],
        _ => vec![
            "all",
            either(drawn.rates.is_empty(), "free", "linked"),
            either(drawn.container.is_some(), "ball", "unbounded"),
            either(drawn.straight, "straight", "curved"),
            either(drawn.is_axisymmetric, "axisymmetric", "three-dimensional"),
        ],
    };
    if model == "fem" && drawn.gap < NARROW {
        groups.push("gap below 0.2");
    }
    groups.into_iter().map(str::to_owned).collect()
}
