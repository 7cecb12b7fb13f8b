//! The default stroke by the program itself, once with each mesh motion it offers.

use std::path::Path;

use anyhow::Result;
use swimmer::choose;
use swimmer::scene::MeshMotionKind;
use swimmer::{Method, Scene, simulate};

/// What a stroke came to.
pub struct Stroke {
    pub motion: &'static str,
    /// Meshes generated.
    pub meshes: usize,
    pub solves: usize,
    /// Net displacement of the middle sphere.
    pub net: f64,
    /// Its error as the program estimates it.
    pub error: f64,
    /// Seconds for meshes, made and moved.
    pub mesh_seconds: f64,
    pub seconds: f64,
}

/// Runs the scene of the paper with elements of `size` on the spheres.
pub fn strokes(size: f64) -> Result<Vec<Stroke>> {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../scenes/three-sphere.toml"
    );
    let mut strokes = Vec::new();
    for &motion in MeshMotionKind::WORDS {
        eprintln!("default stroke, {motion}");
        let scene = Scene::read(
            Path::new(path),
            &[
                format!("fem.mesh_motion={motion}"),
                format!("fem.surface_size={size}"),
                // Not every motion keeps mirror planes; all move the same mesh.
                "fem.mirror=off".to_owned(),
            ],
        )?;
        let mut model = choose(&scene)?.model;
        let outcome = simulate(&scene, model.as_mut(), Method::Collocation, &mut ())?;
        strokes.push(Stroke {
            motion,
            meshes: outcome.meshes.len(),
            solves: outcome.solves,
            net: outcome.displacement[1].x,
            error: outcome.error_estimate.total(),
            mesh_seconds: outcome.seconds.mesh,
            seconds: outcome.seconds.total,
        });
    }
    Ok(strokes)
}
