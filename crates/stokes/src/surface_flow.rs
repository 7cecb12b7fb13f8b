//! Flows that do not come from the motion of the bodies: slip of surfaces, background flow.

use fem::SurfaceVelocity;
use nalgebra::{Matrix3, Vector3};
use rigid::FlowSolution;

use crate::StokesError;
use crate::problem::Problem;

/// Slip of the surfaces of bodies, and the flow in the absence of the bodies.
///
/// The velocity is `u = u_∞ + u'`. The background flow `u_∞` is a solution of the Stokes equations;
/// a [`Problem`] solves for the disturbance `u'`, with
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

impl Problem<'_> {
    /// `s - u_∞` on the facets of bodies; zero on all others.
    pub(crate) fn surface_velocity(&self) -> Option<Box<SurfaceVelocity<'_>>> {
        let flow = self.surface_flow?;
        let bodies: Vec<u16> = self.bodies.iter().map(|(tag, _)| *tag).collect();
        Some(Box::new(move |tag, x| {
            match bodies.iter().position(|body| *body == tag) {
                Some(body) => flow.slip(body, &x) - flow.background(&x),
                None => Vector3::zeros(),
            }
        }))
    }

    /// Nodal values of the surface flow; none without one.
    ///
    /// # Errors
    /// A velocity that is not finite.
    pub(crate) fn nodal_surface_flow(&self) -> Result<Option<NodalSurfaceFlow>, StokesError> {
        let (Some(flow), Some(velocity)) = (self.surface_flow, self.surface_velocity()) else {
            return Ok(None);
        };
        let (mesh, points) = (self.mesh, self.mesh.points());
        let zero = vec![Vector3::zeros(); points.len()];
        let mut nodal = NodalSurfaceFlow {
            velocity: zero.clone(),
            tags: self.bodies.iter().map(|(tag, _)| *tag).collect(),
            moments: Vec::with_capacity(self.bodies.len()),
            slip: zero,
            background: (
                points.iter().map(|x| flow.background(x)).collect(),
                (points[..mesh.n_vertices()].iter())
                    .map(|x| flow.background_pressure(x))
                    .collect(),
            ),
        };
        for (body, &(tag, _)) in self.bodies.iter().enumerate() {
            let on_body = fem::nodal_surface_velocity(mesh, tag, &*velocity)?;
            for (node, value) in on_body.values {
                nodal.velocity[node as usize] = value;
                nodal.slip[node as usize] = flow.slip(body, &points[node as usize]);
            }
            nodal.moments.push(on_body.moment);
        }
        Ok(Some(nodal))
    }

    /// Power of a disturbance flow in the prescribed velocities of surfaces.
    ///
    /// The dissipation of the disturbance is this power and that of the rigid motions. On a mesh
    /// that ends at symmetry planes, it is the power of whole surfaces.
    ///
    /// # Errors
    /// A flow that is not finite.
    pub(crate) fn power_of_surfaces(
        &self,
        flow: &FlowSolution,
        surfaces: Option<&NodalSurfaceFlow>,
    ) -> Result<f64, StokesError> {
        Ok(match surfaces {
            Some(nodal) => {
                let (velocity, pressure) = (&flow.velocity, &flow.pressure);
                self.parts() * fem::power(self.mesh, velocity, pressure, &nodal.velocity)?
            }
            None => 0.0,
        })
    }
}
