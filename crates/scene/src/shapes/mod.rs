//! The shapes of bodies.

mod capsule;
mod disk;
mod ellipsoid;
mod geometry;
mod helix;
mod point;
mod sphere;
mod spheroid;
mod surface;
mod torus;
mod tube;

pub use capsule::CapsuleShape;
pub use disk::DiskShape;
pub use ellipsoid::EllipsoidShape;
pub(crate) use geometry::{Geometry, ShapeFile, ShapeKeys};
pub use helix::HelixShape;
pub use point::PointShape;
pub use sphere::SphereShape;
pub use spheroid::SpheroidShape;
pub use surface::{FileShape, PartShape};
pub use torus::TorusShape;
pub use tube::TubeShape;

/// Passes the list of all shapes to a macro: the word (in kebab case) and the struct of each, with
/// its meaning in `docs/scene.md`.
macro_rules! list {
    ($macro:ident) => {
        $macro! {
            /// A sphere.
            Sphere SphereShape,
            /// An ellipsoid.
            Ellipsoid EllipsoidShape,
            /// A spheroid: prolate if `half_length > radius`, oblate if `half_length < radius`.
            Spheroid SpheroidShape,
            /// A cylinder closed by hemispheres.
            Capsule CapsuleShape,
            /// A disk with a round rim.
            Disk DiskShape,
            /// A torus.
            Torus TorusShape,
            /// A tube with round ends along a helix about the x axis, before the rotation.
            Helix HelixShape,
            /// A tube with round ends along x, before the rotation, with or without a head.
            Tube TubeShape,
            /// A closed surface in a file of its own.
            Surface FileShape,
            /// The part of the boundary of the domain's mesh that `surface` names, as it is.
            File PartShape,
            /// A massless point without a surface, at which joints meet.
            Point PointShape,
        }
    };
}

pub(crate) use list;
