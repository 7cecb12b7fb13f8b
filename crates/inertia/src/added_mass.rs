//! The added mass of bodies: forces that accelerate the fluid around them.

use fem::TaylorHood;
use linalg::{
    CsrOperator, KrylovParams, MultigridParams, NullVectors, Prolongation, ScalarMultigrid, cg,
};
use mesh::TetMesh;
use nalgebra::{Vector3, Vector6};
use rigid::SymmetryPlanes;

use crate::InertiaError;
use crate::error::check_length;

/// Relative residual of a potential.
///
/// The force on a body that accelerates alone has the square of the error of the potential.
const RTOL: f64 = 1e-6;

/// Forces and torques that bodies exert on fluid of density 1 because they accelerate.
///
/// If the generalised velocities `(U, ω)` of the bodies `b` have the rates of change `(A, α)`, the
/// fluid accelerates at once by the gradient of a potential, whatever its viscosity and its
/// velocity, because vorticity diffuses from the surfaces only afterwards. With normals out of the
/// fluid
///
/// ```text
/// Δφ = 0,   ∂φ/∂n = (A_b + α_b × (x - x_b)) · n on bodies,   ∂φ/∂n = 0 on walls
/// F_b = ∮_b φ n dS,   T_b = ∮_b φ (x - x_b) × n dS
/// ```
///
/// which is the added-mass matrix of the configuration times the accelerations (Lamb 1932, sections
/// 118 and 137; Batchelor 1967, section 6.4). Quadratic elements: the force on a body that
/// accelerates alone has the error of an energy, the square of that of the gradient. On a mesh that
/// ends at symmetry planes forces are those on whole bodies.
///
/// `bodies` are boundary parts with the centres of the bodies, `accelerations` one per body.
///
/// ```
/// use inertia::added_mass_forces;
/// use inertia::fem::TaylorHood;
/// use inertia::nalgebra::{Vector3, Vector6};
/// use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};
///
/// let sphere = Sphere { centre: Vector3::zeros(), radius: 1.0 };
/// let ball = Sphere { centre: Vector3::zeros(), radius: 2.0 };
/// let body = MeshedBody { name: "s", surface: &sphere, size: 0.3 };
/// let tets = generate(&[body], &Container::Ball(ball), &GenerateParams::default())?.mesh;
/// let mesh = mesh::TetMesh::curved(tets, &[("s", &sphere), (Container::TAG, &ball)])?;
/// let space = TaylorHood::new(&mesh)?;
/// let along_x = Vector6::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.0);
/// let forces = added_mass_forces(&mesh, &space, &[("s", sphere.centre)], &[along_x])?;
/// // `2/3 π a^3 (b^3 + 2 a^3) / (b^3 - a^3)` in a concentric ball (Lamb 1932, section 93)
/// let exact = 2.0 / 3.0 * std::f64::consts::PI * 10.0 / 7.0;
/// assert!((forces[0].x / exact - 1.0).abs() < 5e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Cost: one scalar stiffness matrix, a multigrid set-up and about 10 iterations of CG.
///
/// # Errors
/// Lists of different lengths, a boundary part that the mesh does not have; those of assembly and
/// linear solve.
pub fn added_mass_forces(
    mesh: &TetMesh,
    space: &TaylorHood,
    bodies: &[(&str, Vector3<f64>)],
    accelerations: &[Vector6<f64>],
) -> Result<Vec<Vector6<f64>>, InertiaError> {
    check_length("accelerations of bodies", bodies.len(), accelerations.len())?;
    let mut load = vec![0.0; mesh.n_points()];
    for ((name, centre), acceleration) in bodies.iter().zip(accelerations) {
        let (linear, angular) = halves(acceleration);
        let form = |facet: &fem::FacetValues<'_>, load: &mut [f64; 10]| {
            let arm = facet.point.position() - centre;
            let normal = (linear + angular.cross(&arm)).dot(&facet.normal);
            facet.point.add_load(load, |v| normal * v.value);
        };
        let of_body = fem::assemble_facet_load(mesh, mesh.tag(name)?, FACET_DEGREE, form)?;
        load.iter_mut()
            .zip(of_body)
            .for_each(|(sum, own)| *sum += own);
    }
    let potential = potential(mesh, space, &load)?;
    let planes = SymmetryPlanes {
        planes: mesh.symmetry_planes(),
    };
    let (allowed, parts) = (planes.allowed(), planes.parts());
    let force = |(name, centre): &(&str, Vector3<f64>)| {
        let of_part = fem::integrate_facets(mesh, mesh.tag(name)?, FACET_DEGREE, |facet| {
            let traction = facet.point.value(&potential) * facet.normal;
            let torque = (facet.point.position() - centre).cross(&traction);
            [traction, torque].map(<[f64; 3]>::from)
        })?;
        Ok(Vector6::from_fn(|k, _| match allowed[k] {
            true => parts * of_part[k / 3][k % 3],
            false => 0.0,
        }))
    };
    bodies.iter().map(force).collect()
}

/// Degree of a quadratic function times the normal and the arm on a quadratic facet, whose surface
/// element times the normal has degree two.
const FACET_DEGREE: usize = 6;

/// The potential with these fluxes `∫ N_i ∂φ/∂n`, up to a constant.
fn potential(mesh: &TetMesh, space: &TaylorHood, load: &[f64]) -> Result<Vec<f64>, InertiaError> {
    let solve = || {
        let stiffness = CsrOperator::new(space.stiffness(mesh)?)?;
        let prolongation = Prolongation::scalar(space.vertex_interpolation(mesh)?)?;
        let coarse = space.vertex_stiffness(mesh)?;
        let params =
            MultigridParams::default().with_coarsest_shift(MultigridParams::SINGULAR_SHIFT);
        let mut multigrid =
            ScalarMultigrid::with_prolongation(&stiffness, &prolongation, Some(coarse), &params)?;
        let constant = NullVectors::constant(load.len())?;
        let params = KrylovParams::default()
            .with_rel_tol(RTOL)
            .with_null_vectors(constant);
        let mut potential = vec![0.0; load.len()];
        cg(&stiffness, &mut multigrid, load, &mut potential, &params)?;
        Ok::<_, stokes::StokesError>(potential)
    };
    match load.iter().all(|flux| *flux == 0.0) {
        true => Ok(vec![0.0; load.len()]),
        false => Ok(solve()?),
    }
}

fn halves(twist: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
    (
        twist.fixed_rows::<3>(0).into(),
        twist.fixed_rows::<3>(3).into(),
    )
}
