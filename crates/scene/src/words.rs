//! Words that are values of keys of a scene file, and their meanings.
//!
//! The word of a variant is its name in kebab case: `FormulationKind::PTilde` is `"p-tilde"`.

use serde::{Deserialize, Serialize};
use strum::{IntoStaticStr, VariantNames};

/// Gives the enums of this file their words as inherent items.
macro_rules! words {
    ($($kind:ident),+) => { $(
        impl $kind {
            /// All words, in the order of the variants.
            pub const WORDS: &[&str] = <Self as VariantNames>::VARIANTS;

            /// The word of the scene file.
            pub fn word(self) -> &'static str {
                self.into()
            }
        }
    )+ };
}

pub(crate) use words;

words!(
    DomainKind,
    BackgroundKind,
    ShapeKind,
    SurfaceKind,
    ArmsKind,
    JointWord,
    DriveKind,
    GaitKind,
    InterpolationKind,
    ModelKind,
    AcceptKind,
    FormulationKind,
    SolverKind,
    MeshMotionKind,
    MesherKind,
    GeometryKind,
    SymmetryKind,
    EstimatesKind
);

/// Kind of domain: where the fluid is.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum DomainKind {
    /// The whole space.
    #[default]
    Unbounded,
    /// The interior of a ball.
    Ball,
    /// The interior of a box.
    Box,
    /// The interior of an infinite circular cylinder.
    Cylinder,
    /// The half-space above a plane.
    Wall,
    /// The interior of a closed surface in a file.
    Surface,
    /// The volume of a mesh file.
    Mesh,
}

/// Kind of background flow.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum BackgroundKind {
    /// The same velocity everywhere.
    Uniform,
    /// A constant gradient of the velocity.
    Shear,
    /// A constant gradient of the velocity without rotation: a symmetric one.
    Extension,
    /// Poiseuille flow along the tube that is the domain.
    Poiseuille,
}

/// Kind of body.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum ShapeKind {
    /// A sphere.
    #[default]
    Sphere,
    /// An ellipsoid.
    Ellipsoid,
    /// A spheroid.
    Spheroid,
    /// A cylinder closed by hemispheres.
    Capsule,
    /// A disk with a round rim.
    Disk,
    /// A torus.
    Torus,
    /// A tube with round ends along a helix.
    Helix,
    /// A closed surface in a file.
    Surface,
    /// A part of the boundary of the domain's mesh, as it is.
    File,
    /// A massless point without a surface.
    Point,
}

/// How the triangles of a surface in a file are understood; see [`mesher::TriangleKind`].
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum SurfaceKind {
    /// Curved through the vertices, with edges above 40 degrees kept sharp.
    #[default]
    Smooth,
    /// Flat triangles.
    Faceted,
}

impl From<SurfaceKind> for mesher::TriangleKind {
    fn from(kind: SurfaceKind) -> Self {
        match kind {
            SurfaceKind::Smooth => Self::Smooth,
            SurfaceKind::Faceted => Self::Faceted,
        }
    }
}

/// How a gait is given.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum GaitKind {
    /// Phases with constant rates.
    #[default]
    Phases,
    /// Sums of sines.
    Harmonic,
    /// A file with times and joint values.
    Table,
}

/// Interpolation of the values between the rows of a table.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum InterpolationKind {
    /// A cubic spline with two continuous derivatives, periodic if the last row is the first one.
    #[default]
    Cubic,
    /// The same spline with a corner where the cycle begins, also if the last row is the first one.
    Corner,
    /// Constant rates between rows.
    Linear,
}

/// Attachment of bodies to arms that rotate; see [`rigid::Arms`].
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum ArmsKind {
    /// Bodies keep their orientation relative to the frame of the swimmer.
    #[default]
    Clamped,
    /// Bodies rotate freely.
    Free,
    /// Arms keep their direction in the laboratory frame.
    Lab,
}

