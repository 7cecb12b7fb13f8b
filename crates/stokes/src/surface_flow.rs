//! Flows that do not come from the motion of the bodies: slip of surfaces, background flow.

use fem::SurfaceVelocity;
use mesh::TetMesh;
use nalgebra::{Matrix3, Vector3};
use rigid::FlowSolution;

use crate::StokesError;

/// Slip of the surfaces of bodies, and the flow in the absence of the bodies.
///
/// The velocity is `u = u_∞ + u'`. The background flow `u_∞` is a solution of the Stokes equations;
/// a [`Problem`](crate::Problem) solves for the disturbance `u'`, with
///
/// ```text
/// u' = U + ω × r + s - u_∞    on bodies, with the slip s
/// u' = 0                      on walls, which move with the background flow
/// ```
///
/// On a closed surface the background flow has no force and no torque, so those of `u'` are those
/// of `u`. On a mesh that ends at symmetry planes slip and background flow are symmetric about
/// them.
pub trait SurfaceFlow: Sync {
    /// Velocity of the surface of `body` relative to its rigid motion, at a point on the surface.
    ///
    /// At points near the surface: its value at the closest point of the surface.
    fn slip(&self, body: usize, x: &Vector3<f64>) -> Vector3<f64>;

    /// Velocity of the background flow.
    fn background(&self, x: &Vector3<f64>) -> Vector3<f64>;

    /// Pressure of the background flow at viscosity 1.
    fn background_pressure(&self, x: &Vector3<f64>) -> f64;
}

/// Nodal values of a [`SurfaceFlow`] on the mesh of a problem.
pub(crate) struct NodalSurfaceFlow {
    /// `s - u_∞` at the nodes of bodies, zero at all others.
    pub velocity: Vec<Vector3<f64>>,
    /// Boundary part of each body.
    pub tags: Vec<u16>,
    /// `∮ (s - u_∞) n^T dS` of each body, over the part in the mesh.
    pub moments: Vec<Matrix3<f64>>,
    /// The slip `s` at the nodes of bodies, zero at all others.
    pub slip: Vec<Vector3<f64>>,
    /// The background flow at all nodes, and its pressure at the vertices.
    pub background: (Vec<Vector3<f64>>, Vec<f64>),
}

/// `s - u_∞` on the facets of bodies, given by their boundary parts; zero on all others.
pub(crate) fn surface_velocity<'a>(
    flow: &'a dyn SurfaceFlow,
    bodies: &[(u16, Vector3<f64>)],
) -> Box<SurfaceVelocity<'a>> {
    let bodies: Vec<u16> = bodies.iter().map(|(tag, _)| *tag).collect();
    Box::new(
        move |tag, x| match bodies.iter().position(|body| *body == tag) {
            Some(body) => flow.slip(body, &x) - flow.background(&x),
            None => Vector3::zeros(),
        },
    )
}

impl NodalSurfaceFlow {
    /// Nodal values of `flow` on a mesh with these boundary parts and centres of bodies.
    ///
    /// # Errors
    /// A velocity that is not finite.
    pub fn new(
        flow: &dyn SurfaceFlow,
        mesh: &TetMesh,
        bodies: &[(u16, Vector3<f64>)],
    ) -> Result<Self, StokesError> {
        let (velocity, points) = (surface_velocity(flow, bodies), mesh.points());
        let zero = vec![Vector3::zeros(); points.len()];
        let mut nodal = Self {
            velocity: zero.clone(),
            tags: bodies.iter().map(|(tag, _)| *tag).collect(),
            moments: Vec::with_capacity(bodies.len()),
            slip: zero,
            background: (
                points.iter().map(|x| flow.background(x)).collect(),
                (points[..mesh.n_vertices()].iter())
                    .map(|x| flow.background_pressure(x))
                    .collect(),
            ),
        };
        for (body, &(tag, _)) in bodies.iter().enumerate() {
            let on_body = fem::nodal_surface_velocity(mesh, tag, &*velocity)?;
            for (node, value) in on_body.values {
                nodal.velocity[node as usize] = value;
                nodal.slip[node as usize] = flow.slip(body, &points[node as usize]);
            }
            nodal.moments.push(on_body.moment);
        }
        Ok(nodal)
    }

    /// Velocities and pressure of a disturbance flow with the background flow.
    pub fn whole(&self, flow: &FlowSolution) -> (Vec<Vector3<f64>>, Vec<f64>) {
        let (velocity, pressure) = &self.background;
        let velocity = flow.velocity.iter().zip(velocity).map(|(u, v)| u + v);
        let pressure = flow.pressure.iter().zip(pressure).map(|(p, q)| p + q);
        (velocity.collect(), pressure.collect())
    }
}
