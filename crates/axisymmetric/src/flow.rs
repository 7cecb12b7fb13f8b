//! The flow around bodies with given velocities, for pictures.

use rayon::prelude::*;
use rheology::ViscosityLaw;

use crate::AxisymmetricError;
use crate::collar::Motion;
use crate::curve::{BoundaryPart, Point};
use crate::element::Lagrange;
use crate::generate::generate;
use crate::geometry_map::node_positions;
use crate::meridian::{Meridian, Surroundings};
use crate::mesh::MeridianMesh;
use crate::nonlinear::{AxialBody, SteadyDrive, SteadyParameters, TriangleValues, law_flow};
use crate::open_boundary::{exterior_flow, exterior_swirl};
use crate::space::Space;
use crate::spheroid::AxialSpheroid;
use crate::surface_modes::{MODES, surface_velocity};
use crate::system::{Dof, Element};

/// Order of the elements: at two, no degree of freedom is eliminated.
const ORDER: usize = 2;

/// Edge length relative to the distance from the focus of the nearest body: velocities have errors
/// of a few thousandths.
const GROWTH: f64 = 0.3;

/// Radius of the meshed ball in unbounded fluid, relative to that of the resistance: it contains
/// the corners of a picture.
const OPEN_RADIUS_FACTOR: f64 = 2.0;

/// Error that a viscosity law may cause beyond an open boundary: a tenth of this, far below that of
/// the elements.
const LAW_TOLERANCE: f64 = 1e-3;

/// Smallest barycentric coordinate of a point that belongs to a triangle, as curved edges are
/// approximated by parabolas.
const MIN_BARYCENTRIC: f64 = -0.01;

/// Velocities of bodies of revolution on one axis, and of their surfaces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyVelocity {
    /// Velocity along the axis.
    pub axial: f64,
    /// Angular velocity about the axis.
    pub angular: f64,
    /// Amplitudes of the modes of the surface, in the order of [`crate::SurfaceMode`].
    pub modes: [f64; MODES],
}

impl BodyVelocity {
    /// Velocity of the surface relative to the body, along the axis and away from it, at a point
    /// relative to the centre of the body.
    pub fn slip(&self, shape: &AxialSpheroid, from_centre: [f64; 2]) -> [f64; 2] {
        let [z, r] = from_centre;
        surface_velocity(shape, &Point::new(shape.centre + z, r), &self.modes)
    }
}

/// Velocity and pressure at a point of the meridian half-plane, for the viscosity 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct MeridianValue {
    /// Velocity along the axis.
    pub axial: f64,
    /// Velocity away from the axis.
    pub radial: f64,
    /// Velocity about the axis.
    pub azimuthal: f64,
    /// Pressure.
    pub pressure: f64,
}

/// A flow in the meridian half-plane by quadratic elements.
///
/// ```
/// use axisymmetric::{BodyVelocity, MeridianFlow, AxialSpheroid, Surroundings};
///
/// let sphere = AxialSpheroid::sphere(0.0, 1.0);
/// let moving = BodyVelocity { axial: 1.0, ..BodyVelocity::default() };
/// let flow = MeridianFlow::new(&[sphere], Surroundings::Unbounded, &[moving])?;
/// let found = flow.at(0.0, 2.0).ok_or("not in the fluid")?;
/// let stokes = 0.75 / 2.0 + 0.25 / 8.0; // 3 a / (4 r) + a^3 / (4 r^3) beside the sphere
/// assert!((found.axial / stokes - 1.0).abs() < 5e-3);
/// assert!(flow.at(0.0, 0.5).is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct MeridianFlow {
    triangles: Vec<Triangle>,
}

/// A triangle with six nodes: corners, then the middles of the edges from each corner to the next.
#[derive(Clone, Debug)]
struct Triangle {
    positions: [Point; 6],
    axial: [f64; 6],
    radial: [f64; 6],
    azimuthal: [f64; 6],
    /// At the corners.
    pressure: [f64; 3],
    /// Bounds of the positions, enlarged.
    bounds: [Point; 2],
}

