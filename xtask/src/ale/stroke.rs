//! The default stroke by the program itself, once with each mesh motion it offers.

use std::path::Path;

use anyhow::Result;
use swimmer::model::{Hydrodynamics, choose};
use swimmer::{Leg, Method, Observer, Scene, Solved, SwimError, simulate};

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

/// Words of `fem.mesh_motion`.
const MOTIONS: [&str; 6] = [
    "laplace",
    "kanchi-masud",
    "inverse-volume",
    "elastic",
    "biharmonic",
    "rbf",
];

/// Exact net displacement of the middle sphere in a cycle (scenes/three-sphere.toml).
pub const EXACT: f64 = 0.160_418_016_0;

/// Runs the scene of the paper with elements of `size` on the spheres.
pub fn strokes(size: f64) -> Result<Vec<Stroke>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/three-sphere.toml");
    let mut strokes = Vec::new();
    for motion in MOTIONS {
        eprintln!("default stroke, {motion}");
        let scene = Scene::read(
            Path::new(path),
            &[
                format!("fem.mesh_motion={motion}"),
                format!("fem.surface_size={size}"),
            ],
        )?;
        let mut model = choose(&scene)?.model;
        let mut count = Count(0);
        let outcome = simulate(&scene, model.as_mut(), Method::Collocation, &mut count)?;
        strokes.push(Stroke {
            motion,
            meshes: count.0,
            solves: outcome.solves,
            net: outcome.displacement[1].x,
            error: outcome.error_estimate.total(),
            mesh_seconds: outcome.seconds.mesh,
            seconds: outcome.seconds.total,
        });
    }
    Ok(strokes)
}

/// Counts meshes.
struct Count(usize);

impl Observer for Count {
    fn solved(
        &mut self,
        _: &Leg,
        solved: &Solved,
        _: &dyn Hydrodynamics,
    ) -> std::result::Result<(), SwimError> {
        self.0 += usize::from(solved.instant.remeshed.is_some());
        Ok(())
    }
}