/// Relative motion that a joint allows.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum JointWord {
    /// The distance of the two centres changes along their line.
    #[default]
    Slide,
    /// Rotation about an axis through a pivot.
    Hinge,
    /// Rotation about an axis through the centre of the body.
    Rotor,
    /// Free rotation about a pivot.
    Ball,
    /// Rotation about an axis with a proportional translation along it.
    Screw,
    /// No relative motion.
    Fixed,
}

/// What determines the value of a joint.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum DriveKind {
    /// The gait prescribes it.
    #[default]
    Prescribed,
    /// A spring acts on it.
    Spring,
    /// A constant force or torque acts on it.
    Force,
    /// It moves freely.
    Free,
}

/// Model of the flow.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum ModelKind {
    /// The cheapest model that meets the tolerance.
    #[default]
    Auto,
    /// Point forces (Oseen tensor).
    Oseen,
    /// Rotne-Prager-Yamakawa tensor.
    Rpy,
    /// Multipole expansions.
    Multipole,
    /// Finite elements in the meridian plane.
    Axisymmetric,
    /// Finite elements in three dimensions.
    Fem,
}

/// What a run does with a result whose error bar is larger than the tolerance.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum AcceptKind {
    /// The run fails and reports what was reached.
    #[default]
    Tolerance,
    /// The best result is accepted with a warning.
    Best,
}

/// Method by which the finite-element model imposes the constraints of the joints.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum FormulationKind {
    /// Elimination of the relative velocities.
    #[default]
    PTilde,
    /// Lagrange multipliers.
    Lagrange,
    /// Constraint rows that replace rows of the system.
    DirectRow,
}

/// Solver for the linear systems of the finite-element model.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum SolverKind {
    /// Krylov method with the block preconditioner.
    #[default]
    Block,
    /// Sparse factorisation.
    Direct,
    /// Krylov method with additive Schwarz.
    Schwarz,
    /// Minimal residuals with the block-diagonal preconditioner, for symmetric formulations.
    Minres,
}

/// Method by which the finite-element model moves its mesh with the bodies.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum MeshMotionKind {
    /// Diffusion with the coefficient of Kanchi & Masud; for the mesh of a file the biharmonic
    /// equation, and other methods where cells become too poor.
    #[default]
    Auto,
    /// Laplace's equation.
    Laplace,
    /// Diffusion with the coefficient of Kanchi & Masud.
    KanchiMasud,
    /// Diffusion with the reciprocal of the element volume as coefficient.
    InverseVolume,
    /// Linear elasticity with small elements stiffer than large ones.
    Elastic,
    /// The biharmonic equation.
    Biharmonic,
    /// Cubic radial basis functions.
    Rbf,
}

/// Program that meshes the fluid again inside the walls of a mesh file.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum MesherKind {
    /// The generator of this project.
    #[default]
    Auto,
    /// The command `gmsh`, where the generator of this project has no mesh.
    Gmsh,
}

/// Shape of the elements at the surfaces of the bodies.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum GeometryKind {
    /// Isoparametric quadratic elements.
    #[default]
    Curved,
    /// Elements with flat facets.
    Straight,
}

/// Whether the finite-element model uses symmetry planes.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum SymmetryKind {
    /// The whole fluid is meshed.
    Off,
    /// One side of each symmetry plane is meshed.
    #[default]
    Auto,
}

/// Whether discretisation errors are estimated.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum EstimatesKind {
    /// Errors are estimated for every reported result.
    #[default]
    On,
    /// Errors are not estimated.
    Off,
}

impl From<ArmsKind> for rigid::Arms {
    fn from(kind: ArmsKind) -> Self {
        match kind {
            ArmsKind::Clamped => Self::Clamped,
            ArmsKind::Free => Self::Free,
            ArmsKind::Lab => Self::Lab,
        }
    }
}

impl From<rigid::Arms> for ArmsKind {
    fn from(arms: rigid::Arms) -> Self {
        match arms {
            rigid::Arms::Clamped => Self::Clamped,
            rigid::Arms::Free => Self::Free,
            rigid::Arms::Lab => Self::Lab,
        }
    }
}

#[cfg(test)]
mod tests;
