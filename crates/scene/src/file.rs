//! The keys of a scene file as serde reads and writes them.
//!
//! A key is an `Option` if it has no default, or if being present without need is an error. The
//! defaults of all other keys are here and in [`crate::options`].

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::design::{LearnOptions, OptimiseOptions};
use crate::options::{FemOptions, ModelOptions};
use crate::words::{
    ArmsKind, BackgroundKind, DomainKind, DriveKind, GaitKind, InterpolationKind, JointWord,
    ShapeKind, SurfaceKind,
};

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct SceneFile {
    #[serde(skip_serializing_if = "is_zero")]
    pub gravity: [f64; 3],
    pub fluid: FluidFile,
    pub domain: DomainFile,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub background: Option<BackgroundFile>,
    pub bodies: Vec<BodyFile>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub links: Vec<JointFile>,
    pub gait: GaitFile,
    pub model: ModelOptions,
    pub fem: FemOptions,
    pub optimise: OptimiseOptions,
    pub learn: LearnOptions,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct FluidFile {
    pub viscosity: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
}

/// Keys of the group `background`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct BackgroundFile {
    pub kind: Option<BackgroundKind>,
    pub velocity: Option<[f64; 3]>,
    pub gradient: Option<[[f64; 3]; 3]>,
}

/// Keys of the group `bodies[].slip`.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct SlipFile {
    pub b1: f64,
    pub b2: f64,
    pub axis: [f64; 3],
}

impl Default for SlipFile {
    fn default() -> Self {
        Self {
            b1: 0.0,
            b2: 0.0,
            axis: DEFAULT_AXIS,
        }
    }
}

impl Default for FluidFile {
    fn default() -> Self {
        Self {
            viscosity: 1.0,
            density: None,
        }
    }
}

/// Keys of the group `domain`.
///
/// If `kind` is absent, it has its default, and any other key of the group is an error.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct DomainFile {
    pub kind: Option<DomainKind>,
    pub radius: Option<f64>,
    pub size: Option<[f64; 3]>,
    pub file: Option<String>,
    pub surface_kind: Option<SurfaceKind>,
    pub scale: Option<f64>,
    pub walls: Option<Vec<String>>,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct BodyFile {
    pub name: Option<String>,
    pub shape: ShapeKind,
    pub radius: Option<f64>,
    pub semi_axes: Option<[f64; 3]>,
    pub half_length: Option<f64>,
    pub tube_radius: Option<f64>,
    pub pitch: Option<f64>,
    pub turns: Option<f64>,
    pub file: Option<String>,
    pub surface_kind: Option<SurfaceKind>,
    pub scale: Option<f64>,
    pub centre: Option<[f64; 3]>,
    pub axis: Option<[f64; 3]>,
    pub orientation: Option<[f64; 3]>,
    pub position: Option<[f64; 3]>,
    pub surface: Option<String>,
    pub force: [f64; 3],
    pub torque: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "is_false")]
    pub fixed: bool,
    pub mass: f64,
    pub inertia: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slip: Option<SlipFile>,
}

/// Default of `bodies[].axis`, which only bodies of revolution have.
pub(crate) const DEFAULT_AXIS: [f64; 3] = [1.0, 0.0, 0.0];

/// Default of `bodies[].orientation`, which spheres and points do not have.
pub(crate) const DEFAULT_ORIENTATION: [f64; 3] = [0.0; 3];

/// Default of `bodies[].torque`, which points do not have.
pub(crate) const DEFAULT_TORQUE: [f64; 3] = [0.0; 3];

fn is_false(flag: &bool) -> bool {
    !flag
}

fn is_zero(vector: &[f64; 3]) -> bool {
    *vector == [0.0; 3]
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct JointFile {
    pub name: Option<String>,
    pub body: Option<String>,
    pub to: Option<String>,
    #[serde(default)]
    pub joint: JointWord,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pivot: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pitch: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drive: Option<DriveKind>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force: Option<ForceFile>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
}

/// Value of `links[].force`.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(untagged)]
pub(crate) enum ForceFile {
    Constant(f64),
    Harmonic(HarmonicForceFile),
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct HarmonicForceFile {
    pub mean: f64,
    pub amplitude: Option<f64>,
    pub phase: f64,
    pub order: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period: Option<f64>,
}

impl Default for HarmonicForceFile {
    fn default() -> Self {
        Self {
            mean: 0.0,
            amplitude: None,
            phase: 0.0,
            order: 1,
            period: None,
        }
    }
}

/// Keys of the group `gait`. If `phases` or `harmonics` is present, it must not be empty.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct GaitFile {
    pub arms: ArmsKind,
    pub cycles: u32,
    pub periodic: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phases: Option<Vec<PhaseFile>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kind: Option<GaitKind>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interpolation: Option<InterpolationKind>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub harmonics: Option<Vec<HarmonicFile>>,
}

impl Default for GaitFile {
    fn default() -> Self {
        Self {
            arms: ArmsKind::default(),
            cycles: 1,
            periodic: false,
            phases: None,
            kind: None,
            file: None,
            interpolation: None,
            period: None,
            harmonics: None,
        }
    }
}

#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct HarmonicFile {
    pub link: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean: Option<f64>,
    pub amplitude: Option<f64>,
    pub phase: f64,
    pub order: u32,
}

impl Default for HarmonicFile {
    fn default() -> Self {
        Self {
            link: None,
            mean: None,
            amplitude: None,
            phase: 0.0,
            order: 1,
        }
    }
}

#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct PhaseFile {
    pub link: Option<String>,
    pub length: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub targets: Option<BTreeMap<String, f64>>,
    pub duration: f64,
}

impl Default for PhaseFile {
    fn default() -> Self {
        Self {
            link: None,
            length: None,
            targets: None,
            duration: 1.0,
        }
    }
}
