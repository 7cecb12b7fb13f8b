//! A sphere in a concentric ball on similar meshes, by `stokes::Problem`.
//!
//! In scenes the growth rate of elements is limited, so coarse meshes are not similar to fine ones.
//! Orders of convergence are measured on similar meshes, so here all sizes are proportional.

use std::time::Instant;

use anyhow::Result;
use mesh::{Container, GenerateParams, MeshedBody, Surface, TetMesh, generate};
use nalgebra::Vector3;
use rigid::{Arms, Articulation, BodyKind, Drive, ExternalLoad, Independent};
use stokes::{Options, Problem};

use super::row::Cost;

/// Number of parts of an edge of the icosahedron on the sphere, for each mesh of the family.
pub const FAMILY: [u32; 3] = [3, 4, 6];

/// Edge length of the icosahedron with corners on the sphere.
///
/// The geodesic spheres of the mesh generator have fractions of it as element sizes.
const ICOSAHEDRON_EDGE: f64 = 1.2045910058552547;

/// Growth rate of the elements over their size on the sphere: 0.3, the default, at size 0.4.
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
    let problem = Problem::new(&mesh, &[("sphere", Vector3::zeros())], &[Container::TAG])?;
    let set = Articulation::new(
        &[BodyKind::Rigid],
        vec![],
        Arms::Clamped,
        &[Vector3::zeros()],
    )?;
    let drive = Drive {
        set: &set,
        constraints: &set.constraints(&set.initial_state(), &[], &[])?,
        loads: &[ExternalLoad {
            force: Vector3::x(),
            torque: Vector3::z(),
        }],
    };
    let solution = problem.solve(&drive, &Options::default().with_formulation(&Independent))?;
    let motion = &solution.flow.bodies;
    let cost = Cost {
        dofs: solution.dofs.total,
        iterations: solution.solver.iterations,
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
