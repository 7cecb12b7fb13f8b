//! One stroke of the three-sphere swimmer of Najafi & Golestanian (2004) in unbounded fluid.
//!
//! `cargo run --example stroke`

use swimmer::{Method, Scene, SwimError, choose, simulate};

/// Simulates the stroke and compares the net displacement with the exact one.
pub fn main() -> Result<(), SwimError> {
    // The arms close from 10 to 6 radii, the left one first, and open again in the same order.
    let scene = Scene::builder()
        .sphere("left", 1.0, [-10.0, 0.0, 0.0])
        .sphere("centre", 1.0, [0.0, 0.0, 0.0])
        .sphere("right", 1.0, [10.0, 0.0, 0.0])
        .slide("left arm", "left", "centre")
        .slide("right arm", "right", "centre")
        .phase("left arm", 6.0, 1.0)
        .phase("right arm", 6.0, 1.0)
        .phase("left arm", 10.0, 1.0)
        .phase("right arm", 10.0, 1.0)
        .tolerance(1e-8)
        .build()?;
    let mut choice = choose(&scene)?;
    for reason in &choice.reasons {
        println!("{reason}");
    }
    let outcome = simulate(&scene, choice.model.as_mut(), Method::Collocation, &mut ())?;
    let (net, error) = (outcome.net(), outcome.error_estimate.total());
    println!("net displacement {net:.10} +- {error:.1e}");

    // From a series in bispherical coordinates and from collocation, which agree to 1e-12.
    let exact = 0.1598053404;
    assert!((net - exact).abs() < error && error < 1e-8);
    Ok(())
}
