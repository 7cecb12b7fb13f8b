//! A sphere in a concentric ball on similar meshes, by `stokes::Problem`.
//!
//! In scenes the growth rate of elements is limited, so coarse meshes are not similar to fine ones.
//! Orders of convergence are measured on similar meshes, so here all sizes are proportional.

use std::time::Instant;

use anyhow::{Context, Result};
use fem::SurplusSpace;
use mesh::{NamedSurface, Surface, TetMesh};
use mesher::{Container, GenerateParams, MeshedBody, generate};
use nalgebra::{DVector, Vector3};
use rigid::{Arms, Articulation, BodyKind, Drive, ExternalLoad, Independent};
use stokes::{InitialGuesses, Options, Problem};

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

impl Loads {
    /// Loads from the motion under unit force and torque.
    fn of(motion: &DVector<f64>) -> Self {
        Self {
            drag: 1.0 / motion[0],
            torque: 1.0 / motion[5],
        }
    }
}

/// Loads of the Taylor-Hood solution, and those after its correction.
pub struct Solved {
    pub uncorrected: Loads,
    pub corrected: Loads,
    pub cost: Cost,
}

/// Drag and torque of the unit sphere at the centre of a ball of radius `1 / lambda`.
pub fn sphere(lambda: f64, parts: u32, geometry: Geometry) -> Result<Solved> {
    let clock = Instant::now();
    let mesh = ball_in_ball(lambda, ICOSAHEDRON_EDGE / f64::from(parts), geometry)?;
    let (body, wall) = (unit_sphere(), wall(lambda));
    let surfaces: [NamedSurface; 2] = [("sphere", &body), (Container::TAG, &wall)];
    let problem = Problem::new(&mesh, &[("sphere", Vector3::zeros())], &[Container::TAG])?
        .with_surfaces(&surfaces)?;
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
    let options = Options::default().with_formulation(&Independent);
    let (mut guesses, space) = (InitialGuesses::new(0), SurplusSpace::new(&mesh)?);
    let solutions = problem.solve_all(&[drive], &options, &mut guesses, Some(&space))?;
    let solution = solutions.first().context("one drive has one solution")?;
    let estimate = solution.estimate.as_ref();
    let estimate = estimate.context("the error was not estimated")?;
    let motion = &solution.flow.bodies;
    Ok(Solved {
        uncorrected: Loads::of(motion),
        corrected: Loads::of(&(motion + &estimate.change.bodies)),
        cost: Cost {
            dofs: solution.dofs.total,
            iterations: solution.solver.iterations,
            seconds: clock.elapsed().as_secs_f64(),
        },
    })
}

fn unit_sphere() -> mesher::Sphere {
    mesher::Sphere {
        centre: Vector3::zeros(),
        radius: 1.0,
    }
}

fn wall(lambda: f64) -> mesher::Sphere {
    mesher::Sphere {
        radius: 1.0 / lambda,
        ..unit_sphere()
    }
}

fn ball_in_ball(lambda: f64, size: f64, geometry: Geometry) -> Result<TetMesh> {
    let sphere = unit_sphere();
    let container = Container::Ball(wall(lambda));
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
