//! Mesh motion: extension of the motions of rigid bodies into a mesh, with a guard on its validity.
//!
//! | extension ([`MeshMotion`]) | solves |
//! |---|---|
//! | [`Harmonic`] | one scalar diffusion equation; plain, or stiffened by [`Stiffening`] |
//! | [`Elastic`] | linear elasticity, small elements stiff |
//! | [`Biharmonic`] | fourth order: the mesh at a body moves with it |
//! | [`Rbf`] | radial basis functions on the boundary; dense |
//!
//! Each is used from a reference mesh ([`ReferenceMap`]: the mesh follows the shape) or step by step ([`IncrementalMap`]: the mesh follows
//! the history). `docs/ale.md` measures them against each other.
//!
//! ```
//! use ale::{Harmonic, MovingBody, ReferenceMap, Stiffening};
//! use mesh::{Container, GenerateParams, MeshedBody, Sphere, TetMesh, Vec3};
//! use nalgebra::Isometry3;
//!
//! let sphere = Sphere { centre: Vec3::zeros(), radius: 1.0 };
//! let ball = Container::Ball(Sphere { centre: Vec3::zeros(), radius: 10.0 });
//! let bodies = [MeshedBody { name: "bead", surface: &sphere, size: 0.6 }];
//! let tets = mesh::generate(&bodies, &ball, &GenerateParams::default())?.mesh;
//! let mesh = TetMesh::curved(tets, &[("bead", &sphere), (Container::TAG, ball.surface())])?;
//!
//! // One scalar solve prepares every later shape; a shape itself costs none.
//! let bead = MovingBody { tag: "bead".into(), centre: Vec3::zeros(), turns: false };
//! let map = ReferenceMap::new(mesh, &[bead], &Harmonic(Stiffening::KanchiMasud))?;
//! let moved = map.moved(&[Isometry3::translation(3.0, 0.0, 0.0)])?;
//! assert!(moved.quality().min_jacobian > 0.2);
//! // Farther than the container: refused, never a broken mesh.
//! assert!(map.moved(&[Isometry3::translation(12.0, 0.0, 0.0)]).is_err());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod biharmonic;
mod bodies;
mod elastic;
mod error;
mod extension;
mod harmonic;
mod incremental_map;
mod motion;
mod rbf;
mod reference_map;
mod stiffening;

pub use biharmonic::Biharmonic;
pub use bodies::MovingBody;
pub use elastic::Elastic;
pub use error::AleError;
pub use harmonic::Harmonic;
pub use incremental_map::IncrementalMap;
pub use motion::{MeshMotion, MovingMesh};
pub use rbf::{Kernel, Rbf};
pub use reference_map::ReferenceMap;
pub use stiffening::Stiffening;
