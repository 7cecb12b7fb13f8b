#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod arrangement;
mod body;
mod builder;
mod centroid;
mod contact;
mod design;
mod design_words;
mod differences;
mod document;
mod domain;
mod error;
mod file;
mod file_names;
mod flow;
mod gait;
mod gait_table;
mod joint_force;
mod joint_path;
pub mod keys;
mod nearest;
mod options;
mod output_words;
mod phase_span;
mod read;
mod scene;
mod shape;
mod shape_path;
mod shape_surface;
mod spline;
mod support;
mod surface_shape;
mod words;
mod write;

pub use arrangement::Arrangement;
pub use body::Body;
pub use builder::SceneBuilder;
pub use contact::{Contact, closest_contact, contacts};
pub use design::{JointValues, LearnOptions, OptimiseOptions};
pub use design_words::{LearnKind, ObjectiveKind, StrokeStart};
pub use document::Document;
pub use domain::Domain;
pub use error::SceneError;
pub use flow::{Background, Slip};
pub use gait::{Gait, Phase, spans};
pub use joint_force::JointForce;
pub use joint_path::{JointPath, OwnPath};
pub use options::{FemOptions, ModelOptions};
pub use output_words::FlowsKind;
pub use phase_span::PhaseSpan;
pub use scene::Scene;
pub use shape::Shape;
pub use shape_path::{CubicLength, ShapePath, Sine};
pub use surface_shape::SurfaceShape;
pub use words::{
    AcceptKind, ArmsKind, BackgroundKind, DomainKind, EstimatesKind, FormulationKind, GaitKind,
    GeometryKind, InterpolationKind, MeshMotionKind, MesherKind, ModelKind, ShapeKind, SolverKind,
    SurfaceKind, SymmetryKind,
};
