//! The keys of a scene file as serde sees them: everything optional, nothing judged.

use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct SceneFile {
    pub fluid: FluidFile,
    pub domain: DomainFile,
    pub bodies: Vec<BodyFile>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub links: Vec<LinkFile>,
    pub gait: GaitFile,
    pub model: ModelFile,
    pub fem: FemFile,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct FluidFile {
    pub viscosity: Option<f64>,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct DomainFile {
    pub kind: Option<String>,
    pub radius: Option<f64>,
    pub size: Option<[f64; 3]>,
    pub file: Option<String>,
    pub walls: Option<Vec<String>>,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct BodyFile {
    pub name: Option<String>,
    pub shape: Option<String>,
    pub radius: Option<f64>,
    pub half_length: Option<f64>,
    pub axis: Option<[f64; 3]>,
    pub position: Option<[f64; 3]>,
    pub surface: Option<String>,
    pub force: Option<[f64; 3]>,
    pub torque: Option<[f64; 3]>,
    pub fixed: Option<bool>,
    pub mass: Option<f64>,
    pub inertia: Option<f64>,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct LinkFile {
    pub name: Option<String>,
    pub body: Option<String>,
    pub to: Option<String>,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct GaitFile {
    pub arms: Option<String>,
    pub cycles: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phases: Option<Vec<PhaseFile>>,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct PhaseFile {
    pub link: Option<String>,
    pub length: Option<f64>,
    pub duration: Option<f64>,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct ModelFile {
    pub kind: Option<String>,
    pub tolerance: Option<f64>,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct FemFile {
    pub formulation: Option<String>,
    pub solver: Option<String>,
    pub subdomains: Option<u32>,
    pub overlap: Option<u32>,
    pub rtol: Option<f64>,
    pub surface_size: Option<f64>,
    pub size_factor: Option<f64>,
    pub target: Option<f64>,
    pub estimates: Option<String>,
    pub geometry: Option<String>,
    pub mesh_motion: Option<String>,
    pub mirror: Option<String>,
}
