//! B: two equal spheres that move against each other, in a ball too large to matter.

use std::f64::consts::PI;

use anyhow::Result;

use super::flow::{Sphere, scene, solve};
use super::reference::OPPOSITE;
use super::table::{Basis, Cost, Row};
use super::{Effort, expected};

/// Radius of the ball. The pair has no net force, so its image is a quadratic flow: at centre distance `s` the force changes
/// by less than `(s / radius)^3`, 2e-4 at the largest distance.
const CONTAINER: f64 = 100.0;

/// What the footnote says about the rows that are missing.
pub const NOTE: &str = "B: the ball of radius 100 changes forces on a force-free pair by less than (s / 100)^3, at most 2e-4. Two spheres that move \
     together have a net force, whose container effect of 9/4 per ball radius needs a far-field treatment: left out until there is one.";

/// Force on either sphere over $6 \pi U$.
pub fn rows(effort: Effort) -> Result<Vec<Row>> {
    let (least, size) = match effort {
        Effort::Quick => (3.0, 0.3),
        Effort::Full => (2.1, 0.2),
    };
    let cases = OPPOSITE.iter().filter(|(distance, _)| *distance >= least);
    cases
        .map(|&(distance, exact)| {
            let (coarse, _) = force(distance, 2.0 * size)?;
            let (fine, cost) = force(distance, size)?;
            let refined = expected::from_halving(coarse, fine);
            let unrefined = expected::gap(distance - 2.0, 2.0 * size);
            let left = (refined + unrefined) / exact + (distance / CONTAINER).powi(3);
            Ok(Row::relative(
                "B",
                format!("opposite, s {distance}, h {size}"),
                [exact, fine],
                (left, Basis::Halving),
                cost,
            ))
        })
        .collect()
}

/// A link between the two closes at rate two.
fn force(distance: f64, size: f64) -> Result<(f64, Cost)> {
    let spheres = [-0.5, 0.5].map(|side| Sphere {
        position: side * distance,
        radius: 1.0,
        ..Sphere::default()
    });
    // A hundredth of the gap: only the rate counts, but the gait must not let the spheres touch.
    let change = 0.01 * (distance - 2.0);
    let link = format!(
        "[[links]]\nname = \"link\"\nbody = \"s1\"\nto = \"s0\"\n[[gait.phases]]\nlink = \"link\"\nlength = {:?}\nduration = {:?}\n",
        distance - change,
        change / 2.0
    );
    let (instant, cost) = solve(&scene(CONTAINER, size, &spheres, &link)?)?;
    let [left, right] = [0, 1].map(|k| &instant.bodies[k]);
    // Half the difference, so that the pair's own drift does not count.
    let approach = 0.5 * (left.velocity.x - right.velocity.x);
    Ok((
        0.5 * (left.force.x - right.force.x) / (6.0 * PI * approach),
        cost,
    ))
}
