//! A sphere in the middle of a ball of fluid.

use mesh::TetMesh;
use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};
use nalgebra::Vector3;

pub const SPHERE: Sphere = Sphere {
    centre: Vector3::new(0.0, 0.0, 0.0),
    radius: 1.0,
};

/// The part of the fluid between the sphere and a concentric ball where the coordinates normal to
/// the planes are positive. Elements on the sphere have the given size.
pub fn sphere_in_ball(size: f64, radius: f64, symmetry_planes: [bool; 3]) -> TetMesh {
    let ball = Sphere { radius, ..SPHERE };
    let body = MeshedBody {
        name: "sphere",
        surface: &SPHERE,
        size,
    };
    let mut parameters = GenerateParams::default();
    parameters.symmetry_planes = symmetry_planes;
    let tets = generate(&[body], &Container::Ball(ball), &parameters).unwrap();
    TetMesh::curved(tets.mesh, &[("sphere", &SPHERE), (Container::TAG, &ball)]).unwrap()
}
