//! Taylor-Hood finite elements on curved tetrahedra: assembly, functionals, norms, error estimates.
//!
//! Velocity is quadratic, with one unknown (three interleaved components) a point of a 10-node mesh; pressure is
//! linear, with one unknown a vertex. Matrices cover all nodes, boundary nodes included; who holds which node fixed is
//! for others to say. Viscosity is 1: momentum reads `K u + B^T p = f` for each component, incompressibility
//! `B u = 0`. Loads are those that bodies exert on the fluid.
//!
//! ```
//! use fem::{TaylorHood, dissipation, momentum_residual};
//! use mesh::{LinearTets, TetMesh};
//!
//! // Shear flow u = (z, 0, 0) in the unit cube.
//! let mesh = TetMesh::straight(LinearTets::cube(3))?;
//! let u: Vec<f64> = mesh.points().iter().flat_map(|x| [x.z, 0.0, 0.0]).collect();
//! let p = vec![0.0; mesh.n_vertices()];
//!
//! let space = TaylorHood::new(&mesh)?; // sparsity: once a mesh, whatever its points do
//! let (k, b) = (space.stiffness(&mesh)?, space.divergence(&mesh)?);
//! let residual = momentum_residual(&k, &b, &u, &p)?;
//!
//! // The lid drags the fluid with a force of area times shear rate, and its power is dissipated.
//! let lid = mesh.nodes_on(mesh.tag("z1")?);
//! let force: f64 = lid.iter().map(|&node| residual[3 * node as usize]).sum();
//! assert!((force - 1.0).abs() < 1e-12);
//! assert!((dissipation(&mesh, &u)? - 1.0).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod assemble;
mod check;
mod error;
mod estimate;
mod forms;
mod geometry;
mod load;
mod matrices;
mod norms;
mod pattern;
mod quadrature;
mod reference;
mod space;
mod sum;
mod surface;

pub use error::FemError;
pub use estimate::{CurvedBoundary, ErrorFunctional, FacetGeometry, Surplus, SurplusSpace};
pub use load::{LoadOnFluid, consistent_load, momentum_residual, stress_load};
pub use matrices::StokesMatrices;
pub use norms::{VelocityError, dissipation, mean_pressure, pressure_error, velocity_error};
pub use space::TaylorHood;
pub use surface::{SurfaceMeasures, surface_measures};
