//! Mesh motion: harmonic extension of the motions of rigid bodies into a mesh, with a guard on its validity.
//!
//! ```
//! use ale::{MovingBody, ReferenceMap, Stiffening};
//! use mesh::{Body, Container, GenerateParams, Sphere, TetMesh, Vec3};
//! use nalgebra::Isometry3;
//!
//! let sphere = Sphere { centre: Vec3::zeros(), radius: 1.0 };
//! let ball = Container::Ball(Sphere { centre: Vec3::zeros(), radius: 10.0 });
//! let bodies = [Body { name: "bead", surface: &sphere, size: 0.6 }];
//! let tets = mesh::generate(&bodies, &ball, &GenerateParams::default())?.mesh;
//! let mesh = TetMesh::curved(tets, &[("bead", &sphere), (Container::TAG, ball.surface())])?;
//!
//! // One scalar solve prepares every later shape; a shape itself costs none.
//! let bead = MovingBody { tag: "bead".into(), centre: Vec3::zeros(), turns: false };
//! let map = ReferenceMap::new(mesh, &[bead], Stiffening::KanchiMasud)?;
//! let moved = map.moved(&[Isometry3::translation(3.0, 0.0, 0.0)])?;
//! assert!(moved.quality().min_jacobian > 0.2);
//! // Farther than the container: refused, never a broken mesh.
//! assert!(map.moved(&[Isometry3::translation(12.0, 0.0, 0.0)]).is_err());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod dirichlet;
mod error;
mod reference_map;
mod stiffening;

pub use error::AleError;
pub use reference_map::{MovingBody, ReferenceMap};
pub use stiffening::Stiffening;
