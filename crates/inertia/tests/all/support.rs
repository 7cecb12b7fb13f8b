//! A sphere of radius 1 in a concentric ball of fluid.

use inertia::{Bodies, BodyMass};
use mesh::TetMesh;
use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};
use nalgebra::Vector3;
use rigid::{Arms, Articulation, BodyKind};

pub type Vec3 = Vector3<f64>;

/// Drag of a sphere in unbounded Stokes flow, over its speed.
pub const STOKES: f64 = 6.0 * std::f64::consts::PI;

/// The quarter of the fluid with positive x and y.
pub const QUARTER: [bool; 3] = [true, true, false];

/// Elements on the sphere have the size `size`; the mesh covers the part that the planes leave.
pub fn sphere_in_ball(size: f64, radius: f64, symmetry_planes: [bool; 3]) -> TetMesh {
    sphere_at(Vec3::zeros(), size, radius, symmetry_planes)
}

/// As [`sphere_in_ball`], with the sphere at `centre`.
pub fn sphere_at(centre: Vec3, size: f64, radius: f64, symmetry_planes: [bool; 3]) -> TetMesh {
    let sphere = Sphere {
        centre,
        radius: 1.0,
    };
    let ball = Sphere {
        centre: Vec3::zeros(),
        radius,
    };
    let body = MeshedBody {
        name: "sphere",
        surface: &sphere,
        size,
    };
    let mut parameters = GenerateParams::default();
    parameters.symmetry_planes = symmetry_planes;
    let tets = generate(&[body], &Container::Ball(ball), &parameters).unwrap();
    TetMesh::curved(tets.mesh, &[("sphere", &sphere), (Container::TAG, &ball)]).unwrap()
}

/// One free sphere at `centre`.
pub fn free_sphere(centre: Vec3) -> Articulation {
    Articulation::new(&[BodyKind::Rigid], vec![], Arms::Clamped, &[centre]).unwrap()
}

/// A sphere of this density with its surface and wall.
pub fn bodies(set: &Articulation, density: f64) -> Bodies<'_> {
    Bodies {
        set,
        masses: vec![BodyMass::sphere(1.0, density)],
        surfaces: vec!["sphere".into()],
        walls: vec![Container::TAG.into()],
    }
}