impl MeridianFlow {
    /// The flow around bodies with these velocities.
    ///
    /// Unbounded fluid is known in a ball of three times the radius of the bodies together.
    ///
    /// # Errors
    /// As [`crate::axial_resistance`], except for tolerances.
    pub fn new(
        bodies: &[AxialSpheroid],
        surroundings: Surroundings,
        velocities: &[BodyVelocity],
    ) -> Result<Self, AxisymmetricError> {
        let meridian = Meridian::new(bodies, surroundings)?.enlarged(OPEN_RADIUS_FACTOR);
        let mesh = generate(&meridian, GROWTH)?;
        let element = Lagrange::new(ORDER)?;
        let parts = Space::new(&mesh, &element).parts(&mesh, &element);
        let at = |body: usize| velocities.get(body).cloned().unwrap_or_default();
        let solve = |motion: Motion, amplitudes: &[f64]| {
            let mut system = motion.system(&mesh, ORDER, bodies)?;
            // Degrees of freedom of the triangles only, in their order.
            let dofs: Vec<Vec<Dof>> = system.elements.iter().map(|e| e.dofs.clone()).collect();
            if let Some(sphere) = &meridian.open_sphere() {
                let matrix = match motion {
                    Motion::Rotation => exterior_swirl(&mesh, ORDER, sphere),
                    Motion::Translation | Motion::Surfaces => exterior_flow(&mesh, ORDER, sphere),
                };
                let dofs = system.trace(BoundaryPart::Open)[..matrix.nrows()].to_vec();
                system.elements.push(Element { dofs, matrix });
            }
            Ok::<_, AxisymmetricError>((dofs, system.flow(amplitudes)?))
        };
        let n = bodies.len();
        let own = (0..n).map(|body| at(body).axial);
        let modes = (0..n).flat_map(|body| at(body).modes);
        let has_modes = modes.clone().any(|amplitude| amplitude != 0.0);
        let (dofs, flow) = match has_modes {
            true => solve(Motion::Surfaces, &own.chain(modes).collect::<Vec<_>>())?,
            false => solve(Motion::Translation, &own.collect::<Vec<_>>())?,
        };
        let spins: Vec<f64> = (0..n).map(|body| at(body).angular).collect();
        let swirl = match spins.iter().any(|spin| *spin != 0.0) {
            true => Some(solve(Motion::Rotation, &spins)?),
            false => None,
        };
        let numbers = Space::new(&mesh, &element).nodes;
        let triangles = (0..mesh.triangles.len()).map(|t| {
            let positions = nodes_of(&mesh, t, &element);
            let free = |dof: Dof, flow: &[f64]| match dof {
                Dof::Free(i) => flow[i as usize],
                Dof::Constrained | Dof::Body(_) => 0.0,
            };
            let on_body = |k: usize| match parts[numbers[t][k] as usize] {
                Some(BoundaryPart::Body(body)) => Some(body),
                _ => None,
            };
            let velocity = |k: usize| match on_body(k) {
                Some(body) => {
                    let moving = at(body);
                    let [z, r] = surface_velocity(&bodies[body], &positions[k], &moving.modes);
                    [moving.axial + z, r]
                }
                None => [k, 6 + k].map(|local| free(dofs[t][local], &flow)),
            };
            let azimuthal = |k: usize| match (on_body(k), &swirl) {
                (Some(body), _) => spins[body] * positions[k].y,
                (None, Some((dofs, flow))) => free(dofs[t][k], flow),
                (None, None) => 0.0,
            };
            Triangle {
                axial: std::array::from_fn(|k| velocity(k)[0]),
                radial: std::array::from_fn(|k| velocity(k)[1]),
                azimuthal: std::array::from_fn(azimuthal),
                pressure: std::array::from_fn(|k| free(dofs[t][12 + k], &flow)),
                bounds: bounds(&positions),
                positions,
            }
        });
        Ok(Self {
            triangles: triangles.collect(),
        })
    }

