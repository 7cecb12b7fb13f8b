//! A search for the most efficient gait of the three-sphere swimmer, in parallel.
//!
//! `cargo run --example gait_search`

use rayon::prelude::*;
use swimmer::scene::ModelKind;
use swimmer::{Method, Scene, SwimError, choose, simulate};

/// Net displacement squared over work for a stroke that closes both arms from 10 radii.
///
/// For a fixed duration this is proportional to the swimming efficiency of Lighthill.
fn efficiency(left: f64, right: f64) -> Result<f64, SwimError> {
    let scene = Scene::builder()
        .sphere("left", 1.0, [-10.0, 0.0, 0.0])
        .sphere("centre", 1.0, [0.0, 0.0, 0.0])
        .sphere("right", 1.0, [10.0, 0.0, 0.0])
        .link("left arm", "left", "centre")
        .link("right arm", "right", "centre")
        .phase("left arm", left, 1.0)
        .phase("right arm", right, 1.0)
        .phase("left arm", 10.0, 1.0)
        .phase("right arm", 10.0, 1.0)
        .model(ModelKind::Multipole)
        .tolerance(1e-3)
        .build()?;
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
