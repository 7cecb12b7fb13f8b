//! A body of a scene.

use std::borrow::Cow;
use std::f64::consts::PI;

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use rigid::{Articulation, BodyKind, Constraints, RigidError, Twist};

use crate::deformation::Deformation;
use crate::flow::Slip;
use crate::loads::{DrivingLoad, VectorOscillation};
use crate::shape::Shape;
use crate::sphere_deformation::SphereDeformation;
use crate::words::AxesKind;

/// A body.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Body {
    /// Name, unique in the scene.
    pub name: String,
    /// Shape.
    pub shape: Shape,
    /// Centre in the initial configuration.
    pub position: Vector3<f64>,
    /// Name of the body's part of the mesh boundary, if the domain is a mesh.
    pub surface: Option<String>,
    /// External force that is constant in the laboratory axes, without the weight.
    pub force: Vector3<f64>,
    /// External force that depends on the time or on the attitude, in addition to `force`.
    pub driving_force: Option<DrivingLoad>,
    /// Weight minus buoyancy, which acts on the centre of volume ([`Body::weight_arm`]): zero
    /// without a density or without gravity.
    pub weight: Vector3<f64>,
    /// External torque about the centre that is constant in the laboratory axes.
    pub torque: Vector3<f64>,
    /// External torque that depends on the time or on the attitude, in addition to `torque`.
    pub driving_torque: Option<DrivingLoad>,
    /// Magnetic moment in the initial configuration, which turns with the body.
    pub moment: Vector3<f64>,
    /// Whether the body is fixed in space: its velocity and angular velocity are zero.
    pub fixed: bool,
    /// Given velocity of the centre; `None` if the flow determines it, or for a fixed body.
    pub velocity: Option<VectorOscillation>,
    /// Given angular velocity; `None` if the flow determines it, or for a fixed body.
    pub angular_velocity: Option<VectorOscillation>,
    /// Density, for the weight; `None` if the body has the density of the fluid.
    pub density: Option<f64>,
    /// Tangential velocity of the surface.
    pub slip: Option<Slip>,
    /// Deformation by shape coordinates; `shape` is the undeformed one, of a tube that of the wave
    /// that its keys give.
    pub deformation: Option<Deformation>,
    /// Mass; zero if inertia is neglected.
    pub mass: f64,
    /// Moment of inertia about the centre; zero if inertia is neglected.
    pub inertia: f64,
}

impl Body {
    /// External force with the weight.
    pub fn total_force(&self) -> Vector3<f64> {
        self.force + self.weight
    }

    /// Whether loads on the body depend on its attitude: of a moment in a field, in the axes of the
    /// body, or of a weight that acts off its position.
    pub(crate) fn has_turning_load(&self) -> bool {
        let turns = |drive: &Option<DrivingLoad>| drive.is_some_and(|d| d.axes == AxesKind::Body);
        let is_heavy = self.weight != Vector3::zeros() && self.weight_arm().is_some();
        turns(&self.driving_force)
            || turns(&self.driving_torque)
            || self.moment != Vector3::zeros()
            || is_heavy
    }

    /// Whether loads act on the body that depend on the time or on its attitude, but for weights.
    pub fn is_driven(&self) -> bool {
        self.driving_force.is_some()
            || self.driving_torque.is_some()
            || self.moment != Vector3::zeros()
    }

    /// The velocity of the centre, if it is given: zero for a fixed body.
    pub fn held_velocity(&self) -> Option<VectorOscillation> {
        self.velocity.or(self.fixed.then(at_rest))
    }

    /// The angular velocity, if it is given: zero for a fixed body.
    pub fn held_angular_velocity(&self) -> Option<VectorOscillation> {
        self.angular_velocity.or(self.fixed.then(at_rest))
    }

    /// Given velocity and angular velocity at a time; zero for what is not given.
    pub fn held_twist(&self, time: f64) -> Twist {
        let at = |given: Option<VectorOscillation>| given.unwrap_or_else(at_rest).at(time);
        Twist {
            linear: at(self.held_velocity()),
            angular: at(self.held_angular_velocity()),
        }
    }

    /// Upper bounds of the size of each component of the given velocities.
    pub(crate) fn largest_held_twist(&self) -> Twist {
        let largest = |given: Option<VectorOscillation>| given.unwrap_or_else(at_rest).largest();
        Twist {
            linear: largest(self.held_velocity()),
            angular: largest(self.held_angular_velocity()),
        }
    }

    /// Radius of the smallest ball about the centre that contains the body; zero for points.
    pub fn bounding_radius(&self) -> f64 {
        self.shape.bounding_radius()
    }

