//! Velocities of the surfaces of bodies: slip, extension and Poiseuille flow.
//!
//! Each mode is a velocity of the surface without swirl, prescribed like the velocity of a body:
//! its amplitude is one more column of the resistance matrix.

use std::f64::consts::PI;

use nalgebra::{DMatrix, Matrix3, Matrix4, Vector3};

use crate::curve::{BoundaryPart, Point};
use crate::element::Lagrange;
use crate::forms::ElementMatrices;
use crate::geometry_map::node_positions;
use crate::mesh::MeridianMesh;
use crate::space::Space;
use crate::spheroid::AxialSpheroid;
use crate::system::Dof;

/// Number of modes of each body; [`crate::SurfaceMode`] has their order.
pub(crate) const MODES: usize = 4;

/// Power of the unit of length in the velocity of a mode with the amplitude one.
pub(crate) const LENGTHS: [i32; MODES] = [0, 0, 1, 2];

/// Sign of a mode after a reflection of the axis.
pub(crate) const PARITIES: [f64; MODES] = [-1.0, 1.0, 1.0, -1.0];

/// Velocity of a surface without swirl; `n` is the outward normal, `k` the unit vector along the
/// axis, and positions are relative to the centre of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SurfaceMode {
    /// Slip `-(I - n n^T) k`: the first mode of a squirmer.
    FirstSlip,
    /// Slip `-(n·k) (I - n n^T) k`: the second mode of a squirmer.
    SecondSlip,
    /// Extension along the axis, `u_z = z`, `u_r = -r / 2`.
    Extension,
    /// The parabola `u_z = r^2`.
    Parabola,
}

/// Outward normal of a body at, or near, its surface.
pub(crate) fn normal(body: &AxialSpheroid, x: &Point) -> [f64; 2] {
    let z = (x.x - body.centre) / (body.axial * body.axial);
    let r = x.y / (body.equatorial * body.equatorial);
    let length = z.hypot(r);
    [z / length, r / length]
}

/// Axial and radial velocity of all modes at a point of the surface.
fn velocities(body: &AxialSpheroid, x: &Point) -> [[f64; 2]; MODES] {
    let [z, r] = normal(body, x);
    let slip = [z * z - 1.0, z * r];
    [
        slip,
        slip.map(|u| z * u),
        [x.x - body.centre, -0.5 * x.y],
        [x.y * x.y, 0.0],
    ]
}

/// Axial and radial velocity of a surface with these amplitudes of its modes.
pub(crate) fn surface_velocity(
    body: &AxialSpheroid,
    x: &Point,
    amplitudes: &[f64; MODES],
) -> [f64; 2] {
    let modes = velocities(body, x);
    [0, 1].map(|k| modes.iter().zip(amplitudes).map(|(u, a)| u[k] * a).sum())
}

/// Modes at the nodes of the bodies, without flux.
pub(crate) struct SurfaceModes<'a> {
    bodies: &'a [AxialSpheroid],
    /// For each body and mode, the multiple of the normal that is subtracted from its nodal values.
    fluxes: Vec<[f64; MODES]>,
    /// Boundary part of each node.
    parts: Vec<Option<BoundaryPart>>,
    velocity: &'a Lagrange,
    mesh: &'a MeridianMesh,
    space: &'a Space,
}

impl<'a> SurfaceModes<'a> {
    /// The modes on a mesh with velocities of these elements.
    ///
    /// The flux of an interpolated mode is an interpolation error; in a container there would be no
    /// flow with it. The nodal normals times the ratio of the fluxes are subtracted.
    pub fn new(
        bodies: &'a [AxialSpheroid],
        mesh: &'a MeridianMesh,
        velocity: &'a Lagrange,
        space: &'a Space,
        matrices: &[ElementMatrices],
    ) -> Self {
        let mut modes = Self {
            bodies,
            fluxes: vec![[0.0; MODES]; bodies.len()],
            parts: space.parts(mesh, velocity),
            velocity,
            mesh,
            space,
        };
        let mut of_normals = vec![0.0; bodies.len()];
        for (t, matrices) in matrices.iter().enumerate() {
            for (node, body, x) in modes.nodes_on_bodies(t) {
                let flux = |[z, r]: [f64; 2]| {
                    z * matrices.divergence_axial.column(node).sum()
                        + r * matrices.divergence_radial.column(node).sum()
                };
                of_normals[body] += flux(normal(&bodies[body], &x));
                let of_modes = velocities(&bodies[body], &x);
                for (sum, velocity) in modes.fluxes[body].iter_mut().zip(of_modes) {
                    *sum += flux(velocity);
                }
            }
        }
        for (fluxes, of_normal) in modes.fluxes.iter_mut().zip(of_normals) {
            fluxes.iter_mut().for_each(|flux| *flux /= of_normal);
        }
        modes
    }

    /// Local number, body and position of the nodes of a triangle that are on bodies.
    fn nodes_on_bodies(&self, triangle: usize) -> Vec<(usize, usize, Point)> {
        let nodes = &self.space.nodes[triangle][..self.velocity.n_shared_nodes()];
        let body = |(local, &node): (usize, &u32)| match self.parts[node as usize] {
            Some(BoundaryPart::Body(body)) => Some((local, body)),
            _ => None,
        };
        let found: Vec<(usize, usize)> = nodes.iter().enumerate().filter_map(body).collect();
        if found.is_empty() {
            return Vec::new();
        }
        let positions = node_positions(self.mesh, triangle, self.velocity);
        let with_position = |(local, body)| (local, body, positions[local]);
        found.into_iter().map(with_position).collect()
    }

