//! Flows that do not come from the motion of the bodies: slip and deformation of surfaces,
//! background flow.

use fem::SurfaceVelocity;
use mesh::TetMesh;
use nalgebra::{Matrix3, Vector3};
use rigid::{FlowSolution, FluidNodes};

use crate::StokesError;

/// Slip and deformation of the surfaces of bodies, and the flow in the absence of the bodies.
///
/// The velocity is `u = u_∞ + u'`. The background flow `u_∞` is a solution of the Stokes equations;
/// a [`Problem`](crate::Problem) solves for the disturbance `u'`, with
///
/// ```text
/// u' = U + ω × r + s + Σ a_k' d_k - u_∞    on bodies, with the slip s and the velocities d_k
///                                          of their deformation for rates a_k' of one
/// u' = w                                   on walls, which move with the background flow
/// ```
///
/// The slip has no flux. Bodies whose deformation changes their volume are sources: the velocity
/// `w` of walls has the sum of their fluxes, zero in a container.
///
/// On a closed surface the background flow has no force and no torque, so those of `u'` are those
/// of `u`. On a mesh that ends at symmetry planes slip and background flow are symmetric about
/// them.
pub trait SurfaceFlow: Sync {
    /// Velocity of the surface of `body` relative to its rigid motion, at a point on the surface.
    ///
    /// At points near the surface: its value at the closest point of the surface.
    fn slip(&self, body: usize, x: &Vector3<f64>) -> Vector3<f64>;

    /// Rates of the shape coordinates by which surfaces deform; none by default.
    fn rates(&self) -> &[f64] {
        &[]
    }

    /// Velocity of the surface of `body` relative to its rigid motion for a rate of one of a shape
    /// coordinate, at points as for [`SurfaceFlow::slip`].
    fn of_rate(&self, _coordinate: usize, _body: usize, _x: &Vector3<f64>) -> Vector3<f64> {
        Vector3::zeros()
    }

    /// Rate of the volume of `body` for a rate of one of a shape coordinate, zero by default.
    fn volume_rate(&self, _coordinate: usize, _body: usize) -> f64 {
        0.0
    }

    /// Velocity `w` of walls, zero by default.
    ///
    /// On a wall in place of unbounded fluid it is the far field of bodies that grow. Only one part
    /// of the boundary may have a velocity that is not zero.
    fn at_wall(&self, _x: &Vector3<f64>) -> Vector3<f64> {
        Vector3::zeros()
    }

    /// Velocity of the background flow.
    fn background(&self, x: &Vector3<f64>) -> Vector3<f64>;

    /// Pressure of the background flow at viscosity 1.
    fn background_pressure(&self, x: &Vector3<f64>) -> f64;
}

/// Flux through a body that is rounding, relative to its largest speed and the square of its
/// extent: that of modes which keep the volume is an integral over the surface, of about 1e-15.
const MAX_FLUX_ROUNDING: f64 = 1e-12;

/// Nodal values of a [`SurfaceFlow`] on the mesh of a problem.
pub(crate) struct NodalSurfaceFlow {
    /// `s + Σ a_k' d_k - u_∞` at the nodes of bodies, `w` at those of walls, zero at all others.
    pub velocity: Vec<Vector3<f64>>,
    /// Whether a wall has a velocity that is not zero.
    moves_walls: bool,
    /// Whether the volume of a body changes.
    pub has_sources: bool,
    /// Whether the surface of a body deforms.
    pub deforms: bool,
    /// Boundary part of each body.
    pub tags: Vec<u16>,
    /// `∮ (s + Σ a_k' d_k - u_∞) n^T dS` of each body, over the part in the mesh.
    pub moments: Vec<Matrix3<f64>>,
    /// The slip `s`, then each velocity `d_k`, at the nodes of bodies; zero at all others.
    pub parts: Vec<Vec<Vector3<f64>>>,
    /// The background flow at all nodes, and its pressure at the vertices.
    pub background: (Vec<Vector3<f64>>, Vec<f64>),
}

/// A surface flow with the boundary parts of bodies and walls.
pub(crate) struct BoundaryParts<'a> {
    pub flow: &'a dyn SurfaceFlow,
    /// Boundary part and centre of each body.
    pub bodies: &'a [(u16, Vector3<f64>)],
    pub walls: &'a [u16],
}

impl<'a> BoundaryParts<'a> {
    /// The body of a boundary part; none for all other parts.
    fn body_of(&self, tag: u16) -> Option<usize> {
        self.bodies.iter().position(|(body, _)| *body == tag)
    }