    /// The same of a tube however a wave bends it.
    pub(crate) fn largest_radius(&self) -> f64 {
        let bent = match &self.deformation {
            Some(Deformation::Undulation(tube)) => tube.wave.offset(tube.tube.length),
            Some(Deformation::Sphere(_) | Deformation::Triangles(_)) | None => 0.0,
        };
        self.bounding_radius() + bent
    }

    /// Radius of the ball about the centre that contains the body at these values of the joints.
    pub fn bounding_radius_at(&self, values: &[f64]) -> f64 {
        let deformation = self.deformation.as_ref();
        deformation.map_or_else(|| self.bounding_radius(), |of| of.bounding_radius(values))
    }

    /// The body at these values of the joints; of one that deforms, its [`Deformation::outline`].
    pub fn at(&self, values: &[f64]) -> Cow<'_, Self> {
        match &self.deformation {
            None => Cow::Borrowed(self),
            Some(deformation) => Cow::Owned(Self {
                shape: deformation.outline(values),
                ..self.clone()
            }),
        }
    }

    /// Mass and moments of inertia about the centre in the axes of the scene at the start, at the
    /// radius of the scene; `None` for bodies without inertia.
    ///
    /// A moment of inertia that is not given is that of a homogeneous body
    /// ([`Shape::inertia_per_mass`]).
    pub fn mass_matrix(&self) -> Option<(f64, Matrix3<f64>)> {
        self.matrix_of_mass(self.mass)
    }

    /// The same at these values of the joints.
    ///
    /// The mass of a body that deforms is constant. Its inside is stretched like a sphere that
    /// changes its size, so that its moment of inertia grows with the square of the radius, however
    /// the mass is distributed along it, and its centre of mass stays the centre. Bodies with other
    /// deformations have no mass: where the mass inside them moves, their surface does not tell.
    pub fn mass_matrix_at(&self, values: &[f64]) -> Option<(f64, Matrix3<f64>)> {
        let (mass, inertia) = self.mass_matrix()?;
        let stretch = self.deformation.as_ref().and_then(Deformation::sphere);
        let stretch = stretch.map_or(1.0, |own| own.sphere_radius(values) / own.radius);
        Some((mass, stretch * stretch * inertia))
    }

    /// Rate of the logarithm of the radius of a sphere that changes its size; zero for all others.
    pub fn growth_rate(&self, values: &[f64], rates: &[f64]) -> f64 {
        let sphere = self.deformation.as_ref().and_then(Deformation::sphere);
        sphere.map_or(0.0, |own| own.growth_rate(values, rates))
    }

    /// The same for bodies in a fluid with inertia, where a density has mass too.
    pub fn mass_matrix_by_density(&self) -> Option<(f64, Matrix3<f64>)> {
        self.matrix_of_mass(match (self.mass, self.density) {
            (0.0, Some(density)) => density * self.shape.volume(),
            (mass, _) => mass,
        })
    }

    fn matrix_of_mass(&self, mass: f64) -> Option<(f64, Matrix3<f64>)> {
        if mass == 0.0 && self.inertia == 0.0 {
            return None;
        }
        let inertia = match self.inertia {
            0.0 => mass * self.shape.inertia_per_mass()?,
            inertia => inertia * Matrix3::identity(),
        };
        Some((mass, inertia))
    }

    /// Kind of body in the articulation: rigid, or a point without rotation.
    pub fn kind(&self) -> BodyKind {
        match self.shape.has_surface() {
            true => BodyKind::Rigid,
            false => BodyKind::Point,
        }
    }

    /// Position of the point on which the weight acts relative to the position of the body, in the
    /// initial configuration; `None` if they are the same.
    pub fn weight_arm(&self) -> Option<Vector3<f64>> {
        let arm = self.shape.centroid();
        (arm.norm() > CENTROID_ROUNDING * self.bounding_radius()).then_some(arm)
    }

    /// Torque of the weight about the position of the body after this rotation from the initial
    /// configuration.
    pub fn weight_torque(&self, rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
        let torque = |arm: Vector3<f64>| (rotation * arm).cross(&self.weight);
        self.weight_arm().map_or_else(Vector3::zeros, torque)
    }
}

/// Distance of a centroid from the position, over the radius of the body, that is rounding.
const CENTROID_ROUNDING: f64 = 1e-9;

/// What to do about bodies whose volume changes in a container.
const VOLUME_REMEDY: &str = "but a container is full of incompressible fluid; let \
    spheres exchange volume (joint = \"exchange\", or the coordinates NAME.volume), or use motion = \
    \"isochoric\" for modes, keep_volume = true for frames";