    /// The degrees of freedom and the matrix of a triangle with those of the modes on its bodies.
    ///
    /// With the nodal values `s` of a mode, its column of the matrix `M` is `M s`.
    pub fn with_modes(
        &self,
        triangle: usize,
        mut dofs: Vec<Dof>,
        matrix: DMatrix<f64>,
    ) -> (Vec<Dof>, DMatrix<f64>) {
        let on_bodies = self.nodes_on_bodies(triangle);
        let mut present: Vec<usize> = on_bodies.iter().map(|(_, body, _)| *body).collect();
        present.sort_unstable();
        present.dedup();
        if present.is_empty() {
            return (dofs, matrix);
        }
        let (old, radial) = (matrix.nrows(), self.velocity.n_shared_nodes());
        let mut values = DMatrix::zeros(old, MODES * present.len());
        for (local, body, x) in on_bodies {
            let place = present.binary_search(&body).unwrap_or_default();
            let spheroid = &self.bodies[body];
            let n = normal(spheroid, &x);
            for (mode, velocity) in velocities(spheroid, &x).into_iter().enumerate() {
                let flux = self.fluxes[body][mode];
                let column = MODES * place + mode;
                values[(local, column)] = velocity[0] - flux * n[0];
                values[(radial + local, column)] = velocity[1] - flux * n[1];
            }
        }
        let size = old + values.ncols();
        let mut extended = DMatrix::zeros(size, size);
        let columns = &matrix * &values;
        extended.view_mut((0, 0), (old, old)).copy_from(&matrix);
        extended
            .view_mut((0, old), columns.shape())
            .copy_from(&columns);
        extended
            .view_mut((old, 0), (columns.ncols(), old))
            .copy_from(&columns.transpose());
        let corner = values.tr_mul(&columns);
        extended
            .view_mut((old, old), corner.shape())
            .copy_from(&corner);
        let first = |body: usize| self.bodies.len() + MODES * body;
        let of_body = |body: usize| (first(body)..first(body) + MODES).map(Dof::Body);
        dofs.extend(present.into_iter().flat_map(of_body));
        (dofs, extended)
    }
}

/// Powers that the form `∫ ∇u:∇v` omits for the modes of one body.
///
/// ```text
/// 2 ∫ D(u):D(v) = ∫ ∇u:∇v + ∮ (n_j u_i ∂_i v_j - u·n ∂_j v_j) dS
/// ```
///
/// for divergence-free flows, with the normal `n` out of the fluid. The integrand contains
/// tangential derivatives of `v` alone, so any extension of `v` from the surface serves.
pub(crate) fn omitted_powers(body: &AxialSpheroid) -> Matrix4<f64> {
    over_surface(body, |n, u, gradients| {
        // n is out of the body, so that the sign is reversed
        let term = |i: usize, j: usize| {
            let (u, gradient) = (&u[i], &gradients[j]);
            -(n.dot(&(gradient * u)) - gradient.trace() * u.dot(n))
        };
        Matrix4::from_fn(term)
    })
}

/// Powers `∮ u_i · 2 E_j n dS` of modes in the viscous stress of the flows that continue modes,
/// with the normal out of the body.
///
/// Of the columns, those of the extension and the parabola are flows. Slip is tangential, so their
/// pressure does not contribute to its rows.
pub(crate) fn powers_in_flows(body: &AxialSpheroid) -> Matrix4<f64> {
    over_surface(body, |n, u, gradients| {
        Matrix4::from_fn(|i, j| {
            let gradient = &gradients[j];
            u[i].dot(&((gradient + gradient.transpose()) * n))
        })
    })
}

/// Integral over the surface of a body; arguments are the outward normal, the velocities of the
/// modes and their gradients `∂u_i/∂x_j`, in coordinates with the axis z of the flow first.
fn over_surface(
    body: &AxialSpheroid,
    f: impl Fn(&Vector3<f64>, &[Vector3<f64>; MODES], &[Matrix3<f64>; MODES]) -> Matrix4<f64>,
) -> Matrix4<f64> {
    /// Intervals of the eccentric angle; the midpoint rule converges geometrically for analytic
    /// functions of an angle with this symmetry.
    const INTERVALS: usize = 2000;
    let (a, b) = (body.axial, body.equatorial);
    let diagonal =
        Matrix3::from_diagonal(&Vector3::new(1.0 / (a * a), 1.0 / (b * b), 1.0 / (b * b)));
    let k = Vector3::x();
    let step = PI / INTERVALS as f64;
    let terms = (0..INTERVALS).map(|interval| {
        let (sin, cos) = ((interval as f64 + 0.5) * step).sin_cos();
        let x = Vector3::new(a * cos, b * sin, 0.0);
        let area = 2.0 * PI * b * sin * (a * sin).hypot(b * cos) * step;
        let along = diagonal * x;
        let n = along.normalize();
        let of_normal = (Matrix3::identity() - n * n.transpose()) * diagonal / along.norm();
        let cosine = n.dot(&k);
        let of_cosine = (k.transpose() * of_normal).transpose();
        let slip = cosine * n - k;
        let of_slip = n * of_cosine.transpose() + cosine * of_normal;
        let velocities = [
            slip,
            cosine * slip,
            Vector3::new(x.x, -0.5 * x.y, -0.5 * x.z),
            k * x.yz().norm_squared(),
        ];
        let gradients = [
            of_slip,
            cosine * of_slip + slip * of_cosine.transpose(),
            Matrix3::from_diagonal(&Vector3::new(1.0, -0.5, -0.5)),
            k * Vector3::new(0.0, 2.0 * x.y, 2.0 * x.z).transpose(),
        ];
        area * f(&n, &velocities, &gradients)
    });
    terms.sum()
}
