//! Design of strokes: optimal strokes, learned ones and derivatives against exact values.

mod examples;
mod learned;
mod optimal;
mod rheology;
mod sensitivities;
mod sizes;
mod speed;
mod tables;
mod timing;
mod turning;

use testkit::SceneText;

fn three_sphere() -> SceneText {
    SceneText::file(include_str!("../../../swimmer/templates/three-sphere.toml"))
}

fn smooth() -> SceneText {
    SceneText::file(include_str!("../../../swimmer/templates/smooth.toml"))
}

fn planar() -> SceneText {
    SceneText::file(include_str!("../../../swimmer/templates/planar.toml"))
}

/// Three unit spheres with the arms `a` and `b` of length 10, by multipoles.
fn two_arms(tolerance: f64) -> SceneText {
    let text = testkit::chain(&["l", "c", "r"], &[-10.0, 0.0, 10.0]);
    text.slide("a", "l", "c")
        .slide("b", "r", "c")
        .model("multipole", tolerance)
}
