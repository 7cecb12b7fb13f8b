//! Paths of three spheres on a line, which the meshes must follow.

use ale::MovingBody;
use anyhow::Result;
use mesh::{TetMesh, Vec3};
use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};
use nalgebra::Isometry3;

/// Names of the spheres, which are the tags of their surfaces.
pub const NAMES: [&str; 3] = ["left", "centre", "right"];

/// Radius of the container, in radii of the spheres.
const CONTAINER: f64 = 30.0;

/// A path: lengths of the arms at the start and after each step.
#[derive(Clone, Debug)]
pub struct Case {
    pub key: &'static str,
    /// Whether cells are curved at the spheres.
    pub curved: bool,
    pub title: &'static str,
    pub start: [f64; 2],
    /// Left and right arm after each step.
    pub steps: Vec<[f64; 2]>,
    /// Label of each step in charts.
    pub labels: Vec<f64>,
}

/// Path from `from` to `to` in equal steps, labelled by the completed fraction.
fn straight(
    key: &'static str,
    title: &'static str,
    from: [f64; 2],
    to: [f64; 2],
    steps: usize,
) -> Case {
    let labels: Vec<f64> = (1..=steps).map(|k| k as f64 / steps as f64).collect();
    Case {
        key,
        curved: true,
        title,
        start: from,
        steps: labels
            .iter()
            .map(|s| [0, 1].map(|arm| from[arm] + s * (to[arm] - from[arm])))
            .collect(),
        labels,
    }
}

/// Factor on the gap in a step of the approach.
const APPROACH: f64 = 0.85;

/// The smallest gap of the approach.
pub const SMALLEST_GAP: f64 = 0.02;

/// Both arms close from a gap of three radii; each step reduces the remaining gap by 15 %.
fn approach() -> Case {
    let mut gap: f64 = 3.0;
    let mut labels = Vec::new();
    while gap > SMALLEST_GAP {
        gap = (gap * APPROACH).max(SMALLEST_GAP);
        labels.push(gap);
    }
    Case {
        key: "approach",
        curved: true,
        title: "gaps close from 3 to 0.02, 15 % per step",
        start: [5.0; 2],
        steps: labels.iter().map(|gap| [2.0 + gap; 2]).collect(),
        labels,
    }
}

/// The four-phase stroke with arms of ten and six radii, labelled by completed cycles.
///
/// `steps` is the number of steps per phase.
fn stroke(cycles: usize, steps: usize) -> Case {
    let corners = [[10.0, 10.0], [6.0, 10.0], [6.0, 6.0], [10.0, 6.0]];
    let mut case = Case {
        key: "cycles",
        curved: true,
        title: "ten cycles of the stroke, arms 10 and 6",
        start: corners[0],
        steps: Vec::new(),
        labels: Vec::new(),
    };
    for phase in 0..4 * cycles {
        let (from, to) = (corners[phase % 4], corners[(phase + 1) % 4]);
        for k in 1..=steps {
            let s = k as f64 / steps as f64;
            case.steps
                .push([0, 1].map(|arm| from[arm] + s * (to[arm] - from[arm])));
            case.labels.push((phase as f64 + s) / 4.0);
        }
    }
    case
}

/// Number of steps per phase of the stroke.
pub const STEPS_PER_PHASE: usize = 4;

/// All cases, the short ones also on straight cells; the quick part has two cycles instead of ten.
pub fn all(quick: bool) -> Vec<Case> {
    let (far, close, wide) = ([10.0, 10.0], [5.0, 5.0], [9.0, 9.0]);
    let near = [2.5, 2.5];
    let mut cases = vec![
        straight(
            "move-1",
            "one sphere moves 4 radii, one step",
            far,
            [6.0, 10.0],
            1,
        ),
        straight(
            "move-10",
            "one sphere moves 4 radii, ten steps",
            far,
            [6.0, 10.0],
            10,
        ),
        straight(
            "close-1",
            "arms close from 5 to 2.5, one step",
            close,
            near,
            1,
        ),
        straight(
            "close-10",
            "arms close from 5 to 2.5, ten steps",
            close,
            near,
            10,
        ),
        straight("open-1", "arms open from 5 to 9, one step", close, wide, 1),
        straight(
            "open-10",
            "arms open from 5 to 9, ten steps",
            close,
            wide,
            10,
        ),
        approach(),
    ];
    let flat = cases.iter().map(|case| Case {
        curved: false,
        ..case.clone()
    });
    cases.extend(flat.collect::<Vec<_>>());
    cases.push(stroke(if quick { 2 } else { 10 }, STEPS_PER_PHASE));
    cases
}

impl Case {
    /// Motions of the spheres from the start to given lengths of the arms.
    pub fn motions(&self, arms: [f64; 2]) -> [Isometry3<f64>; 3] {
        let shift = |x: f64| Isometry3::translation(x, 0.0, 0.0);
        [
            shift(self.start[0] - arms[0]),
            shift(0.0),
            shift(arms[1] - self.start[1]),
        ]
    }

    /// The bodies at the start.
    pub fn bodies(&self) -> Vec<MovingBody> {
        let body = |(name, sphere): (&&str, Sphere)| MovingBody {
            tag: (*name).to_owned(),
            centre: sphere.centre,
            rotates: false,
        };
        NAMES.iter().zip(self.spheres()).map(body).collect()
    }

    fn spheres(&self) -> [Sphere; 3] {
        [-self.start[0], 0.0, self.start[1]].map(|x| Sphere {
            centre: Vec3::new(x, 0.0, 0.0),
            radius: 1.0,
        })
    }

    /// Mesh at the start, with elements of `size` on the spheres.
    pub fn mesh(&self, size: f64) -> Result<TetMesh> {
        let spheres = self.spheres();
        let container = Container::Ball(Sphere {
            centre: Vec3::zeros(),
            radius: CONTAINER,
        });
        let bodies: Vec<MeshedBody> = spheres
            .iter()
            .zip(NAMES)
            .map(|(surface, name)| MeshedBody {
                name,
                surface,
                size,
            })
            .collect();
        let tets = generate(&bodies, &container, &GenerateParams::default())?.mesh;
        let mut surfaces: Vec<mesh::NamedSurface> =
            bodies.iter().map(|b| (b.name, b.surface)).collect();
        surfaces.push((Container::TAG, container.surface()));
        Ok(match self.curved {
            true => TetMesh::curved(tets, &surfaces)?,
            false => TetMesh::straight(tets)?,
        })
    }
}
