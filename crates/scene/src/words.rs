//! Words that are values of keys of a scene file, and their meanings.
//!
//! A word is one variant: its name in kebab case is what the file says (`FormulationKind::PTilde`
//! is `"p-tilde"`), and its documentation is the meaning in `docs/scene.md`.

use serde::{Deserialize, Serialize};
use strum::VariantNames;

use crate::keys::{KeyType, Kind, Words};

/// Defines enums of words; `= Variant` after the name is the default.
macro_rules! words {
    ($(
        $(#[doc = $doc:literal])+
        pub enum $name:ident $(= $default:ident)? {
            $( $(#[doc = $meaning:literal])+ $variant:ident, )+
        }
    )+) => { $(
        $(#[doc = $doc])+
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, VariantNames)]
        #[serde(rename_all = "kebab-case")]
        #[strum(serialize_all = "kebab-case")]
        pub enum $name {
            $( $(#[doc = $meaning])+ $variant, )+
        }

        impl $name {
            /// All words, in the order of the variants.
            pub const WORDS: &[&str] = <Self as VariantNames>::VARIANTS;

            /// The word of the scene file.
            pub const fn word(self) -> &'static str {
                Self::WORDS[self as usize]
            }
        }

        $(impl Default for $name {
            fn default() -> Self {
                Self::$default
            }
        })?

        impl KeyType for $name {
            const KIND: Kind = Kind::Word(Words {
                words: Self::WORDS,
                meanings: &[$(concat!($($meaning),+).trim_ascii()),+],
            });
            const DEFAULT: &'static str = [$(Self::$default.word(),)? ""][0];

            #[cfg(test)]
            fn check_words() {
                let Kind::Word(Words { words, meanings }) = Self::KIND else {
                    panic!("{:?}", Self::KIND);
                };
                assert_eq!(words.len(), meanings.len());
                for (number, &word) in Self::WORDS.iter().enumerate() {
                    let text = toml::Value::String(word.to_owned());
                    let kind: Self = text.clone().try_into().unwrap();
                    assert_eq!((kind as usize, kind.word()), (number, word));
                    assert_eq!(toml::Value::try_from(kind).unwrap(), text);
                }
            }
        }
    )+ };
}

/// Defines [`ShapeKind`] from the list of shapes.
macro_rules! shape_words {
    ($( $(#[doc = $meaning:literal])+ $kind:ident $name:ident, )+) => {
        words! {
            /// Kind of body.
            pub enum ShapeKind = Sphere {
                $( $(#[doc = $meaning])+ $kind, )+
            }
        }
    };
}
crate::shapes::list!(shape_words);
pub(crate) use words;

words! {
    /// Kind of domain: where the fluid is.
    pub enum DomainKind = Unbounded {
        /// The whole space.
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
        /// A box that is repeated with its bodies in all directions.
        Periodic,
    }

    /// How the surface of a body deforms.
    pub enum DeformationWord = Modes {
        /// By its radius, which every sphere offers without this table too.
        Radius,
        /// By its volume, which every sphere offers without this table too.
        Volume,
        /// By modes that are symmetric about an axis.
        Modes,
        /// By a wave along the centreline of a tube.
        Undulation,
        /// Of a surface of a file, through the shapes of other files with the same triangles.
        Frames,
    }

    /// What a wave changes along the centreline of a tube of the length L, with the length of arc s
    /// from its front, the wave number k, the amplitude a, the phase φ and the envelope g.
    pub enum WaveKind = Curvature {
        /// The curvature a k g cos(k s - φ) in the tube's own plane of x and y.
        Curvature,
        /// The displacement (a / k) g sin(k s - φ) across the axis, along the tube's own y axis.
        Displacement,
        /// The displacements (a / k) g sin(k s - φ) along y and -(a / k) g cos(k s - φ) along z: a
        /// right-handed helix.
        Helix,
        /// The mirror image with (a / k) g cos(k s - φ) along z: a left-handed helix.
        LeftHelix,
    }

    /// Envelope g of a wave along a tube.
    pub enum EnvelopeKind = Uniform {
        /// One along the whole length.
        Uniform,
        /// s / L: zero at the front, one at the end.
        Linear,
    }

    /// How modes move the material points of a sphere of radius R, with the angle θ from the axis
    /// and the harmonic Y of each mode: the Legendre polynomial P(cos θ) of its degree if it has no
    /// order.
    pub enum ModeMotion = Radial {
        /// Along the radius to R (1 + a Y + ..).
        Radial,
        /// Along the radius to R (1 + 3 a Y + ..)^(1/3), which keeps the volume.
        Isochoric,
        /// Along the surface to the angle θ + a sin(n θ) + .., with the degree n of each mode,
        /// which has no order.
        Tangential,
        /// Along the great circle in the direction of v = a ∇Y + .., by the angle |v|, with the
        /// gradient along the sphere of radius one.
        Gradient,
        /// The same with v = a n × ∇Y + .. and the outward normal n, which has no divergence.
        Curl,
    }

    /// Inertia of the fluid, and of the bodies that have a density.
    pub enum InertiaKind = None {
        /// Stokes flow: the fluid has no inertia.
        None,
        /// Stokes flow, if its inertia would change the net displacement of a run by less than the
        /// tolerance leaves; otherwise the Navier-Stokes equations.
        Auto,
        /// Unsteady Stokes flow: with the rate of change of the velocity, without convection.
        Unsteady,
        /// The Navier-Stokes equations.
        Full,
    }

    /// Viscosity as a function of the shear rate `g`, the square root of `2 D:D`.
    pub enum LawKind = Newtonian {
        /// A constant `viscosity`.
        Newtonian,
        /// `inf + (zero - inf) (1 + (t g)^2)^((n - 1) / 2)`, with `zero_shear_viscosity`,
        /// `infinite_shear_viscosity`, `relaxation_time` and `index`.
        Carreau,
        /// As `carreau`, `inf + (zero - inf) (1 + (t g)^a)^((n - 1) / a)` with `transition`.
        CarreauYasuda,
        /// `inf + (zero - inf) / (1 + (t g)^(1 - n))`, with the keys of `carreau`.
        Cross,
        /// `consistency g^(index - 1)`.
        PowerLaw,
        /// `yield_stress / g + consistency g^(index - 1)`.
        HerschelBulkley,
    }

    /// Whether flows follow the viscosity law.
    pub enum RheologyKind = Full {
        /// Flows have the constant viscosity at rest, and results say what the law would change.
        Newtonian,
        /// As `newtonian`, if the law would change the net displacement of a run by less than the
        /// tolerance leaves; otherwise `full`.
        Auto,
        /// Flows follow the law.
        Full,
    }

    /// Flow at the start of a run with inertia.
    pub enum StartKind = Rest {
        /// Fluid and bodies are at rest, and the motion begins with a jump.
        Rest,
        /// Stokes flow of the motion that begins.
        Stokes,
    }

    /// Kind of background flow.
    pub enum BackgroundKind {
        /// The same velocity everywhere.
        Uniform,
        /// A mean pressure gradient in a periodic box: the mean flow is a result.
        PressureGradient,
        /// A constant gradient of the velocity.
        Shear,
        /// A constant gradient of the velocity without rotation: a symmetric one.
        Extension,
        /// Poiseuille flow along the tube that is the domain.
        Poiseuille,
    }

    /// How the triangles of a surface in a file are understood; see [`mesher::TriangleKind`].
    pub enum SurfaceKind = Smooth {
        /// Curved through the vertices, with edges above 40 degrees kept sharp.
        Smooth,
        /// Flat triangles.
        Faceted,
    }

    /// How a gait is given.
    pub enum GaitKind = Phases {
        /// Phases with constant rates.
        Phases,
        /// Sums of sines.
        Harmonic,
        /// A file with times and joint values.
        Table,
    }

    /// Interpolation of the values between the rows of a table.
    pub enum InterpolationKind = Cubic {
        /// A cubic spline with two continuous derivatives, periodic if the last row is the first
        /// one.
        Cubic,
        /// The same spline with a corner where the cycle begins, also if the last row is the first
        /// one.
        Corner,
        /// Constant rates between rows.
        Linear,
    }

    /// Attachment of bodies to arms that rotate; see [`rigid::Arms`].
    pub enum ArmsKind = Clamped {
        /// Bodies keep their orientation relative to the frame of the swimmer.
        Clamped,
        /// Bodies rotate freely.
        Free,
        /// Arms keep their direction in the laboratory frame.
        Lab,
    }

    /// Axes in which a force or a torque is given.
    pub enum AxesKind = Laboratory {
        /// Those of the laboratory.
        Laboratory,
        /// Axes that turn with the body, and are those of the laboratory at the start.
        Body,
    }

    /// What determines the value of a joint.
    pub enum DriveKind = Prescribed {
        /// The gait prescribes it.
        Prescribed,
        /// A spring acts on it.
        Spring,
        /// A constant force or torque acts on it.
        Force,
        /// It moves freely.
        Free,
    }

    /// Model of the flow.
    pub enum ModelKind = Auto {
        /// The cheapest model that meets the tolerance.
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
    pub enum AcceptKind = Tolerance {
        /// The run fails and reports what was reached.
        Tolerance,
        /// The best result is accepted with a warning.
        Best,
    }

    /// Method by which the finite-element model imposes the constraints of the joints.
    pub enum FormulationKind = PTilde {
        /// Elimination of the relative velocities.
        PTilde,
        /// Lagrange multipliers.
        Lagrange,
        /// Constraint rows that replace rows of the system.
        DirectRow,
    }

    /// Solver for the linear systems of the finite-element model.
    pub enum SolverKind = Block {
        /// Krylov method with the block preconditioner.
        Block,
        /// Sparse factorisation.
        Direct,
        /// Krylov method with additive Schwarz.
        Schwarz,
        /// Minimal residuals with the block-diagonal preconditioner, for symmetric formulations.
        Minres,
    }

    /// Method by which the finite-element model moves its mesh with the bodies.
    pub enum MeshMotionKind = Auto {
        /// Diffusion with the coefficient of Kanchi & Masud; for the mesh of a file the biharmonic
        /// equation, and other methods where cells become too poor.
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
    pub enum MesherKind = Auto {
        /// The generator of this project.
        Auto,
        /// The command `gmsh`, where the generator of this project has no mesh.
        Gmsh,
    }

    /// Shape of the elements at the surfaces of the bodies.
    pub enum GeometryKind = Curved {
        /// Isoparametric quadratic elements.
        Curved,
        /// Elements with flat facets.
        Straight,
    }

    /// Whether the finite-element model uses symmetry planes.
    pub enum SymmetryKind = Auto {
        /// The whole fluid is meshed.
        Off,
        /// One side of each symmetry plane is meshed.
        Auto,
    }

    /// How the errors of models of spheres are estimated.
    pub enum ModelEstimatesKind = Sampled {
        /// Not at all.
        Off,
        /// Up to 12 spheres as `full`. Beyond that errors of `oseen` and `rpy` are those of the
        /// first reflection between all spheres, compared with expansions in at most four
        /// neighbourhoods of 12 spheres. That costs two products with the mobility (four for
        /// `oseen`), a solution to two digits, and a tenth of a second.
        Sampled,
        /// By expansions of all spheres, whose time grows with the cube of their number: 200
        /// spheres take tens of times as long as the solution.
        Full,
    }

    /// Whether discretisation errors are estimated.
    pub enum EstimatesKind = On {
        /// Errors are estimated for every reported result.
        On,
        /// Errors are not estimated.
        Off,
    }

    /// File of the trajectory that `swim run` writes.
    pub enum TrajectoryKind = Csv {
        /// `trajectory.csv`, a text with a column for each number.
        Csv,
        /// `trajectory.npy`, a binary file with a record for each time, which `numpy.load` reads:
        /// for thousands of bodies.
        Npy,
    }

    /// Flows that a run by elements in space writes for ParaView.
    pub enum FlowsKind = Phase {
        /// The last flow that is solved in each phase.
        Phase,
        /// All flows of the trajectory.
        All,
        /// None.
        Off,
    }

    /// What `swim optimise` optimises.
    pub enum ObjectiveKind = Efficiency {
        /// Lighthill efficiency.
        Efficiency,
        /// Largest displacement.
        Displacement,
        /// Least energy for a displacement.
        Energy,
        /// Least energy for a rotation.
        Rotation,
        /// Largest displacement per time within bounds on rates and power.
        Speed,
    }

    /// Where an optimal stroke starts.
    pub enum StrokeStart = Closed {
        /// Anywhere: a smooth closed curve of shapes.
        Closed,
        /// At the shape of the scene, where the curve may have a corner.
        Fixed,
    }

    /// Method of `swim learn`.
    pub enum LearnKind = Q {
        /// Q-learning (Watkins & Dayan 1992).
        Q,
        /// Double Q-learning (van Hasselt 2010).
        DoubleQ,
    }
}

impl From<SurfaceKind> for mesher::TriangleKind {
    fn from(kind: SurfaceKind) -> Self {
        match kind {
            SurfaceKind::Smooth => Self::Smooth,
            SurfaceKind::Faceted => Self::Faceted,
        }
    }
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