    /// The flow around bodies with these velocities in a fluid with a viscosity law.
    ///
    /// Angular velocities are not supported and have no effect. Unbounded fluid is known in a ball
    /// of three times the radius of the bodies together, or more.
    ///
    /// # Errors
    /// As [`crate::AxialForceSolver::solve`].
    pub fn with_law(
        bodies: &[AxialSpheroid],
        surroundings: Surroundings,
        velocities: &[BodyVelocity],
        law: &dyn ViscosityLaw,
    ) -> Result<Self, AxisymmetricError> {
        let list: Vec<AxialBody> = bodies.iter().map(|b| AxialBody::prescribed(*b)).collect();
        let at = |body: usize| velocities.get(body).cloned().unwrap_or_default();
        let axial: Vec<f64> = (0..bodies.len()).map(|body| at(body).axial).collect();
        let slip = |body: usize, x: [f64; 2]| at(body).slip(&bodies[body], x);
        let drive = SteadyDrive {
            velocities: &axial,
            slip: Some(&slip),
            ..SteadyDrive::default()
        };
        let parameters = SteadyParameters::new(0.0)
            .with_law(law)
            .with_growth(GROWTH)
            .with_tolerance(LAW_TOLERANCE);
        let factor = OPEN_RADIUS_FACTOR;
        let values = law_flow(&list, surroundings, &drive, &parameters, ORDER, factor)?;
        let triangle = |values: TriangleValues| {
            let positions: [Point; 6] = std::array::from_fn(|k| values.positions[k]);
            Triangle {
                axial: std::array::from_fn(|k| values.velocities[k].x),
                radial: std::array::from_fn(|k| values.velocities[k].y),
                azimuthal: [0.0; 6],
                pressure: std::array::from_fn(|k| values.pressures[k]),
                bounds: bounds(&positions),
                positions,
            }
        };
        Ok(Self {
            triangles: values.into_iter().map(triangle).collect(),
        })
    }

    /// The flow at a position along the axis and a distance from it; `None` outside the mesh.
    pub fn at(&self, z: f64, r: f64) -> Option<MeridianValue> {
        let x = Point::new(z, r.abs());
        self.triangles.iter().find_map(|triangle| triangle.at(&x))
    }

    /// The flow at several points, in parallel.
    pub fn at_points(&self, points: &[[f64; 2]]) -> Vec<Option<MeridianValue>> {
        points.par_iter().map(|[z, r]| self.at(*z, *r)).collect()
    }
}

impl Triangle {
    fn at(&self, x: &Point) -> Option<MeridianValue> {
        let [low, high] = &self.bounds;
        if x.x < low.x || x.x > high.x || x.y < low.y || x.y > high.y {
            return None;
        }
        let l = self.barycentric(x)?;
        let shapes = quadratic(&l);
        let sum = |values: &[f64; 6]| values.iter().zip(&shapes).map(|(v, n)| v * n).sum();
        Some(MeridianValue {
            axial: sum(&self.axial),
            radial: sum(&self.radial),
            azimuthal: sum(&self.azimuthal),
            pressure: self.pressure.iter().zip(&l).map(|(p, l)| p * l).sum(),
        })
    }

    /// Barycentric coordinates by Newton's method; `None` outside the triangle.
    fn barycentric(&self, x: &Point) -> Option<[f64; 3]> {
        // Six steps are more than a triangle needs whose edges are slightly bent.
        const STEPS: usize = 6;
        let mut l = [1.0 / 3.0; 3];
        for _ in 0..STEPS {
            let mut residual = *x;
            for (position, n) in self.positions.iter().zip(quadratic(&l)) {
                residual -= position * n;
            }
            let mut slopes = [Point::zeros(); 3];
            for k in 0..3 {
                slopes[k] += self.positions[k] * (4.0 * l[k] - 1.0);
                let next = (k + 1) % 3;
                slopes[k] += self.positions[3 + k] * (4.0 * l[next]);
                slopes[next] += self.positions[3 + k] * (4.0 * l[k]);
            }
            let columns = [slopes[1] - slopes[0], slopes[2] - slopes[0]];
            let step = nalgebra::Matrix2::from_columns(&columns)
                .lu()
                .solve(&residual)?;
            l[1] += step.x;
            l[2] += step.y;
            l[0] = 1.0 - l[1] - l[2];
        }
        l.iter().all(|l| *l >= MIN_BARYCENTRIC).then_some(l)
    }
}

