//! A search for an economical gait of the three-sphere swimmer, in parallel.
//!
//! `cargo run --example gait_search`

use rayon::prelude::*;
use swimmer::scene::ModelKind;
use swimmer::{Method, Scene, SwimError, choose, simulate};

/// Net displacement per work for a left arm that closes from 10 to 6 radii and a right arm that
/// closes from 10 radii to `closed`.
fn displacement_per_work(closed: f64) -> Result<f64, SwimError> {
    let scene = Scene::builder()
        .sphere("left", 1.0, [-10.0, 0.0, 0.0])
        .sphere("centre", 1.0, [0.0, 0.0, 0.0])
        .sphere("right", 1.0, [10.0, 0.0, 0.0])
        .slide("left arm", "left", "centre")
        .slide("right arm", "right", "centre")
        .phase("left arm", 6.0, 1.0)
        .phase("right arm", closed, 1.0)
        .phase("left arm", 10.0, 1.0)
        .phase("right arm", 10.0, 1.0)
        .model(ModelKind::Multipole)
        .tolerance(1e-3)
        .build()?;
    let mut model = choose(&scene)?.model;
    let outcome = simulate(&scene, model.as_mut(), Method::Collocation, &mut ())?;
    Ok(outcome.net() / outcome.work)
}

/// Evaluates a grid of lengths and prints the best one.
pub fn main() -> Result<(), SwimError> {
    let (best, closed) = [2.1, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]
        .into_par_iter()
        .map(|closed| Ok((displacement_per_work(closed)?, closed)))
        .try_reduce(Default::default, |a: (f64, f64), b| {
            Ok::<_, SwimError>(if b.0 > a.0 { b } else { a })
        })?;
    println!("the right arm closes to {closed}: displacement per work {best:.3e}");
    assert_eq!(closed, 3.0);
    Ok(())
}
