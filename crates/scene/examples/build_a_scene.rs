//! A three-sphere swimmer built by a program, the phase spans of its stroke, and its scene file.

use scene::{ModelKind, Scene, SceneError, spans};

/// Builds the scene and follows the lengths of its arms.
pub fn main() -> Result<(), SceneError> {
    let scene = Scene::builder()
        .name("three-sphere swimmer")
        .ball(40.0)
        .sphere("left", 1.0, [-10.0, 0.0, 0.0])
        .sphere("centre", 1.0, [0.0, 0.0, 0.0])
        .sphere("right", 1.0, [10.0, 0.0, 0.0])
        .slide("left arm", "left", "centre")
        .slide("right arm", "right", "centre")
        .phase("left arm", 6.0, 1.0)
        .phase("right arm", 6.0, 1.0)
        .phase("left arm", 10.0, 1.0)
        .phase("right arm", 10.0, 1.0)
        .model(ModelKind::Multipole)
        .build()?;
    for span in spans(scene.gait(), scene.articulation().initial_shape())? {
        println!("t = {}: {:?} -> {:?}", span.start, span.from, span.to);
    }
    println!("{}", scene.to_toml()?);
    // Bodies on a line along x: the planes normal to y and z are symmetry planes.
    assert_eq!(scene.symmetry_planes(), [false, true, true]);
    assert_eq!(scene.gait().duration(), 4.0);
    Ok(())
}
