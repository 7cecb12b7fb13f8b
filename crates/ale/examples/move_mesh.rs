//! A sphere moves along the axis of a ball, and the mesh of the fluid around it follows.
//!
//! ```text
//! cargo run -p microswim-ale --example move_mesh
//! ```

use std::error::Error;

use ale::{Harmonic, MovingBody, ReferenceMap, Stiffening};
use mesh::{TetMesh, Vec3};
use mesher::{Container, GenerateParams, MeshedBody, Sphere};
use nalgebra::Isometry3;

/// Prints the quality of the mesh while the sphere moves from the centre towards the wall.
pub fn main() -> Result<(), Box<dyn Error>> {
    let sphere = Sphere::new(Vec3::zeros(), 1.0);
    let container = Container::Ball(Sphere::new(Vec3::zeros(), 8.0));
    let body = MeshedBody::new("sphere", &sphere, 0.6);
    let tets = mesher::generate(&[body], &container, &GenerateParams::default())?.mesh;
    let mesh = TetMesh::curved(
        tets,
        &[("sphere", &sphere), (Container::TAG, container.surface())],
    )?;

    let moving = MovingBody {
        tag: "sphere".to_owned(),
        centre: sphere.centre,
        rotates: false,
    };
    let map = ReferenceMap::new(mesh, &[moving], &Harmonic(Stiffening::KanchiMasud))?;

    println!("distance  smallest quality  smallest Jacobian ratio");
    for distance in [0.0, 1.0, 2.0, 3.0, 4.0] {
        let moved = map.moved(&[Isometry3::translation(distance, 0.0, 0.0)])?;
        let quality = moved.quality();
        println!(
            "{distance:<8}  {:<16.3}  {:.3}",
            quality.min_quality, quality.min_jacobian
        );
        assert!(quality.min_quality > 0.0 && quality.min_jacobian > 0.0);
        // the sphere and the container keep their volumes, so the fluid does too
        let volume = map.reference().volume();
        assert!((moved.volume() / volume - 1.0).abs() < 1e-11);
    }
    Ok(())
}
