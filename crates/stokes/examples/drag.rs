//! The drag of a sphere at the centre of a ball ten times its size.

use mesh::TetMesh;
use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};
use nalgebra::Vector3;
use stokes::Problem;

/// Prints the drag in units of the drag in unbounded fluid.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let [sphere, ball] = [1.0, 10.0].map(|radius| Sphere {
        centre: Vector3::zeros(),
        radius,
    });
    let container = Container::Ball(ball);
    let body = MeshedBody {
        name: "sphere",
        surface: &sphere,
        size: 0.4,
    };
    let tets = generate(&[body], &container, &GenerateParams::default())?.mesh;
    let mesh = TetMesh::curved(tets, &[("sphere", &sphere), (Container::TAG, &ball)])?;

    let problem = Problem::new(&mesh, &[("sphere", sphere.centre)], &[Container::TAG])?;
    let resistance = problem.resistance(1e-8)?.resistance;
    let ratio = resistance[(0, 0)] / (6.0 * std::f64::consts::PI);
    // Haberman & Sayre 1958; Happel & Brenner 1983
    println!("drag / (6π μ a): {ratio:.6}, exact 1.286196");
    assert!((ratio / 1.286_196_338_5 - 1.0).abs() < 3e-3);
    Ok(())
}
