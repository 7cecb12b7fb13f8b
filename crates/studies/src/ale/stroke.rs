//! The default stroke with each mesh motion of the program.

use anyhow::Result;
use swimmer::choose;
use swimmer::scene::MeshMotionKind;
use swimmer::{Method, simulate};

use crate::scene_files;

/// Result of a stroke.
pub struct Stroke {
    pub motion: &'static str,
    /// Meshes generated.
    pub meshes: usize,
    pub solves: usize,
    /// Net displacement of the middle sphere.
    pub net: f64,
    /// Error bar of the net displacement.
    pub bar: f64,
    /// Seconds to generate and move meshes.
    pub mesh_seconds: f64,
    pub seconds: f64,
}

/// Runs the stroke of the paper with elements of `size` on the spheres.
pub fn strokes(size: f64) -> Result<Vec<Stroke>> {
    let mut strokes = Vec::new();
    // Generated meshes are moved by one method: `auto` is the biharmonic one.
    let words = MeshMotionKind::WORDS.iter();
    for &motion in words.filter(|&&word| word != "auto") {
        eprintln!("default stroke, {motion}");
        let scene = scene_files::read(
            "three-sphere.toml",
            &[
                format!("fem.mesh_motion={motion}"),
                format!("fem.surface_size={size}"),
                // Not every motion preserves symmetry planes; here all move the same mesh.
                "fem.symmetry=off".to_owned(),
            ],
        )?;
        let mut model = choose(&scene)?.model;
        let outcome = simulate(&scene, model.as_mut(), Method::Collocation, &mut ())?;
        strokes.push(Stroke {
            motion,
            meshes: outcome.meshes.len(),
            solves: outcome.solves,
            net: outcome.displacement[1].x,
            bar: outcome.error_estimate.total(),
            mesh_seconds: outcome.seconds.mesh,
            seconds: outcome.seconds.total,
        });
    }
    Ok(strokes)
}
