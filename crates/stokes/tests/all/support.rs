//! A sphere in the middle of a ball of fluid.

use fem::SurplusSpace;
use mesh::TetMesh;
use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};
use nalgebra::Vector3;
use rheology::ViscosityLaw;
use rigid::{Arms, Articulation, BodyKind, Drive, ExternalLoad};
use stokes::{
    GeneralisedNewtonianSolution, InitialGuesses, Options, Problem, Solution, StokesError,
    SurfaceFlow,
};

pub const SPHERE: Sphere = Sphere {
    centre: Vector3::new(0.0, 0.0, 0.0),
    radius: 1.0,
};

/// The part of the fluid between the sphere and a concentric ball where the coordinates normal to
/// the planes are positive. Elements on the sphere have the given size.
pub fn sphere_in_ball(size: f64, radius: f64, symmetry_planes: [bool; 3]) -> TetMesh {
    let ball = Sphere { radius, ..SPHERE };
    let body = MeshedBody {
        name: "sphere",
        surface: &SPHERE,
        size,
    };
    let mut parameters = GenerateParams::default();
    parameters.symmetry_planes = symmetry_planes;
    let tets = generate(&[body], &Container::Ball(ball), &parameters).unwrap();
    TetMesh::curved(tets.mesh, &[("sphere", &SPHERE), (Container::TAG, &ball)]).unwrap()
}

/// The solution for the sphere, free of loads, on a mesh by [`sphere_in_ball`], with estimates.
pub fn solve_free_sphere(
    mesh: &TetMesh,
    radius: f64,
    flow: &dyn SurfaceFlow,
    options: &Options,
) -> Result<Solution, StokesError> {
    let space = SurplusSpace::new(mesh).unwrap();
    let mut guesses = InitialGuesses::new(0);
    with_free_sphere(mesh, radius, flow, |problem, drive| {
        let mut solved = problem.solve_all(
            std::slice::from_ref(drive),
            options,
            &mut guesses,
            Some(&space),
        )?;
        Ok(solved.swap_remove(0))
    })
}

/// The same in a fluid with a viscosity law, without estimates.
pub fn solve_free_sphere_in(
    mesh: &TetMesh,
    (radius, law): (f64, &dyn ViscosityLaw),
    flow: &dyn SurfaceFlow,
    options: &Options,
) -> Result<GeneralisedNewtonianSolution, StokesError> {
    let mut guesses = InitialGuesses::new(0);
    with_free_sphere(mesh, radius, flow, |problem, drive| {
        problem.solve_generalised_newtonian(drive, law, options, &mut guesses, None)
    })
}

/// Calls `solve` with the problem of the sphere and its drive.
fn with_free_sphere<T>(
    mesh: &TetMesh,
    radius: f64,
    flow: &dyn SurfaceFlow,
    solve: impl FnOnce(&Problem<'_>, &Drive<'_>) -> Result<T, StokesError>,
) -> Result<T, StokesError> {
    let ball = Sphere { radius, ..SPHERE };
    let surfaces: [mesh::NamedSurface; 2] = [("sphere", &SPHERE), (Container::TAG, &ball)];
    let problem = Problem::new(mesh, &[("sphere", Vector3::zeros())], &[Container::TAG])?
        .with_surfaces(&surfaces)?
        .with_surface_flow(flow);
    let centre = [Vector3::zeros()];
    let set = Articulation::new(&[BodyKind::Rigid], vec![], Arms::Clamped, &centre).unwrap();
    let drive = Drive {
        set: &set,
        constraints: &set.constraints(&set.initial_state(), &[], &[]).unwrap(),
        loads: &[ExternalLoad::default()],
    };
    solve(&problem, &drive)
}
