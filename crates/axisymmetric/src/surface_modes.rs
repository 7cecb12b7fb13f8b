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

/// The unit vector from a centre on the axis to a point.
pub(crate) fn direction_from(centre: f64, x: &Point) -> [f64; 2] {
    let arm = x - Point::new(centre, 0.0);
    let length = arm.norm().max(f64::MIN_POSITIVE);
    [arm.x / length, arm.y / length]
}

/// Velocities of surfaces that are prescribed like those of bodies, one column each.
pub(crate) trait SurfaceColumns: Sync {
    /// Number of columns.
    fn count(&self) -> usize;

    /// The columns that move the surface of a body at a point, with their velocities along the axis
    /// and away from it.
    fn at(&self, body: usize, x: &Point) -> Vec<(usize, [f64; 2])>;

    /// A direction out of a body at a point of its surface.
    fn outwards(&self, body: usize, x: &Point) -> [f64; 2];

    /// Flux of a column out of a body.
    fn flux(&self, column: usize, body: usize) -> f64;
}

/// The modes of spheroids: those of the first body, then of the next.
pub(crate) struct SpheroidModes<'a>(pub &'a [AxialSpheroid]);

impl SurfaceColumns for SpheroidModes<'_> {
    fn count(&self) -> usize {
        MODES * self.0.len()
    }

    fn at(&self, body: usize, x: &Point) -> Vec<(usize, [f64; 2])> {
        let of_mode = |(mode, velocity)| (MODES * body + mode, velocity);
        let modes = velocities(&self.0[body], x).into_iter().enumerate();
        modes.map(of_mode).collect()
    }

    fn outwards(&self, body: usize, x: &Point) -> [f64; 2] {
        normal(&self.0[body], x)
    }

    fn flux(&self, _: usize, _: usize) -> f64 {
        0.0
    }
}

/// Prescribed velocities at the nodes of surfaces, with exact fluxes.
pub(crate) struct SurfaceVelocities<'a> {
    columns: &'a dyn SurfaceColumns,
    /// Number of bodies.
    bodies: usize,
    /// For each column and body, the multiple of the outward directions that is subtracted from its
    /// nodal values.
    corrections: Vec<Vec<f64>>,
    /// For each column, the multiple of the outward directions with which the wall moves.
    of_wall: Vec<f64>,
    /// Mean position of the nodes on the wall.
    centre: f64,
    /// Boundary part of each node.
    parts: Vec<Option<BoundaryPart>>,
    velocity: &'a Lagrange,
    mesh: &'a MeridianMesh,
    space: &'a Space,
}

/// A surface on which nodes lie.
#[derive(Clone, Copy, PartialEq)]
enum Surface {
    Body(usize),
    Wall,
}

