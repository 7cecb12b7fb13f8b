//! Paths of three spheres on a line, which the meshes must follow.

use ale::MovingBody;
use anyhow::Result;
use mesh::TetMesh;
use mesher::GenerateParams;
use nalgebra::Isometry3;

use crate::three_spheres::{NAMES, ThreeSpheres};

/// Radius of the container, in radii of the spheres.
const CONTAINER: f64 = 30.0;

/// Factor on the gap in a step of the approach, and its smallest gap.
const APPROACH: f64 = 0.85;
const SMALLEST_GAP: f64 = 0.02;

/// Number of steps per phase of the stroke.
pub const STEPS_PER_PHASE: usize = 4;

/// A path: lengths of the arms at the start and after each step.
#[derive(Clone, Debug)]
pub struct Case {
    pub key: String,
    /// Whether cells are curved at the spheres.
    pub is_curved: bool,
    pub start: [f64; 2],
    /// Label of each step in charts, and left and right arm after it.
    pub steps: Vec<(f64, [f64; 2])>,
}

fn between(from: [f64; 2], to: [f64; 2], s: f64) -> [f64; 2] {
    [0, 1].map(|arm| from[arm] + s * (to[arm] - from[arm]))
}

/// A path on curved cells.
fn path(key: impl Into<String>, start: [f64; 2], steps: Vec<(f64, [f64; 2])>) -> Case {
    Case {
        key: key.into(),
        is_curved: true,
        start,
        steps,
    }
}

/// Path from `from` to `to` in equal steps, labelled by the completed fraction.
fn straight(key: &str, from: [f64; 2], to: [f64; 2], steps: usize) -> Case {
    let labels = (1..=steps).map(|k| k as f64 / steps as f64);
    let moves = labels.map(|s| (s, between(from, to, s)));
    path(format!("{key}-{steps}"), from, moves.collect())
}

/// Both arms close from a gap of three radii; each step reduces the remaining gap by 15 %.
fn approach() -> Case {
    let mut gap: f64 = 3.0;
    let mut steps = Vec::new();
    while gap > SMALLEST_GAP {
        gap = (gap * APPROACH).max(SMALLEST_GAP);
        steps.push((gap, [2.0 + gap; 2]));
    }
    path("approach", [5.0; 2], steps)
}

/// The four-phase stroke with arms of ten and six radii, labelled by completed cycles.
fn stroke(cycles: usize) -> Case {
    let corners = [[10.0, 10.0], [6.0, 10.0], [6.0, 6.0], [10.0, 6.0]];
    let mut steps = Vec::new();
    for phase in 0..4 * cycles {
        let (from, to) = (corners[phase % 4], corners[(phase + 1) % 4]);
        for k in 1..=STEPS_PER_PHASE {
            let s = k as f64 / STEPS_PER_PHASE as f64;
            steps.push(((phase as f64 + s) / 4.0, between(from, to, s)));
        }
    }
    path("cycles", corners[0], steps)
}

/// All cases, the short ones also on straight cells; the quick part has two cycles instead of ten.
pub fn all(quick: bool) -> Vec<Case> {
    let mut cases = Vec::new();
    for (key, from, to) in [
        ("move", [10.0; 2], [6.0, 10.0]),
        ("close", [5.0; 2], [2.5; 2]),
        ("open", [5.0; 2], [9.0; 2]),
    ] {
        cases.extend([1, 10].map(|steps| straight(key, from, to, steps)));
    }
    cases.push(approach());
    let flat = cases.iter().map(|case| Case {
        is_curved: false,
        ..case.clone()
    });
    cases.extend(flat.collect::<Vec<_>>());
    cases.push(stroke(if quick { 2 } else { 10 }));
    cases
}

impl Case {
    /// Motions of the spheres from the start to given lengths of the arms.
    pub fn motions(&self, arms: [f64; 2]) -> [Isometry3<f64>; 3] {
        let shifts = [self.start[0] - arms[0], 0.0, arms[1] - self.start[1]];
        shifts.map(|x| Isometry3::translation(x, 0.0, 0.0))
    }

    fn spheres(&self) -> ThreeSpheres {
        ThreeSpheres::new(self.start, CONTAINER)
    }

    /// The bodies at the start.
    pub fn bodies(&self) -> Vec<MovingBody> {
        let spheres = self.spheres().spheres;
        let body = |(name, sphere): (&&str, mesher::Sphere)| MovingBody {
            tag: (*name).to_owned(),
            centre: sphere.centre,
            rotates: false,
        };
        NAMES.iter().zip(spheres).map(body).collect()
    }

    /// Mesh at the start, with elements of `size` on the spheres.
    pub fn mesh(&self, size: f64) -> Result<TetMesh> {
        let spheres = self.spheres();
        let tets = spheres.tets(size, GenerateParams::default().growth)?;
        match self.is_curved {
            true => spheres.curved(tets),
            false => Ok(TetMesh::straight(tets)?),
        }
    }
}
