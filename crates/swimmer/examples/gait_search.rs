//! A search for the most efficient gait of the three-sphere swimmer, in parallel.
//!
//! `cargo run --example gait_search`

use rayon::prelude::*;
use swimmer::{Method, Scene, SwimError, choose, simulate};

/// Net displacement squared over work for a stroke that closes both arms from 10 radii.
///
/// For a fixed duration this is proportional to the swimming efficiency of Lighthill.
fn efficiency(left: f64, right: f64) -> Result<f64, SwimError> {
    let scene = Scene::parse(&format!(
        r#"
        model = {{ kind = "multipole", tolerance = 1e-3 }}
        bodies = [
            {{ name = "l", radius = 1, position = [-10, 0, 0] }},
            {{ name = "c", radius = 1, position = [0, 0, 0] }},
            {{ name = "r", radius = 1, position = [10, 0, 0] }},
        ]
        links = [{{ name = "left", body = "l", to = "c" }}, {{ name = "right", body = "r", to = "c" }}]
        gait.phases = [
            {{ link = "left", length = {left} }}, {{ link = "right", length = {right} }},
            {{ link = "left", length = 10 }}, {{ link = "right", length = 10 }},
        ]
        "#
    ))?;
    let mut model = choose(&scene)?.model;
    let outcome = simulate(&scene, model.as_mut(), Method::Collocation, &mut ())?;
    Ok(outcome.net().powi(2) / outcome.work)
}

/// Evaluates a grid of arm lengths and prints the best pair.
pub fn main() -> Result<(), SwimError> {
    let lengths = [2.1, 2.5, 3.0, 4.0, 6.0, 8.0];
    let grid: Vec<(f64, f64)> = lengths
        .iter()
        .flat_map(|&left| lengths.map(|right| (left, right)))
        .collect();
    let (efficiency, (left, right)) = grid
        .par_iter()
        .map(|&(left, right)| Ok((efficiency(left, right)?, (left, right))))
        .try_reduce(Default::default, |a, b: (f64, _)| {
            Ok::<_, SwimError>(if b.0 > a.0 { b } else { a })
        })?;
    println!("most efficient: arms close to {left} and {right}, efficiency {efficiency:.3e}");
    assert_eq!((left, right), (3.0, 3.0));
    Ok(())
}
