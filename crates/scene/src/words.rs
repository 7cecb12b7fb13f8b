//! The words that keys of a scene take, and what they stand for.

/// An enum whose variants are words of the scene file: the words are written down once.
macro_rules! words {
    ($(#[$doc:meta])* $name:ident { $($(#[$variant_doc:meta])* $variant:ident = $word:literal,)+ }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $name { $($(#[$variant_doc])* $variant,)+ }

        impl $name {
            /// All words, in the order of the variants.
            pub const WORDS: &[&str] = &[$($word),+];

            /// The word of the scene file.
            pub const fn word(self) -> &'static str {
                match self { $(Self::$variant => $word,)+ }
            }

            pub(crate) fn of(word: &str) -> Option<Self> {
                match word { $($word => Some(Self::$variant),)+ _ => None }
            }
        }
    };
}

words! {
    /// Where the fluid is.
    DomainKind {
        /// Everywhere.
        Unbounded = "unbounded",
        /// In a ball.
        Ball = "ball",
        /// In a box.
        Box = "box",
        /// In a circular cylinder.
        Cylinder = "cylinder",
        /// On one side of a plane.
        Wall = "wall",
        /// In the volume of a mesh file.
        Mesh = "mesh",
    }
}

words! {
    /// Kind of body.
    ShapeKind {
        /// A sphere.
        Sphere = "sphere",
        /// A spheroid.
        Spheroid = "spheroid",
        /// A massless point without surface.
        Point = "point",
    }
}

words! {
    /// How bodies sit on arms that turn; see [`rigid::Arms`].
    ArmsKind {
        /// Bodies keep their attitude to the frame.
        Clamped = "clamped",
        /// Bodies spin freely.
        Free = "free",
        /// Arms keep their direction in the laboratory.
        Lab = "lab",
    }
}

words! {
    /// Model of the flow.
    ModelKind {
        /// The least model that meets the tolerance.
        Auto = "auto",
        /// Point forces.
        Oseen = "oseen",
        /// Rotne-Prager-Yamakawa.
        Rpy = "rpy",
        /// Multipole expansions.
        Multipole = "multipole",
        /// Finite elements in the meridian plane.
        Axisymmetric = "axisymmetric",
        /// Finite elements in space.
        Fem = "fem",
    }
}

words! {
    /// How the finite-element model imposes the links.
    FormulationKind {
        /// Elimination of relative velocities.
        PTilde = "p-tilde",
        /// Lagrange multipliers.
        Lagrange = "lagrange",
        /// Substitution into rows.
        DirectRow = "direct-row",
    }
}

words! {
    /// How the finite-element model solves its systems.
    SolverKind {
        /// Krylov method with the block preconditioner.
        Block = "block",
        /// Sparse factorisation.
        Direct = "direct",
        /// Krylov method with additive Schwarz.
        Schwarz = "schwarz",
        /// Minimal residuals with the block-diagonal preconditioner, for symmetric formulations.
        Minres = "minres",
    }
}

words! {
    /// How the finite-element model moves its mesh; see [`ale::MeshMotion`].
    MeshMotionKind {
        /// Laplace's equation.
        Laplace = "laplace",
        /// Diffusion with the coefficient of Kanchi & Masud.
        KanchiMasud = "kanchi-masud",
        /// Diffusion with the reciprocal volume as coefficient.
        InverseVolume = "inverse-volume",
        /// Linear elasticity, small elements stiff.
        Elastic = "elastic",
        /// The biharmonic equation.
        Biharmonic = "biharmonic",
        /// Cubic radial basis functions.
        Rbf = "rbf",
    }
}

words! {
    /// Shape of the elements at the bodies.
    GeometryKind {
        /// Isoparametric quadratic.
        Curved = "curved",
        /// Flat facets.
        Straight = "straight",
    }
}

words! {
    /// Whether the finite-element model looks for mirror planes.
    MirrorKind {
        /// It meshes the whole fluid.
        Off = "off",
        /// It meshes what is on one side of the planes that it finds.
        Auto = "auto",
    }
}

words! {
    /// Whether errors are estimated.
    EstimatesKind {
        /// With every answer that is reported.
        On = "on",
        /// Not at all.
        Off = "off",
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
