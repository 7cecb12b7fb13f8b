//! A three-sphere swimmer built by a program, the legs of its stroke, and its scene file.

use scene::{ModelKind, Scene, SceneError, legs};

/// Builds the scene and follows the lengths of its arms.
pub fn main() -> Result<(), SceneError> {
    let scene = Scene::builder()
        .name("three-sphere swimmer")
        .ball(40.0)
        .sphere("left", 1.0, [-10.0, 0.0, 0.0])
        .sphere("centre", 1.0, [0.0, 0.0, 0.0])
        .sphere("right", 1.0, [10.0, 0.0, 0.0])
        .link("left arm", "left", "centre")
        .link("right arm", "right", "centre")
        .phase("left arm", 6.0, 1.0)
        .phase("right arm", 6.0, 1.0)
        .phase("left arm", 10.0, 1.0)
        .phase("right arm", 10.0, 1.0)
        .model(ModelKind::Multipole)
        .build()?;
    for leg in legs(scene.gait(), scene.articulation().initial_lengths())? {
        println!("t = {}: {:?} -> {:?}", leg.start, leg.from, leg.to);
    }
    println!("{}", scene.to_toml()?);
    // Bodies on a line along x: the planes normal to y and z are symmetry planes.
    assert_eq!(scene.symmetry_planes(), [false, true, true]);
    assert_eq!(scene.gait().duration(), 4.0);
    Ok(())
}
