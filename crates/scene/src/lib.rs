#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod arrangement;
mod body;
mod body_check;
mod builder;
mod checks;
mod contact;
mod deformation;
mod deformed_surface;
mod document;
mod domain;
mod error;
mod farthest_point;
mod flow;
mod frames;
mod gait;
mod gait_table;
mod harmonics;
mod hull_distance;
mod joints;
pub mod keys;
mod loads;
mod material_motion;
mod nearest;
mod octahedral;
mod path_contact;
mod periodic_flow;
mod phase_span;
mod positive_directions;
mod radial_profile;
mod read;
mod scene;
mod shape;
mod shape_path;
mod shapes;
mod sphere_deformation;
mod spline;
mod spline_path;
mod star_surface;
mod surface_modes;
mod surface_shape;
mod thermal_noise;
mod triangle_deformation;
mod undulation;
mod wall_facets;
mod words;
mod write;

pub use arrangement::Arrangement;
pub use body::Body;
pub use builder::SceneBuilder;
pub use contact::{Contact, Repulsion, closest_contact, contacts};
pub use deformation::{Deformation, DeformedBody, Undulation};
pub use document::Document;
pub use domain::Domain;
pub use error::SceneError;
pub use flow::{Background, Slip};
pub use frames::Frames;
pub use gait::{Gait, Phase, spans};
pub use harmonics::{Harmonic, MAX_MODE_DEGREE};
pub use keys::{
    FemOptions, JointValues, LearnOptions, ModelOptions, OptimiseOptions, OutputOptions,
};
pub use loads::{DrivingLoad, VectorOscillation};
pub use material_motion::{MaterialMotion, MaterialPoint, ShapeCoordinate};
pub use path_contact::{BodyPath, PathContact, first_contact};
pub use phase_span::PhaseSpan;
pub use radial_profile::RadialProfile;
pub use scene::{FluidInertia, Rheology, Scene};
pub use shape::Shape;
pub use shape_path::{JointForce, JointPath, OwnPath, ShapePath, Sine};
pub use shapes::*;
pub use sphere_deformation::{SizeCoordinate, SphereDeformation};
pub use spline_path::SplinePath;
pub use surface_modes::SurfaceModes;
pub use surface_shape::{SourceFile, SurfaceShape};
pub use thermal_noise::ThermalNoise;
pub use triangle_deformation::{TriangleDeformation, TriangleShape};
pub use undulation::{Bend, BentLine, Wave};
pub use wall_facets::WallFacets;
pub use words::{
    AcceptKind, ArmsKind, BackgroundKind, DomainKind, EnvelopeKind, EstimatesKind, FlowsKind,
    FormulationKind, GaitKind, GeometryKind, InertiaKind, InterpolationKind, LawKind, LearnKind,
    MeshMotionKind, MesherKind, ModeMotion, ModelEstimatesKind, ModelKind, ObjectiveKind,
    RheologyKind, ShapeKind, SolverKind, StartKind, StrokeStart, SurfaceKind, SymmetryKind,
    TrajectoryKind, WaveKind,
};

// joints, surfaces, viscosity laws and vectors are part of this crate's interface
pub use {mesher, nalgebra, rheology, rigid};
