//! Velocities on a new mesh of the same fluid.

use fem::TaylorHood;
use linalg::WarmStart;
use mesh::{PointLocator, TetMesh};
use nalgebra::Vector3;
use rigid::{Arms, Articulation, Drive};
use stokes::{InertialTerms, Options, Problem};

use crate::InertiaError;

/// Coefficient `κ` of the mass matrix in a projection, in units of the viscous term at length 1.
///
/// Components of the length `κ^(-1/2)`, the size of small elements on a body, count alike in both
/// terms.
const PROJECTION_COEFFICIENT: f64 = 1e2;

/// Change of momentum and energy of the fluid by a projection, per unit of density.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProjectionJump {
    /// `∫ u` on the new mesh minus that on the old one, symmetry planes not multiplied.
    pub momentum: Vector3<f64>,
    /// The same of `∫ |u|^2 / 2`.
    pub energy: f64,
}

/// A discretely divergence-free velocity on `new` that is closest to `velocity` on `old`.
///
/// ```text
/// κ (u, v) + (∇u, ∇v) - (p, ∇·v) = κ (u_old, v) + (∇u_I, ∇v),   (q, ∇·u) = 0
/// ```
///
/// with the interpolant `u_I` and the values of `boundary` at the nodes of `walls`, which are all
/// boundary parts but symmetry planes: the motions of bodies do not change. Interpolation alone
/// would leave a divergence, and the next step a pressure of the size `1 / Δt`. Without the second
/// term gradients, and with them the forces of the next step, would be less accurate.
///
/// # Errors
/// [`InertiaError::Outside`] for meshes of different domains; those of the linear solve.
pub(crate) fn project(
    (old, velocity): (&TetMesh, &[Vector3<f64>]),
    new: &TetMesh,
    space: &TaylorHood,
    walls: &[&str],
    boundary: &[Vector3<f64>],
    rtol: f64,
) -> Result<(Vec<Vector3<f64>>, ProjectionJump), InertiaError> {
    let locator = PointLocator::new(old);
    let at = |x: Vector3<f64>| -> Option<Vector3<f64>> {
        let point = locator.locate(&x)?;
        let nodes = &old.cells()[point.cell];
        let weights = point.quadratic();
        Some(
            nodes
                .iter()
                .zip(weights)
                .map(|(&n, w)| w * velocity[n as usize])
                .sum(),
        )
    };
    // a point outside makes the load NaN, which is found again below to be named
    let outside = Vector3::repeat(f64::NAN);
    let load = match fem::load_vector(new, |x| at(x).unwrap_or(outside)) {
        Ok(load) => load,
        Err(error) => {
            let point = new.points().iter().find(|x| at(**x).is_none());
            return Err(match point {
                Some(x) => InertiaError::Outside { point: (*x).into() },
                None => error.into(),
            });
        }
    };
    let mut interpolant: Vec<Vector3<f64>> = fem::evaluate(old, velocity, new.points())?
        .into_iter()
        .map(|(value, _)| value)
        .collect();
    for part in walls {
        for node in new.nodes_on(new.tag(part)?) {
            interpolant[node as usize] = boundary[node as usize];
        }
    }
    let gradient = space.stiffness(new)?;
    let load: Vec<Vector3<f64>> = (load.iter().zip(gradient.outer_iterator()))
        .map(|(load, row)| {
            let of_gradient = row.iter().map(|(node, k)| *k * interpolant[node]);
            PROJECTION_COEFFICIENT * load + of_gradient.sum::<Vector3<f64>>()
        })
        .collect();
    let no_bodies = Articulation::new(&[], Vec::new(), Arms::Free, &[])?;
    let constraints = no_bodies.constraints(&no_bodies.initial_state(), &[], &[])?;
    let drive = Drive {
        set: &no_bodies,
        constraints: &constraints,
        loads: &[],
    };
    let terms = InertialTerms {
        coefficient: PROJECTION_COEFFICIENT,
        load: Some(&load),
        wall_velocity: Some(boundary),
        ..InertialTerms::default()
    };
    let options = Options::default().with_rtol(rtol);
    let problem = Problem::new(new, &[], walls)?.with_space(space);
    let flow = (problem.solve_inertial(&drive, &options, &terms, &mut WarmStart::new(0))?).flow;
    let [momentum_old, momentum_new] = [
        fem::integrate(old, 2, |point| point.value(velocity))?,
        fem::integrate(new, 2, |point| point.value(&flow.velocity))?,
    ];
    let jump = ProjectionJump {
        momentum: momentum_new - momentum_old,
        energy: 0.5 * (square_integral(new, &flow.velocity)? - square_integral(old, velocity)?),
    };
    Ok((flow.velocity, jump))
}

/// `∫ |u|^2` over the mesh.
pub(crate) fn square_integral(
    mesh: &TetMesh,
    velocity: &[Vector3<f64>],
) -> Result<f64, InertiaError> {
    Ok(fem::integrate(mesh, 4, |point| {
        point.value(velocity).norm_squared()
    })?)
}
