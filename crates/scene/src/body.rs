//! A body of a scene.

use nalgebra::{Matrix3, Vector3};
use rigid::BodyKind;

use crate::flow::Slip;
use crate::shape::Shape;

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
    /// External force without the weight.
    pub force: Vector3<f64>,
    /// Weight minus buoyancy, which acts on the centre of volume ([`Body::weight_arm`]): zero
    /// without a density or without gravity.
    pub weight: Vector3<f64>,
    /// External torque about the centre.
    pub torque: Vector3<f64>,
    /// Whether the body is an obstacle at rest.
    pub fixed: bool,
    /// Density, for the weight; `None` if the body has the density of the fluid.
    pub density: Option<f64>,
    /// Tangential velocity of the surface.
    pub slip: Option<Slip>,
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

    /// Radius of the smallest ball about the centre that contains the body; zero for points.
    pub fn bounding_radius(&self) -> f64 {
        self.shape.bounding_radius()
    }

    /// Mass and moments of inertia about the centre in the axes of the scene at the start; `None`
    /// for bodies without inertia.
    ///
    /// A moment of inertia that is not given is that of a homogeneous body
    /// ([`Shape::inertia_per_mass`]).
    pub fn mass_matrix(&self) -> Option<(f64, Matrix3<f64>)> {
        if self.mass == 0.0 && self.inertia == 0.0 {
            return None;
        }
        let inertia = match self.inertia {
            0.0 => self.mass * self.shape.inertia_per_mass()?,
            inertia => inertia * Matrix3::identity(),
        };
        Some((self.mass, inertia))
    }

    /// Kind of body in the articulation: rigid, or a point without rotation.
    pub fn kind(&self) -> BodyKind {
        match self.shape {
            Shape::Point => BodyKind::Point,
            _ => BodyKind::Rigid,
        }
    }
}
