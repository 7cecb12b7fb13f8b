//! Measurement of one method on one path.

use std::time::Instant;

use anyhow::Result;
use mesh::TetMesh;

use super::cases::Case;
use super::methods::{METHODS, Method, Moving, Way};

/// The mesh after a step.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Label of the step: the completed fraction, the gap or the number of cycles.
    pub label: f64,
    /// Smallest mean ratio of the cells.
    pub quality: f64,
    /// Smallest Jacobian of the curved cells over that of the straight ones.
    pub jacobian: f64,
    /// Largest displacement of a node from the first mesh.
    pub displacement: f64,
}

/// Result of a method on a path.
pub struct Run {
    pub method: &'static str,
    pub way: Way,
    pub case: &'static str,
    pub curved: bool,
    /// Valid steps.
    pub samples: Vec<Sample>,
    /// Whether every step was valid.
    pub complete: bool,
    /// Label of the first invalid step.
    pub failed_at: Option<f64>,
    /// Seconds of set-up.
    pub setup: f64,
    /// Seconds per step.
    pub step: f64,
    /// The last valid mesh.
    pub mesh: TetMesh,
}

impl Run {
    /// Smallest quality along the path.
    pub fn quality(&self) -> f64 {
        self.samples
            .iter()
            .map(|s| s.quality)
            .fold(f64::INFINITY, f64::min)
    }

    /// Smallest Jacobian along the path.
    pub fn jacobian(&self) -> f64 {
        self.samples
            .iter()
            .map(|s| s.jacobian)
            .fold(f64::INFINITY, f64::min)
    }
}

/// Runs every method on a case, from the reference and incrementally.
pub fn runs(case: &Case, size: f64) -> Result<Vec<Run>> {
    let mesh = case.mesh(size)?;
    let bodies = case.bodies();
    let mut runs = Vec::new();
    for method in &METHODS {
        for way in Way::ALL {
            eprintln!("{}: {}, {}", case.title, method.name, way.name());
            runs.push(run(case, &mesh, &bodies, method, way)?);
        }
    }
    Ok(runs)
}

fn run(
    case: &Case,
    mesh: &TetMesh,
    bodies: &[ale::MovingBody],
    method: &Method,
    way: Way,
) -> Result<Run> {
    let clock = Instant::now();
    let mut moving = Moving::new(method, way, mesh, bodies)?;
    let setup = clock.elapsed().as_secs_f64();
    let mut seconds = 0.0;
    let mut samples = Vec::new();
    let mut failed_at = None;
    for (&arms, &label) in case.steps.iter().zip(&case.labels) {
        let clock = Instant::now();
        let quality = moving.advance(&case.motions(arms))?;
        seconds += clock.elapsed().as_secs_f64();
        let Some(quality) = quality else {
            failed_at = Some(label);
            break;
        };
        let moved = moving.mesh().points().iter().zip(mesh.points());
        samples.push(Sample {
            label,
            quality: quality.min_quality,
            jacobian: quality.min_jacobian,
            displacement: moved.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max),
        });
    }
    let steps = samples.len() + usize::from(failed_at.is_some());
    Ok(Run {
        method: method.name,
        way,
        case: case.key,
        curved: case.curved,
        complete: failed_at.is_none(),
        failed_at,
        samples,
        setup,
        step: seconds / steps.max(1) as f64,
        mesh: moving.mesh().clone(),
    })
}
