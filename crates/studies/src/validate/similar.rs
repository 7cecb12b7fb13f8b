//! A sphere in a concentric ball on similar meshes, by the layers themselves: `mesh`, `fem`, `rigid`, `linalg`.
//!
//! Scenes let elements grow at a fixed rate, whatever their size on the bodies; the order of a method shows on meshes that
//! are alike everywhere, so here all sizes are proportional.

use std::time::Instant;

use anyhow::Result;
use fem::{StokesMatrices, TaylorHood};
use linalg::{KrylovParams, fgmres};
use mesh::{Container, GenerateParams, MeshedBody, Surface, TetMesh, generate};
use nalgebra::Vector3;
use rigid::{
    Arms, Articulation, BodyKind, Drive, ExternalLoad, FluidMatrices, FluidNodes, Formulation,
    Independent, NodeRole, RigidFluid, SurfaceBody,
};

use super::table::Cost;

/// Parts that an edge of the sphere's icosahedron is cut into, from mesh to mesh.
pub const FAMILY: [u32; 3] = [3, 4, 6];

/// Edge length of the icosphere with one part an edge: what the generator's geodesic spheres come in fractions of.
const ICOSAHEDRON_EDGE: f64 = 1.2045910058552547;

/// Growth of the elements over their size on the sphere: 0.3, the default, at size 0.4.
const GROWTH_OVER_SIZE: f64 = 0.75;

#[derive(Clone, Copy, PartialEq)]
pub enum Geometry {
    Curved,
    Straight,
}

impl Geometry {
    pub fn word(self) -> &'static str {
        match self {
            Self::Curved => "curved",
            Self::Straight => "straight",
        }
    }
}

/// Force along x at unit velocity and torque about z at unit angular velocity.
pub struct Loads {
    pub drag: f64,
    pub torque: f64,
}

/// Drag and torque of the unit sphere at the centre of a ball of radius `1 / lambda`.
pub fn sphere(lambda: f64, parts: u32, geometry: Geometry) -> Result<(Loads, Cost)> {
    let clock = Instant::now();
    let mesh = ball_in_ball(lambda, ICOSAHEDRON_EDGE / f64::from(parts), geometry)?;
    let space = TaylorHood::new(&mesh)?;
    let mut roles = vec![NodeRole::Free; mesh.n_points()];
    for (tag, role) in [
        ("sphere", NodeRole::Body(0)),
        (Container::TAG, NodeRole::Fixed),
    ] {
        for node in mesh.nodes_on(mesh.tag(tag)?) {
            roles[node as usize] = role;
        }
    }
    let StokesMatrices {
        stiffness,
        divergence,
        pressure_mass,
        interpolation,
        vertex_stiffness,
    } = space.matrices(&mesh)?;
    let fluid = RigidFluid::new(
        FluidMatrices {
            stiffness,
            divergence,
            pressure_mass,
            interpolation,
            vertex_stiffness,
        },
        FluidNodes::new(mesh.points(), &roles),
        &[SurfaceBody {
            centre: Vector3::zeros(),
            volume: fem::surface_measures(&mesh, mesh.tag("sphere")?)?.volume,
        }],
    )?;
    let set = Articulation::new(
        &[BodyKind::Rigid],
        vec![],
        Arms::Clamped,
        &[Vector3::zeros()],
    )?;
    let constrained = Independent.constrain(
        fluid,
        &Drive {
            set: &set,
            constraints: &set.constraints(&set.initial_state(), &[], &[])?,
            loads: &[ExternalLoad {
                force: Vector3::x(),
                torque: Vector3::z(),
            }],
        },
    )?;
    let system = &constrained.system;
    let mut preconditioner = constrained.preconditioner()?;
    let mut solution = vec![0.0; constrained.rhs.len()];
    let report = fgmres(
        system,
        &mut preconditioner,
        &constrained.rhs,
        &mut solution,
        &KrylovParams::default(),
    )?;
    let motion = constrained.flow(&solution, &set)?.bodies;
    let cost = Cost {
        dofs: solution.len(),
        iterations: report.iterations,
        seconds: clock.elapsed().as_secs_f64(),
    };
    let loads = Loads {
        drag: 1.0 / motion[0],
        torque: 1.0 / motion[5],
    };
    Ok((loads, cost))
}

fn ball_in_ball(lambda: f64, size: f64, geometry: Geometry) -> Result<TetMesh> {
    let sphere = mesh::Sphere {
        centre: Vector3::zeros(),
        radius: 1.0,
    };
    let container = Container::Ball(mesh::Sphere {
        centre: Vector3::zeros(),
        radius: 1.0 / lambda,
    });
    let body = MeshedBody {
        name: "sphere",
        surface: &sphere,
        size,
    };
    let mut params = GenerateParams::default();
    params.growth = GROWTH_OVER_SIZE * size;
    let tets = generate(&[body], &container, &params)?.mesh;
    let surfaces: [(&str, &dyn Surface); 2] =
        [("sphere", &sphere), (Container::TAG, container.surface())];
    Ok(match geometry {
        Geometry::Curved => TetMesh::curved(tets, &surfaces)?,
        Geometry::Straight => TetMesh::straight(tets)?,
    })
}
