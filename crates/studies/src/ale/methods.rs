//! The mesh motions of the study, the two ways to use them, and measurements on a path.

use std::time::Instant;

use ale::{
    AleError, Biharmonic, Elastic, Harmonic, Kernel, MeshMotion, MovingBody, Rbf, ReferenceMap,
    Stiffening,
};
use anyhow::Result;
use mesh::TetMesh;
use nalgebra::Isometry3;

use super::cases::Case;
use super::incremental_map::IncrementalMap;

/// A mesh motion with its name in tables.
pub struct Method {
    pub name: &'static str,
    pub make: fn() -> Box<dyn MeshMotion>,
}

/// A method with these name and constructor.
const fn method(name: &'static str, make: fn() -> Box<dyn MeshMotion>) -> Method {
    Method { name, make }
}

/// All mesh motions of the study.
pub const METHODS: [Method; 8] = [
    method("Laplace", || Box::new(Harmonic(Stiffening::None))),
    method("1 + tau (Kanchi & Masud)", || {
        Box::new(Harmonic(Stiffening::KanchiMasud))
    }),
    method("1/V", || Box::new(Harmonic(Stiffening::InverseVolume))),
    method("elastic, nu = 0", || Box::new(Elastic::new(0.0))),
    method("elastic, nu = 0.3", || Box::new(Elastic::new(0.3))),
    method("biharmonic", || Box::new(Biharmonic)),
    method("RBF r", || Box::new(Rbf(Kernel::Linear))),
    method("RBF r^3", || Box::new(Rbf(Kernel::Cubic))),
];

/// Mesh from which each step starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// The first mesh: extensions are computed once.
    Reference,
    /// The mesh of the previous step: extensions are recomputed.
    Incremental,
}

impl Way {
    pub const ALL: [Self; 2] = [Self::Reference, Self::Incremental];

    pub fn name(self) -> &'static str {
        match self {
            Self::Reference => "reference",
            Self::Incremental => "incremental",
        }
    }
}

/// Moves the mesh to the given motions of the bodies.
type Advance = Box<dyn FnMut(&[Isometry3<f64>]) -> Result<TetMesh, AleError>>;

/// The motion of a mesh by a method.
fn moving(
    method: &Method,
    way: Way,
    mesh: &TetMesh,
    bodies: &[MovingBody],
) -> Result<Advance, AleError> {
    let motion = (method.make)();
    Ok(match way {
        Way::Reference => {
            let map = ReferenceMap::new(mesh.clone(), bodies, motion.as_ref())?;
            Box::new(move |motions| map.moved(motions))
        }
        Way::Incremental => {
            let mut map = IncrementalMap::new(mesh.clone(), bodies, motion)?;
            Box::new(move |motions| map.advance(motions).cloned())
        }
    })
}

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
    pub case: String,
    pub is_curved: bool,
    /// Valid steps.
    pub samples: Vec<Sample>,
    /// Label of the first invalid step.
    pub failed_at: Option<f64>,
    /// Seconds of set-up.
    pub setup: f64,
    /// Seconds per step.
    pub step: f64,
    /// Number of vertices of the mesh.
    pub vertices: usize,
}

/// Runs every method on a case, from the reference and incrementally.
pub fn runs(case: &Case, size: f64) -> Result<Vec<Run>> {
    let mesh = case.mesh(size)?;
    let bodies = case.bodies();
    let mut runs = Vec::new();
    for method in &METHODS {
        for way in Way::ALL {
            eprintln!("{}: {}, {}", case.key, method.name, way.name());
            runs.push(run(case, &mesh, &bodies, method, way)?);
        }
    }
    Ok(runs)
}

fn run(
    case: &Case,
    mesh: &TetMesh,
    bodies: &[MovingBody],
    method: &Method,
    way: Way,
) -> Result<Run> {
    let clock = Instant::now();
    let mut advance = moving(method, way, mesh, bodies)?;
    let setup = clock.elapsed().as_secs_f64();
    let mut seconds = 0.0;
    let mut samples = Vec::new();
    let mut failed_at = None;
    for &(label, arms) in &case.steps {
        let clock = Instant::now();
        let moved = advance(&case.motions(arms));
        seconds += clock.elapsed().as_secs_f64();
        let moved = match moved {
            Ok(moved) => moved,
            Err(AleError::Invalid(_)) => {
                failed_at = Some(label);
                break;
            }
            Err(other) => return Err(other.into()),
        };
        let quality = moved.quality();
        let pairs = moved.points().iter().zip(mesh.points());
        samples.push(Sample {
            label,
            quality: quality.min_quality,
            jacobian: quality.min_jacobian,
            displacement: pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max),
        });
    }
    let steps = samples.len() + usize::from(failed_at.is_some());
    Ok(Run {
        method: method.name,
        way,
        case: case.key.clone(),
        is_curved: case.is_curved,
        failed_at,
        samples,
        setup,
        step: seconds / steps.max(1) as f64,
        vertices: mesh.n_vertices(),
    })
}
