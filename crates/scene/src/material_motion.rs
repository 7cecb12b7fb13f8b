//! Deformations of a program: material points as functions of amplitudes.

use std::fmt;

use nalgebra::Vector3;

/// A shape coordinate of a [`MaterialMotion`].
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeCoordinate {
    /// Name; the gait names it `BODY.NAME`.
    pub name: String,
    /// Value at the start, unless the gait determines it.
    pub start: f64,
    /// Change of the value that leads to the same shape; none if each value has its own.
    pub period: Option<f64>,
}

/// A vertex of the undeformed surface of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialPoint {
    /// Its number in the file of the surface, from zero.
    pub vertex: usize,
    /// Its position relative to that of the body, in the body's own axes and in the units of the
    /// scene.
    pub position: Vector3<f64>,
}

/// A deformation of a program: the positions of material points as functions of amplitudes.
///
/// The vertices of the body's surface, a `shape = "surface"`, are at `X(p, a)` and have the
/// velocities `Σ (∂X/∂a) da/dt` relative to the body, along its own axes. Other points keep their
/// triangle and their barycentric coordinates there. [`SceneBuilder::deformation`] enters it into a
/// scene; gaits, maps, designs and pictures then know its coordinates like joints.
///
/// [`SceneBuilder::deformation`]: crate::SceneBuilder::deformation
///
/// ```
/// use nalgebra::Vector3;
/// use scene::{MaterialMotion, MaterialPoint, ShapeCoordinate};
///
/// /// Shear of a body along its x axis, which keeps the volume.
/// #[derive(Debug)]
/// struct Shear {
///     radius: f64,
/// }
///
/// impl MaterialMotion for Shear {
///     fn coordinates(&self) -> Vec<ShapeCoordinate> {
///         let name = "shear".to_owned();
///         vec![ShapeCoordinate { name, start: 0.0, period: None }]
///     }
///
///     fn position(&self, point: &MaterialPoint, amplitudes: &[f64]) -> Vector3<f64> {
///         let x = point.position;
///         x + amplitudes[0] * x.y * Vector3::x()
///     }
///
///     fn velocity(&self, point: &MaterialPoint, _: &[f64], _: usize) -> Vector3<f64> {
///         point.position.y * Vector3::x()
///     }
///
///     fn largest_speed(&self, _: usize) -> f64 {
///         self.radius
///     }
/// }
///
/// let (shear, point) = (Shear { radius: 1.0 }, MaterialPoint {
///     vertex: 0,
///     position: Vector3::new(0.0, 1.0, 0.0),
/// });
/// assert_eq!(shear.position(&point, &[0.3]), Vector3::new(0.3, 1.0, 0.0));
/// ```
pub trait MaterialMotion: fmt::Debug + Send + Sync {
    /// The shape coordinates, in the order of the amplitudes.
    fn coordinates(&self) -> Vec<ShapeCoordinate>;

    /// Position of a material point relative to that of the body.
    fn position(&self, point: &MaterialPoint, amplitudes: &[f64]) -> Vector3<f64>;

    /// Derivative of the position with respect to one of the amplitudes.
    fn velocity(
        &self,
        point: &MaterialPoint,
        amplitudes: &[f64],
        coordinate: usize,
    ) -> Vector3<f64>;

    /// Upper bound of the size of [`velocity`](Self::velocity) at all amplitudes that have no
    /// [`problem`](Self::problem), for the check that bodies do not touch on the way.
    fn largest_speed(&self, coordinate: usize) -> f64;

    /// What is wrong with these amplitudes, as in "is beyond the last frame"; `None` by default.
    ///
    /// Folded surfaces, and those that pass through themselves, are found without it.
    fn problem(&self, _amplitudes: &[f64]) -> Option<String> {
        None
    }

    /// Whether the volume `V` of the undeformed surface is kept, as in a closed container: material
    /// points are then at `(V / V(X))^(1/3) X`, with the volume `V(X)` inside the moved triangles.
    ///
    /// By default it is not.
    fn keeps_volume(&self) -> bool {
        false
    }
}
