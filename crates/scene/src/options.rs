//! Options of the computation, with their defaults.

use serde::{Deserialize, Serialize};

use crate::output_words::FlowsKind;
use crate::words::{
    AcceptKind, EstimatesKind, FormulationKind, GeometryKind, MeshMotionKind, MesherKind,
    ModelKind, SolverKind, SymmetryKind,
};

/// Options of the flow model: the group `model` of a scene file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct ModelOptions {
    /// Model of the flow.
    pub kind: ModelKind,
    /// Tolerated relative error of the net displacement per cycle.
    pub tolerance: f64,
    /// What a run does with a result whose error bar is larger than the tolerance.
    pub accept: AcceptKind,
}

impl Default for ModelOptions {
    fn default() -> Self {
        Self {
            kind: ModelKind::default(),
            // Figures and comparisons with published strokes need three digits.
            tolerance: 1e-3,
            accept: AcceptKind::default(),
        }
    }
}

/// Options of the finite-element model: the group `fem` of a scene file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct FemOptions {
    /// Method by which the constraints of the joints are imposed.
    pub formulation: FormulationKind,
    /// Solver of the linear systems.
    pub solver: SolverKind,
    /// Number of subdomains of additive Schwarz.
    pub subdomains: u32,
    /// Layers of overlap of additive Schwarz.
    pub overlap: u32,
    /// Relative true residual at which a solve stops.
    pub rtol: f64,
    /// Element size on the surfaces of the bodies; the model chooses it if it is `None`.
    pub surface_size: Option<f64>,
    /// Factor on the element sizes on all bodies.
    pub size_factor: Option<f64>,
    /// Target of the relative discretisation error.
    ///
    /// Meshes are refined until they meet it, unless `size_factor` is given.
    pub target: Option<f64>,
    /// Whether discretisation errors are estimated.
    pub estimates: EstimatesKind,
    /// Shape of the elements at the surfaces of the bodies.
    pub geometry: GeometryKind,
    /// Method by which the mesh moves with the bodies.
    pub mesh_motion: MeshMotionKind,
    /// Program that meshes the fluid again inside the walls of a mesh file.
    pub mesher: MesherKind,
    /// Whether symmetry planes are used.
    pub symmetry: SymmetryKind,
    /// Flows that a run writes for ParaView.
    pub flows: FlowsKind,
}

impl Default for FemOptions {
    fn default() -> Self {
        Self {
            formulation: FormulationKind::default(),
            solver: SolverKind::default(),
            subdomains: 8,
            overlap: 1,
            rtol: 1e-8,
            surface_size: None,
            size_factor: None,
            target: None,
            estimates: EstimatesKind::default(),
            geometry: GeometryKind::default(),
            mesh_motion: MeshMotionKind::default(),
            mesher: MesherKind::default(),
            symmetry: SymmetryKind::default(),
            flows: FlowsKind::default(),
        }
    }
}