impl<'a> SurfaceVelocities<'a> {
    /// The velocities on a mesh with velocities of these elements, around a number of bodies.
    ///
    /// The flux of an interpolated velocity has an interpolation error; in a container there would
    /// be no flow with it. The nodal outward directions times the ratio of the fluxes are
    /// subtracted. The wall of a container lets out what bodies displace, so that each column has a
    /// flow; sums of columns without a flux have that of a wall at rest.
    pub fn new(
        columns: &'a dyn SurfaceColumns,
        bodies: usize,
        (mesh, velocity, space): (&'a MeridianMesh, &'a Lagrange, &'a Space),
        matrices: &[ElementMatrices],
    ) -> Self {
        let mut found = Self {
            columns,
            bodies,
            corrections: vec![vec![0.0; bodies]; columns.count()],
            of_wall: vec![0.0; columns.count()],
            centre: 0.0,
            parts: space.parts(mesh, velocity),
            velocity,
            mesh,
            space,
        };
        let on_wall: Vec<f64> = (0..matrices.len())
            .flat_map(|t| found.nodes_on_surfaces(t))
            .filter(|(_, surface, _)| *surface == Surface::Wall)
            .map(|(.., x)| x.x)
            .collect();
        found.centre = match on_wall.len() {
            0 => 0.0,
            n => on_wall.iter().sum::<f64>() / n as f64,
        };
        let (mut of_directions, mut of_wall) = (vec![0.0; bodies], 0.0);
        for (t, matrices) in matrices.iter().enumerate() {
            for (node, surface, x) in found.nodes_on_surfaces(t) {
                // The divergence has the flux out of the fluid.
                let flux = |[z, r]: [f64; 2]| {
                    -z * matrices.divergence_axial.column(node).sum()
                        - r * matrices.divergence_radial.column(node).sum()
                };
                match surface {
                    Surface::Wall => of_wall += flux(found.out_of_wall(&x)),
                    Surface::Body(body) => {
                        of_directions[body] += flux(columns.outwards(body, &x));
                        for (column, velocity) in columns.at(body, &x) {
                            found.corrections[column][body] += flux(velocity);
                        }
                    }
                }
            }
        }
        for column in 0..columns.count() {
            let mut net = 0.0;
            for (body, of_directions) in of_directions.iter().enumerate() {
                // The divergence is that of its own sign convention for the outward directions.
                let sign = of_directions.signum();
                let exact = columns.flux(column, body);
                net += exact;
                let correction = &mut found.corrections[column][body];
                *correction = (*correction - sign * exact) / of_directions;
            }
            if of_wall != 0.0 && net != 0.0 {
                found.of_wall[column] = net / of_wall.abs();
            }
        }
        found
    }

    /// The direction from the centre of the wall.
    fn out_of_wall(&self, x: &Point) -> [f64; 2] {
        direction_from(self.centre, x)
    }

    /// Local number, surface and position of the nodes of a triangle that are on surfaces.
    fn nodes_on_surfaces(&self, triangle: usize) -> Vec<(usize, Surface, Point)> {
        let nodes = &self.space.nodes[triangle][..self.velocity.n_shared_nodes()];
        let surface = |(local, &node): (usize, &u32)| match self.parts[node as usize] {
            Some(BoundaryPart::Body(body)) => Some((local, Surface::Body(body))),
            Some(BoundaryPart::Wall) => Some((local, Surface::Wall)),
            _ => None,
        };
        let found: Vec<(usize, Surface)> = nodes.iter().enumerate().filter_map(surface).collect();
        if found.is_empty() {
            return Vec::new();
        }
        let positions = node_positions(self.mesh, triangle, self.velocity);
        let with_position = |(local, surface)| (local, surface, positions[local]);
        found.into_iter().map(with_position).collect()
    }

    /// The columns that are not zero at a node, with its velocities.
    fn at(&self, surface: Surface, x: &Point) -> Vec<(usize, [f64; 2])> {
        match surface {
            Surface::Wall => {
                let outwards = self.out_of_wall(x);
                let columns = self.of_wall.iter().enumerate();
                let moving = columns.filter(|(_, factor)| **factor != 0.0);
                moving
                    .map(|(column, factor)| (column, outwards.map(|u| factor * u)))
                    .collect()
            }
            Surface::Body(body) => {
                let outwards = self.columns.outwards(body, x);
                let corrected = |(column, velocity): (usize, [f64; 2])| {
                    let correction = self.corrections[column][body];
                    let velocity = [0, 1].map(|k| velocity[k] - correction * outwards[k]);
                    (column, velocity)
                };
                let columns = self.columns.at(body, x).into_iter();
                columns.map(corrected).collect()
            }
        }
    }

    /// The degrees of freedom and the matrix of a triangle with those of the columns on its
    /// surfaces.
    ///
    /// With the nodal values `s` of a column, its column of the matrix `M` is `M s`.
    pub fn with_columns(
        &self,
        triangle: usize,
        mut dofs: Vec<Dof>,
        matrix: DMatrix<f64>,
    ) -> (Vec<Dof>, DMatrix<f64>) {
        let on_surfaces: Vec<_> = (self.nodes_on_surfaces(triangle).into_iter())
            .map(|(local, surface, x)| (local, self.at(surface, &x)))
            .collect();
        let columns = on_surfaces.iter().flat_map(|(_, columns)| columns);
        let mut present: Vec<usize> = columns.map(|(column, _)| *column).collect();
        present.sort_unstable();
        present.dedup();
        if present.is_empty() {
            return (dofs, matrix);
        }
        let (old, radial) = (matrix.nrows(), self.velocity.n_shared_nodes());
        let mut values = DMatrix::zeros(old, present.len());
        for (local, columns) in on_surfaces {
            for (column, [axial, away]) in columns {
                let place = present.binary_search(&column).unwrap_or_default();
                values[(local, place)] = axial;
                values[(radial + local, place)] = away;
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
        dofs.extend(
            present
                .into_iter()
                .map(|column| Dof::Body(self.bodies + column)),
        );
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