    /// `s + Σ a_k' d_k - u_∞` on the facets of bodies, `w` on those of walls; zero on all others.
    pub fn velocity(self) -> Box<SurfaceVelocity<'a>> {
        Box::new(move |tag, x| {
            let flow = self.flow;
            match self.body_of(tag) {
                Some(body) => {
                    let rates = flow.rates().iter().enumerate();
                    let of_rates = rates.map(|(k, rate)| *rate * flow.of_rate(k, body, &x));
                    let own = flow.slip(body, &x) + of_rates.sum::<Vector3<f64>>();
                    own - flow.background(&x)
                }
                None if self.walls.contains(&tag) => flow.at_wall(&x),
                None => Vector3::zeros(),
            }
        })
    }

    /// A part of the velocity of bodies: the slip, or that of a coordinate after it.
    pub fn part(self, part: usize) -> Box<SurfaceVelocity<'a>> {
        Box::new(move |tag, x| match (self.body_of(tag), part) {
            (None, _) => Vector3::zeros(),
            (Some(body), 0) => self.flow.slip(body, &x),
            (Some(body), coordinate) => self.flow.of_rate(coordinate - 1, body, &x),
        })
    }
}

impl NodalSurfaceFlow {
    /// Nodal values on a mesh with these boundary parts, of which symmetry planes leave a share.
    ///
    /// # Errors
    /// A velocity that is not finite.
    pub fn new(parts: BoundaryParts<'_>, mesh: &TetMesh, share: f64) -> Result<Self, StokesError> {
        let (flow, bodies, walls) = (parts.flow, parts.bodies, parts.walls);
        let velocity = parts.velocity();
        let points = mesh.points();
        let zero = vec![Vector3::zeros(); points.len()];
        let mut nodal = NodalSurfaceFlow {
            velocity: zero.clone(),
            moves_walls: false,
            has_sources: false,
            deforms: flow.rates().iter().any(|rate| *rate != 0.0),
            tags: bodies.iter().map(|(tag, _)| *tag).collect(),
            moments: Vec::with_capacity(bodies.len()),
            parts: vec![zero; 1 + flow.rates().len()],
            background: (
                points.iter().map(|x| flow.background(x)).collect(),
                (points[..mesh.n_vertices()].iter())
                    .map(|x| flow.background_pressure(x))
                    .collect(),
            ),
        };
        let mut outflow = 0.0;
        for (body, &(tag, centre)) in bodies.iter().enumerate() {
            let (mut flux, mut speed, mut extent) = (0.0, 0.0_f64, 0.0_f64);
            for (coordinate, rate) in flow.rates().iter().enumerate() {
                let own_flux = share * flow.volume_rate(coordinate, body);
                flux += rate * own_flux;
                let own = |_: u16, x| flow.of_rate(coordinate, body, &x);
                let on_body = fem::nodal_surface_velocity(mesh, tag, &own, own_flux)?;
                for (node, value) in on_body.values {
                    nodal.parts[1 + coordinate][node as usize] = value;
                }
            }
            let on_body = fem::nodal_surface_velocity(mesh, tag, &*velocity, flux)?;
            for (node, value) in on_body.values {
                speed = speed.max(value.norm());
                extent = extent.max((points[node as usize] - centre).norm());
                nodal.velocity[node as usize] = value;
                nodal.parts[0][node as usize] = flow.slip(body, &points[node as usize]);
            }
            nodal.moments.push(on_body.moment);
            nodal.has_sources |= flux.abs() > MAX_FLUX_ROUNDING * speed * extent * extent;
            outflow += flux;
        }
        for &tag in walls {
            let nodes = mesh.nodes_on(tag);
            let moves = |node: &u32| velocity(tag, points[*node as usize]) != Vector3::zeros();
            if nodes.iter().any(moves) {
                let on_wall = fem::nodal_surface_velocity(mesh, tag, &*velocity, -outflow)?;
                for (node, value) in on_wall.values {
                    nodal.velocity[node as usize] = value;
                }
                nodal.moves_walls = true;
            }
        }
        Ok(nodal)
    }

    /// The nodes with the velocities of bodies and walls, `velocity` at the nodes of this process.
    pub fn on_nodes<'a>(
        &'a self,
        nodes: FluidNodes<'a>,
        velocity: &'a [Vector3<f64>],
    ) -> FluidNodes<'a> {
        let nodes = nodes.with_surface_velocity(velocity, &self.moments);
        match self.moves_walls {
            true => nodes.with_wall_velocity(velocity),
            false => nodes,
        }
    }

    /// Velocities and pressure of a disturbance flow with the background flow.
    pub fn whole(&self, flow: &FlowSolution) -> (Vec<Vector3<f64>>, Vec<f64>) {
        let (velocity, pressure) = &self.background;
        let velocity = flow.velocity.iter().zip(velocity).map(|(u, v)| u + v);
        let pressure = flow.pressure.iter().zip(pressure).map(|(p, q)| p + q);
        (velocity.collect(), pressure.collect())
    }
}
