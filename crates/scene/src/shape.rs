//! Shapes of bodies.

use mesh::Surface;
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

use crate::error::SceneError;
use crate::keys::BodyFile;
use crate::shapes::{self, Geometry, ShapeFile, ShapeKeys};
use crate::words::ShapeKind;

/// Defines [`Shape`] from the list of shapes, so that a shape in the list has all of the geometry.
macro_rules! shape {
    ($( $(#[doc = $meaning:literal])+ $kind:ident $name:ident, )+) => {
        /// Shape of a body.
        ///
        /// Bodies of revolution have an `axis`: its direction in the initial configuration, a unit
        /// vector. Other shapes have an `orientation`: the rotation vector (radians) that turns
        /// their own coordinates into the initial configuration.
        #[derive(Clone, Debug, PartialEq)]
        pub enum Shape {
            $( $(#[doc = $meaning])+ $kind(shapes::$name), )+
        }

        $(impl From<shapes::$name> for Shape {
            fn from(shape: shapes::$name) -> Self {
                Self::$kind(shape)
            }
        })+

        impl Shape {
            /// Kind of the shape, as in the scene file.
            pub fn kind(&self) -> ShapeKind {
                match self {
                    $( Self::$kind(_) => ShapeKind::$kind, )+
                }
            }

            fn geometry(&self) -> &dyn Geometry {
                match self {
                    $( Self::$kind(shape) => shape, )+
                }
            }

            /// Reads a shape of the kind that the keys name.
            pub(crate) fn read(keys: &mut ShapeKeys) -> Result<Self, SceneError> {
                let shape = match keys.file.shape {
                    $( ShapeKind::$kind => shapes::$name::read(keys).map(Self::$kind), )+
                }?;
                match shape.geometry().problem() {
                    Some((key, bound)) => {
                        Err(keys.checks.bad_value(&keys.path(key), format!("must be {bound}")))
                    }
                    None => Ok(shape),
                }
            }
        }

        /// The keys of `[[bodies]]` that belong to the shapes.
        pub(crate) fn shape_keys() -> Vec<(ShapeKind, &'static [&'static str])> {
            vec![$( (ShapeKind::$kind, shapes::$name::keys()) ),+]
        }
    };
}

shapes::list!(shape);

impl Shape {
    /// A sphere.
    pub fn sphere(radius: f64) -> Self {
        Self::Sphere(shapes::SphereShape { radius })
    }

    /// Radius of a sphere; `None` for other shapes.
    pub fn sphere_radius(&self) -> Option<f64> {
        match self {
            Self::Sphere(sphere) => Some(sphere.radius),
            _ => None,
        }
    }

    /// Whether the body has a surface: points have none.
    pub fn has_surface(&self) -> bool {
        !matches!(self, Self::Point(_))
    }

    /// Whether the shape is a part of the boundary of the domain's mesh, which is used as it is.
    pub fn is_mesh_part(&self) -> bool {
        matches!(self, Self::File(_))
    }

    /// Whether rotations do not change the shape.
    pub fn is_isotropic(&self) -> bool {
        self.geometry().is_isotropic()
    }

    /// Axis of revolution in the initial configuration; `None` for spheres, points and shapes
    /// without such an axis.
    pub fn axis(&self) -> Option<Vector3<f64>> {
        self.geometry().axis()
    }

    /// Rotation of the shape's own coordinates into the initial configuration.
    ///
    /// In their own coordinates, bodies of revolution have the x axis as axis.
    pub fn orientation(&self) -> UnitQuaternion<f64> {
        self.geometry().orientation()
    }

    /// Moments of inertia about the centre of a homogeneous body of unit mass, in the axes of the
    /// initial configuration; `None` for points and for shapes without a formula.
    ///
    /// ```
    /// let sphere = scene::Shape::sphere(2.0);
    /// assert!((sphere.inertia_per_mass().unwrap()[(1, 1)] - 0.4 * 4.0).abs() < 1e-15);
    /// ```
    pub fn inertia_per_mass(&self) -> Option<Matrix3<f64>> {
        let own = self.geometry().moments_per_mass()?;
        let rotation = self.orientation().to_rotation_matrix();
        Some(rotation * Matrix3::from_diagonal(&own) * rotation.inverse())
    }

    /// Radius of the smallest ball about the centre that contains the body; zero for points.
    pub fn bounding_radius(&self) -> f64 {
        self.geometry().bounding_radius()
    }

    /// Radius on which element sizes are based: that of the tube or cylinder of long bodies, and of
    /// the outline of flat ones, but at most 2.5 of half their thickness. Zero for points.
    pub fn size_radius(&self) -> f64 {
        self.geometry().size_radius()
    }

    /// Points in the middle of a tube, torus or helix with the radius there, in the initial
    /// configuration relative to the position; they are closer to each other than a radius. Empty
    /// for other shapes.
    pub fn centreline(&self) -> Vec<(Vector3<f64>, f64)> {
        self.geometry().centreline()
    }

    /// Volume; zero for points.
    pub fn volume(&self) -> f64 {
        self.geometry().volume()
    }

    /// Centre of volume in the initial configuration, relative to the position of the body.
    ///
    /// Zero for shapes with a centre of symmetry, and for points.
    ///
    /// ```
    /// # use scene::{HelixShape, Shape};
    /// # use nalgebra::Vector3;
    /// let helix = Shape::Helix(HelixShape {
    ///     radius: 1.0,
    ///     tube_radius: 1e-4,
    ///     pitch: 0.0,
    ///     turns: 0.5,
    ///     orientation: Vector3::zeros(),
    /// });
    /// // half a thin ring has its centroid 2 R / π from the centre
    /// assert!((helix.centroid() - Vector3::y() * std::f64::consts::FRAC_2_PI).norm() < 1e-4);
    /// ```
    pub fn centroid(&self) -> Vector3<f64> {
        self.orientation() * self.geometry().centroid()
    }

    /// Mean of the extents along three axes, halved: a radius for rough models.
    pub fn mean_radius(&self) -> f64 {
        let unit = UnitQuaternion::identity();
        // Opposite directions for a helix, which is not symmetric.
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| self.orientation() * axis);
        let extents = axes.iter().flat_map(|axis| [*axis, -*axis]);
        extents
            .map(|n| self.support_distance(&unit, &n))
            .sum::<f64>()
            / 6.0
    }

    /// The lengths of the shape with their keys.
    pub fn lengths(&self) -> Vec<(&'static str, f64)> {
        self.geometry().lengths()
    }

    /// Support distance `max n · (x - c)` over the points `x` of the body with centre `c`.
    ///
    /// `direction` is the unit vector `n`; `rotation` is relative to the initial configuration.
    pub fn support_distance(
        &self,
        rotation: &UnitQuaternion<f64>,
        direction: &Vector3<f64>,
    ) -> f64 {
        let short = self.geometry().support_distance(rotation, direction);
        short.unwrap_or_else(|| direction.dot(&self.support_point(rotation, direction)))
    }

    /// A point of the body, relative to its centre, that is farthest in a direction.
    ///
    /// `direction` is a unit vector; `rotation` is relative to the initial configuration.
    pub fn support_point(
        &self,
        rotation: &UnitQuaternion<f64>,
        direction: &Vector3<f64>,
    ) -> Vector3<f64> {
        let turn = rotation * self.orientation();
        let own = turn.inverse_transform_vector(direction);
        turn * self.geometry().support_point(&own)
    }

    /// [`Shape::support_point`] at a rotation as a function, for many directions.
    pub(crate) fn support(
        &self,
        rotation: &UnitQuaternion<f64>,
    ) -> impl Fn(&Vector3<f64>) -> Vector3<f64> + '_ {
        let turn = rotation * self.orientation();
        let own = self.geometry().support();
        move |direction| turn * own(&turn.inverse_transform_vector(direction))
    }

    /// Largest support distance over all directions perpendicular to `direction`, a unit vector.
    ///
    /// An upper bound for a helix: that of the cylinder around it. `rotation` is relative to the
    /// initial configuration.
    pub fn transverse_support_distance(
        &self,
        rotation: &UnitQuaternion<f64>,
        direction: &Vector3<f64>,
    ) -> f64 {
        let turn = rotation * self.orientation();
        let own = turn.inverse_transform_vector(direction);
        self.geometry().transverse_support_distance(&own)
    }

    /// The surface of a body at a pose, as the mesh generator knows it; `None` for a point.
    ///
    /// Lengths are divided by `unit`; the pose is in these scaled units and relative to the initial
    /// configuration.
    pub fn surface(&self, pose: &Isometry3<f64>, unit: f64) -> Option<Box<dyn Surface>> {
        let pose = Isometry3::from_parts(pose.translation, pose.rotation * self.orientation());
        self.geometry().surface(pose, unit)
    }

    /// The keys of a body that describe the shape.
    pub(crate) fn to_keys(&self) -> BodyFile {
        let mut file = BodyFile {
            shape: self.kind(),
            ..BodyFile::default()
        };
        self.geometry().write(&mut file);
        file
    }
}
