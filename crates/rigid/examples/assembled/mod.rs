// Stands for another finite-element code: spheres in a ball of fluid, and the matrices around them.

use fem::{StokesMatrices, TaylorHood};
use mesher::mesh::{NamedSurface, TetMesh};
use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};
use rigid::nalgebra::Vector3;
use rigid::{FluidMatrices, NodeRole, SurfaceBody};

/// The input that `rigid` needs from a mesh.
pub struct Assembled {
    pub matrices: FluidMatrices,
    pub points: Vec<Vector3<f64>>,
    pub roles: Vec<NodeRole>,
    pub bodies: Vec<SurfaceBody>,
}

/// Unit spheres, meshed with elements of a given size, in a ball about the origin.
pub fn spheres_in_ball(
    centres: &[Vector3<f64>],
    size: f64,
    radius: f64,
) -> Result<Assembled, Box<dyn std::error::Error>> {
    let names: Vec<String> = (0..centres.len()).map(|i| format!("sphere {i}")).collect();
    let sphere = |&centre: &Vector3<f64>| Sphere {
        centre,
        radius: 1.0,
    };
    let spheres: Vec<Sphere> = centres.iter().map(sphere).collect();
    let container = Container::Ball(Sphere {
        centre: Vector3::zeros(),
        radius,
    });
    let meshed: Vec<MeshedBody> = names
        .iter()
        .zip(&spheres)
        .map(|(name, surface)| MeshedBody {
            name,
            surface,
            size,
        })
        .collect();
    let tets = generate(&meshed, &container, &GenerateParams::default())?.mesh;
    let surfaces: Vec<NamedSurface> = meshed
        .iter()
        .map(|body| (body.name, body.surface))
        .chain([(Container::TAG, container.surface())])
        .collect();
    let mesh = TetMesh::curved(tets, &surfaces)?;

    let mut roles = vec![NodeRole::Free; mesh.n_points()];
    for node in mesh.nodes_on(mesh.tag(Container::TAG)?) {
        roles[node as usize] = NodeRole::Fixed;
    }
    let mut bodies = Vec::new();
    for (number, (name, &centre)) in names.iter().zip(centres).enumerate() {
        let tag = mesh.tag(name)?;
        for node in mesh.nodes_on(tag) {
            roles[node as usize] = NodeRole::Body(number as u32);
        }
        let volume = fem::surface_measures(&mesh, tag)?.volume;
        bodies.push(SurfaceBody { centre, volume });
    }
    let StokesMatrices {
        stiffness,
        divergence,
        pressure_mass,
        interpolation,
        vertex_stiffness,
    } = TaylorHood::new(&mesh)?.matrices(&mesh)?;
    Ok(Assembled {
        matrices: FluidMatrices {
            stiffness,
            divergence,
            pressure_mass,
            interpolation,
            vertex_stiffness,
        },
        points: mesh.points().to_vec(),
        roles,
        bodies,
    })
}
