//! Integration tests of the crate, in one binary.

mod examples;
mod hostile;
mod methods;
mod motion;

use mesh::{NamedSurface, TetMesh, Vec3};
use mesher::{Container, GenerateParams, MeshedBody, Sphere};

/// A curved mesh around bodies with edges of this size in a ball.
fn mesh_around(bodies: &[NamedSurface<'_>], radius: f64, size: f64) -> TetMesh {
    let container = Container::Ball(Sphere::new(Vec3::zeros(), radius));
    let meshed: Vec<MeshedBody> = (bodies.iter())
        .map(|&(name, surface)| MeshedBody::new(name, surface, size))
        .collect();
    let tets = mesher::generate(&meshed, &container, &GenerateParams::default());
    let wall: NamedSurface = (Container::TAG, container.surface());
    TetMesh::curved(tets.unwrap().mesh, &[bodies, &[wall]].concat()).unwrap()
}
