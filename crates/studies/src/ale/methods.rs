//! The mesh motions of the study, and the two ways to use them.

use ale::{
    AleError, Biharmonic, Elastic, Harmonic, Kernel, MeshMotion, MovingBody, Rbf, ReferenceMap,
    Stiffening,
};
use mesh::{Quality, TetMesh};
use nalgebra::Isometry3;

use super::incremental_map::IncrementalMap;

/// A mesh motion with its name in tables.
pub struct Method {
    pub name: &'static str,
    pub make: fn() -> Box<dyn MeshMotion>,
}

/// All mesh motions of the study.
pub const METHODS: [Method; 8] = [
    Method {
        name: "Laplace",
        make: || Box::new(Harmonic(Stiffening::None)),
    },
    Method {
        name: "1 + tau (Kanchi & Masud)",
        make: || Box::new(Harmonic(Stiffening::KanchiMasud)),
    },
    Method {
        name: "1/V",
        make: || Box::new(Harmonic(Stiffening::InverseVolume)),
    },
    Method {
        name: "elastic, nu = 0",
        make: || Box::new(Elastic { poisson: 0.0 }),
    },
    Method {
        name: "elastic, nu = 0.3",
        make: || Box::new(Elastic { poisson: 0.3 }),
    },
    Method {
        name: "biharmonic",
        make: || Box::new(Biharmonic),
    },
    Method {
        name: "RBF r",
        make: || Box::new(Rbf(Kernel::Linear)),
    },
    Method {
        name: "RBF r^3",
        make: || Box::new(Rbf(Kernel::Cubic)),
    },
];

/// Mesh from which each step starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// The first mesh: extensions are computed once.
    Reference,
    /// The mesh of the previous step: extensions are recomputed.
    Incremental,
}

impl Way {
    pub const ALL: [Self; 2] = [Self::Reference, Self::Incremental];

    pub fn name(self) -> &'static str {
        match self {
            Self::Reference => "reference",
            Self::Incremental => "incremental",
        }
    }
}

/// A moving mesh.
pub enum Moving {
    Reference { map: ReferenceMap, mesh: TetMesh },
    Incremental(Box<IncrementalMap>),
}

impl Moving {
    pub fn new(
        method: &Method,
        way: Way,
        mesh: &TetMesh,
        bodies: &[MovingBody],
    ) -> Result<Self, AleError> {
        let motion = (method.make)();
        Ok(match way {
            Way::Reference => Self::Reference {
                map: ReferenceMap::new(mesh.clone(), bodies, motion.as_ref())?,
                mesh: mesh.clone(),
            },
            Way::Incremental => {
                Self::Incremental(Box::new(IncrementalMap::new(mesh.clone(), bodies, motion)?))
            }
        })
    }

    /// Moves the mesh; quality of the new mesh, or `None` if it is not valid.
    pub fn advance(&mut self, motions: &[Isometry3<f64>]) -> Result<Option<Quality>, AleError> {
        let moved = match self {
            Self::Reference { map, mesh } => map.moved(motions).map(|moved| {
                *mesh = moved;
                mesh.quality()
            }),
            Self::Incremental(map) => map.advance(motions).map(TetMesh::quality),
        };
        match moved {
            Ok(quality) => Ok(Some(quality)),
            Err(AleError::Invalid(_)) => Ok(None),
            Err(other) => Err(other),
        }
    }

    /// The last valid mesh.
    pub fn mesh(&self) -> &TetMesh {
        match self {
            Self::Reference { mesh, .. } => mesh,
            Self::Incremental(map) => map.mesh(),
        }
    }
}
