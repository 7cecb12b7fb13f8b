//! Measurement of the mesh motions on the meshes of files.

use std::time::Instant;

use ale::{AleError, ReferenceMap};
use anyhow::{Result, bail};
use mesh::{TetMesh, Vec3};

use super::file_cases::{FileMesh, Placement};
use super::methods::Method;

/// Smallest Jacobian of a cell, relative to its mean, that the program accepts in a moved mesh.
const MIN_JACOBIAN: f64 = 0.2;

/// Smallest mean ratio of a cell that the program accepts in a moved mesh.
const MIN_QUALITY: f64 = 0.1;

/// Largest length of a cell in a gap, relative to its width, that the program accepts.
const MAX_GAP_RATIO: f64 = 1.5;

/// Relative deterioration that the program accepts in meshes that exceed these limits themselves.
const ALWAYS_ALLOWED: f64 = 0.9;

/// Distance that a swimmer with the default stroke covers in twenty cycles.
const TWENTY_CYCLES: f64 = 3.2;

/// Gaps that arms close to, in radii.
const GAPS: [f64; 14] = [
    4.0, 3.0, 2.5, 2.0, 1.75, 1.5, 1.25, 1.0, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3,
];

/// A moved mesh.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    pub quality: f64,
    pub jacobian: f64,
    pub gap_ratio: f64,
}

/// How far a motion takes the mesh of a file.
pub struct Reach {
    pub method: &'static str,
    /// Smallest quality and Jacobian and largest gap ratio over the cycle in which arms close by
    /// four tenths; `None` if a cell is inverted.
    pub stroke: Option<Shape>,
    /// Whether the program accepts all meshes of this cycle, and of the same cycle after the
    /// swimmer has covered the distance of twenty.
    pub accepted: [bool; 2],
    /// Whether the mesh of the initial configuration is that of the file, bit for bit.
    pub returns: bool,
    /// The smallest gap that the program accepts when both arms close, and the left one only.
    pub gaps: [Option<f64>; 2],
    /// Distances by which both arms open, and by which the left sphere moves sideways.
    pub distances: [f64; 2],
    pub iterations: usize,
    /// Seconds of set-up.
    pub setup: f64,
}

/// A motion on a mesh, and the mesh before it.
struct Moving<'a> {
    file: &'a FileMesh,
    map: ReferenceMap,
    start: Shape,
}

impl Moving<'_> {
    /// The mesh of a placement; `None` if a cell is inverted.
    fn shape(&self, placement: Placement) -> Result<Option<Shape>> {
        match self.map.moved(&self.file.motions(placement)) {
            Ok(moved) => Ok(Some(shape(self.file, &moved, placement))),
            Err(AleError::Invalid(_)) => Ok(None),
            Err(other) => Err(other.into()),
        }
    }

    fn is_accepted(&self, shape: Shape) -> bool {
        shape.jacobian >= MIN_JACOBIAN.min(ALWAYS_ALLOWED * self.start.jacobian)
            && shape.quality >= MIN_QUALITY.min(ALWAYS_ALLOWED * self.start.quality)
            && shape.gap_ratio <= MAX_GAP_RATIO.max(self.start.gap_ratio / ALWAYS_ALLOWED)
    }

    /// The worst values over a cycle in which the arms close by four tenths one after the other.
    fn cycle(&self, shift: f64) -> Result<Option<Shape>> {
        let [left, right] = self.file.arms();
        let corners = [[1.0, 1.0], [0.6, 1.0], [0.6, 0.6], [1.0, 0.6]];
        let mut worst = self.start;
        for phase in 0..4 {
            let (from, to) = (corners[phase], corners[(phase + 1) % 4]);
            for s in [0.5, 1.0] {
                let factor = [0, 1].map(|k| from[k] + s * (to[k] - from[k]));
                let placement = Placement {
                    arms: [factor[0] * left, factor[1] * right],
                    shift: shift * Vec3::x(),
                    sideways: 0.0,
                };
                let Some(shape) = self.shape(placement)? else {
                    return Ok(None);
                };
                worst = Shape {
                    quality: worst.quality.min(shape.quality),
                    jacobian: worst.jacobian.min(shape.jacobian),
                    gap_ratio: worst.gap_ratio.max(shape.gap_ratio),
                };
            }
        }
        Ok(Some(worst))
    }

    /// The last value on a path for which, and for all before, the program accepts the mesh.
    fn last_accepted(
        &self,
        path: impl IntoIterator<Item = f64>,
        placement: impl Fn(f64) -> Placement,
    ) -> Result<Option<f64>> {
        let mut last = None;
        for value in path {
            match self.shape(placement(value))? {
                Some(shape) if self.is_accepted(shape) => last = Some(value),
                _ => break,
            }
        }
        Ok(last)
    }
}

fn shape(file: &FileMesh, mesh: &TetMesh, placement: Placement) -> Shape {
    let quality = mesh.quality();
    Shape {
        quality: quality.min_quality,
        jacobian: quality.min_jacobian,
        gap_ratio: file.gap_ratio(mesh, placement),
    }
}

/// Measures a motion on a mesh; `None` if the motion does not support the mesh.
pub fn reach(file: &FileMesh, method: &Method) -> Result<Option<Reach>> {
    let clock = Instant::now();
    let motion = (method.make)();
    let map = match ReferenceMap::new(file.mesh.clone(), &file.bodies(), motion.as_ref()) {
        Ok(map) => map,
        Err(AleError::TooManyCentres { .. }) => return Ok(None),
        Err(other) => return Err(other.into()),
    };
    let setup = clock.elapsed().as_secs_f64();
    let still = file.at_rest();
    let start = shape(file, &file.mesh, still);
    let moving = Moving { file, map, start };
    let [stroke, drifted] = [moving.cycle(0.0)?, moving.cycle(TWENTY_CYCLES)?];
    let Ok(returned) = moving.map.moved(&file.motions(still)) else {
        bail!("{}: the mesh itself is not valid", file.name);
    };
    let arms = file.arms();
    let closed = |gap: f64| 2.0 * file.radius() + gap;
    let gaps = GAPS.into_iter();
    let gaps = gaps.filter(|&gap| closed(gap) < arms[0].min(arms[1]));
    // Larger moves leave the container.
    let steps = || (1..=12).map(|k| 0.5 * f64::from(k));
    Ok(Some(Reach {
        method: method.name,
        accepted: [stroke, drifted].map(|s| s.is_some_and(|s| moving.is_accepted(s))),
        stroke,
        returns: returned.points() == file.mesh.points(),
        gaps: [
            moving.last_accepted(gaps.clone(), |gap| Placement {
                arms: [closed(gap); 2],
                ..still
            })?,
            moving.last_accepted(gaps, |gap| Placement {
                arms: [closed(gap), arms[1]],
                ..still
            })?,
        ],
        distances: [
            moving.last_accepted(steps(), |x| Placement {
                arms: arms.map(|arm| arm + x),
                ..still
            })?,
            moving.last_accepted(steps(), |y| Placement {
                sideways: y,
                ..still
            })?,
        ]
        .map(|distance| distance.unwrap_or(0.0)),
        iterations: moving.map.iterations(),
        setup,
    }))
}