fn nodes_of(mesh: &MeridianMesh, triangle: usize, element: &Lagrange) -> [Point; 6] {
    let positions = node_positions(mesh, triangle, element);
    std::array::from_fn(|k| positions[k])
}

/// Bounds of a triangle with six nodes.
fn bounds(positions: &[Point; 6]) -> [Point; 2] {
    let infinite = Point::repeat(f64::INFINITY);
    let [low, high] = (positions.iter()).fold([infinite, -infinite], |[low, high], x| {
        [low.inf(x), high.sup(x)]
    });
    // An edge bends beyond its nodes by a quarter of its height at most.
    let margin = 0.1 * (high - low);
    [low - margin, high + margin]
}

/// The quadratic basis at barycentric coordinates.
fn quadratic(l: &[f64; 3]) -> [f64; 6] {
    std::array::from_fn(|k| match k.checked_sub(3) {
        None => l[k] * (2.0 * l[k] - 1.0),
        Some(edge) => 4.0 * l[edge] * l[(edge + 1) % 3],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sphere that rotates: `u_phi = ω a^3 sin θ / r^2`, without pressure.
    #[test]
    fn the_flow_about_a_spinning_sphere_is_that_of_a_rotlet() {
        let spinning = BodyVelocity {
            angular: 2.0,
            ..BodyVelocity::default()
        };
        let sphere = AxialSpheroid::sphere(0.5, 1.0);
        let flow = MeridianFlow::new(&[sphere], Surroundings::Unbounded, &[spinning]).unwrap();
        for (z, r) in [(0.5, 1.2), (1.5, 0.9), (-0.7, 0.6)] {
            let distance = f64::hypot(z - 0.5, r);
            let exact = 2.0 * r / distance.powi(3);
            let found = flow.at(z, r).unwrap();
            assert!((found.azimuthal - exact).abs() < 5e-3, "{found:?}, {exact}");
            assert!(found.axial.abs() + found.radial.abs() + found.pressure.abs() < 1e-10);
        }
    }

    /// A force-free squirmer with the first mode: `u = B (3 (n.k) n - k) / (3 r^3)`, speed 2 B / 3
    /// (Blake 1971).
    #[test]
    fn the_flow_about_a_neutral_squirmer_is_a_source_dipole() {
        let swimming = BodyVelocity {
            axial: 2.0 / 3.0,
            modes: [1.0, 0.0, 0.0, 0.0],
            ..BodyVelocity::default()
        };
        let sphere = AxialSpheroid::sphere(0.0, 1.0);
        let flow = MeridianFlow::new(&[sphere], Surroundings::Unbounded, &[swimming]).unwrap();
        for (z, r) in [(0.0, 1.3), (1.4, 0.2), (-1.0, 1.0)] {
            let distance = f64::hypot(z, r);
            let cos = z / distance;
            let strength = 1.0 / (3.0 * distance.powi(3));
            let exact = [
                strength * (3.0 * cos * cos - 1.0),
                strength * 3.0 * cos * r / distance,
            ];
            let found = flow.at(z, r).unwrap();
            assert!(
                (found.axial - exact[0]).abs() < 5e-3,
                "{found:?}, {exact:?}"
            );
            assert!(
                (found.radial - exact[1]).abs() < 5e-3,
                "{found:?}, {exact:?}"
            );
        }
    }
}