/// Rate of the volume of all bodies, relative to [the sizes of the rates](volume_rates), that is
/// rounding.
const ROUNDING_FLUX: f64 = 1e-10;

/// What is wrong with rates at which the volume of the bodies changes in a container; `None` if it
/// stays.
pub(crate) fn volume_problem(bodies: &[Body], values: &[f64], rates: &[f64]) -> Option<String> {
    let (excess, size) = volume_rates(bodies, values, rates);
    let stays = excess.abs() <= ROUNDING_FLUX * size;
    (!stays).then(|| {
        format!("the volume of the bodies grows at the rate {excess:.3e}, {VOLUME_REMEDY}")
    })
}

/// Sum of the rates of the volumes of all bodies, and of their sizes.
fn volume_rates(bodies: &[Body], values: &[f64], rates: &[f64]) -> (f64, f64) {
    let mut sums = (0.0, 0.0);
    // Tubes that undulate keep their volume.
    let deformations = bodies.iter().filter_map(|body| body.deformation.as_ref());
    for deformation in deformations {
        for joint in deformation.joints().filter(|joint| rates[*joint] != 0.0) {
            let rate = rates[joint] * deformation.volume_rate(values, joint);
            sums.0 += rate;
            // Modes that keep the volume have the rounding of integrals over their surface, on
            // which points move at about the radius times the rate.
            let is_mode = |of: &SphereDeformation| of.size.is_none_or(|size| size.joint() != joint);
            sums.1 += match deformation.sphere().is_some_and(is_mode) {
                true => 4.0 * PI * deformation.bounding_radius(values).powi(3) * rates[joint].abs(),
                false => rate.abs(),
            };
        }
    }
    sums
}

fn at_rest() -> VectorOscillation {
    VectorOscillation::constant(Vector3::zeros())
}

/// The constraints of a set with the given velocities of its bodies at a time.
///
/// # Errors
/// Those of [`Constraints::with_held_velocity`].
pub(crate) fn with_held_velocities(
    mut constraints: Constraints,
    set: &Articulation,
    bodies: &[Body],
    time: f64,
) -> Result<Constraints, RigidError> {
    for body in set.held_bodies() {
        constraints = constraints.with_held_velocity(body, bodies[body].held_twist(time))?;
    }
    Ok(constraints)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::HelixShape;

    /// The divergence theorem on a fine triangulation: `∫ x dV = ∮ x^2 n / 2 dS`, component-wise.
    #[test]
    fn the_centroid_of_a_helix_is_that_of_the_volume_inside_its_surface() {
        for (turns, pitch) in [(0.6, 1.5), (1.3, -2.0), (2.0, 1.7)] {
            let shape = Shape::Helix(HelixShape {
                radius: 1.0,
                tube_radius: 0.3,
                pitch,
                turns,
                orientation: Vector3::new(0.4, -1.0, 0.7),
            });
            let surface = shape.surface(&nalgebra::Isometry3::identity(), 1.0);
            let surface = surface.expect("a helix has a surface");
            let mesh = surface.triangulation().expect("a triangulation");
            let corners = |triangle: &[u32; 3]| triangle.map(|v| mesh.points[v as usize]);
            let mut triangles: Vec<[Vector3<f64>; 3]> =
                mesh.triangles.iter().map(corners).collect();
            for _ in 0..4 {
                let quarters = |[a, b, c]: [Vector3<f64>; 3]| {
                    let middle = |x: Vector3<f64>, y| surface.closest_point((x + y) * 0.5);
                    let [d, e, f] = [middle(a, b), middle(b, c), middle(c, a)];
                    [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
                };
                triangles = triangles.into_iter().flat_map(quarters).collect();
            }
            let (mut volume, mut moment) = (0.0, Vector3::zeros());
            for [a, b, c] in triangles {
                // The tetrahedron of the triangle and the origin, with its sign.
                let part = a.dot(&b.cross(&c)) / 6.0;
                volume += part;
                moment += (a + b + c) * (part / 4.0);
            }
            let error = (moment / volume - shape.centroid()).norm();
            // 128 facets around the tube lose (2π / 128)^2 / 6 of its volume, 4e-4, everywhere.
            assert!((volume / shape.volume() - 1.0).abs() < 1e-3);
            assert!(error < 1e-4, "{turns} turns: {error:e}");
        }
    }

    #[test]
    fn shapes_with_a_centre_of_symmetry_have_no_arm() {
        let body = Shape::sphere(2.0);
        assert_eq!(body.centroid(), Vector3::zeros());
    }
}
