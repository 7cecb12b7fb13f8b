//! Generates a mesh around three spheres in a ball, and prints its quality.

use mesh::NamedSurface;
use mesh::{TetMesh, Vec3};
use mesher::{Container, GenerateError, GenerateParams, MeshedBody};
use mesher::{Sphere, generate};

pub(crate) fn main() -> Result<(), GenerateError> {
    let names = ["left", "middle", "right"];
    let spheres = [-4.0, 0.0, 3.0].map(|x| Sphere {
        centre: Vec3::new(x, 0.0, 0.0),
        radius: 1.0,
    });
    let container = Container::Ball(Sphere::new(Vec3::zeros(), 20.0));
    let bodies: Vec<MeshedBody> = names
        .into_iter()
        .zip(&spheres)
        .map(|(name, surface)| MeshedBody {
            name,
            surface,
            size: 0.5,
        })
        .collect();
    let params = GenerateParams::default().with_growth(0.4);
    let generated = generate(&bodies, &container, &params)?;

    // The mesh follows the true surfaces: midside nodes move onto them.
    let mut surfaces: Vec<NamedSurface> = bodies.iter().map(|b| (b.name, b.surface)).collect();
    surfaces.push((Container::TAG, container.surface()));
    let mesh = TetMesh::curved(generated.mesh, &surfaces)?;

    let quality = mesh.quality();
    let volume = 4.0 / 3.0 * std::f64::consts::PI * (20f64.powi(3) - 3.0);
    let error = mesh.volume() / volume - 1.0;
    println!("cells                {}", mesh.n_cells());
    println!("vertices             {}", mesh.n_vertices());
    println!("smallest angle       {:.1} degrees", quality.min_dihedral);
    println!("largest angle        {:.1} degrees", quality.max_dihedral);
    println!("mean quality         {:.3}", quality.mean_quality);
    println!("smallest Jacobian    {:.3}", quality.min_jacobian);
    println!("error of the volume  {:.1e} %", 100.0 * error);

    assert!(quality.min_dihedral > 15.0 && quality.mean_quality > 0.8);
    assert!(error.abs() < 1e-3);
    Ok(())
}
