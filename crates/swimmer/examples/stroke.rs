//! One stroke of the three-sphere swimmer of Najafi & Golestanian (2004) in unbounded fluid.
//!
//! `cargo run --example stroke`

use swimmer::{Method, Scene, SwimError, choose, simulate};

/// The arms close from 10 to 6 radii, left arm first, and open again in the same order.
const SCENE: &str = r#"
    model.tolerance = 1e-8
    bodies = [
        { name = "left", radius = 1, position = [-10, 0, 0] },
        { name = "centre", radius = 1, position = [0, 0, 0] },
        { name = "right", radius = 1, position = [10, 0, 0] },
    ]
    links = [
        { name = "left-arm", body = "left", to = "centre" },
        { name = "right-arm", body = "right", to = "centre" },
    ]
    gait.phases = [
        { link = "left-arm", length = 6 },
        { link = "right-arm", length = 6 },
        { link = "left-arm", length = 10 },
        { link = "right-arm", length = 10 },
    ]
"#;

/// Simulates the stroke and compares the net displacement with the exact one.
pub fn main() -> Result<(), SwimError> {
    let scene = Scene::parse(SCENE)?;
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
