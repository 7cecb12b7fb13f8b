//! Three unit spheres in a ball of radius 40, an unstructured graded mesh with straight edges.

use mesh::{TET_EDGES, TetMesh};
use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};

use super::Stokes;
use super::system::domain::{Domain, Owner};
use super::system::elements::EDGES;

/// The system with edges of length `size` on the spheres.
///
/// With a growth of 0.2 per unit of length and a size of 0.3 it has about 280 000 dofs, as the mesh
/// of Gmsh on which other solvers were measured.
pub fn three_spheres(size: f64, growth: f64) -> Stokes {
    let centres = [-10.0, 10.0, 0.0].map(|x| mesh::Vec3::new(x, 0.0, 0.0));
    let spheres = centres.map(|centre| Sphere {
        centre,
        radius: 1.0,
    });
    let bodies: Vec<MeshedBody> = (["left", "right", "centre"].iter().zip(&spheres))
        .map(|(name, surface)| MeshedBody {
            name,
            surface,
            size,
        })
        .collect();
    let container = Container::Ball(Sphere {
        centre: mesh::Vec3::zeros(),
        radius: 40.0,
    });
    let mut params = GenerateParams::default();
    params.growth = growth;
    let tets = generate(&bodies, &container, &params).expect("a valid scene");
    let mesh = TetMesh::straight(tets.mesh).expect("a valid mesh");
    let mut owners = vec![Owner::Fluid; mesh.n_points()];
    for tag in 0..mesh.tags().len() {
        let owner = match tag {
            0..3 => Owner::Body(tag),
            _ => Owner::Wall,
        };
        for node in mesh.nodes_on(tag as u16) {
            owners[node as usize] = owner;
        }
    }
    // The midside nodes follow the edges in another order there.
    let slot = |edge: &[usize; 2]| TET_EDGES.iter().position(|other| other == edge);
    let middles = EDGES.map(|edge| 4 + slot(&edge).expect("an edge of the tet"));
    let tets = mesh.cells().iter().map(|cell| {
        let local = |k: usize| if k < 4 { k } else { middles[k - 4] };
        std::array::from_fn(|k| cell[local(k)] as usize)
    });
    let domain = Domain {
        volumes: vec![4.0 / 3.0 * std::f64::consts::PI; 3],
        tets: tets.collect(),
        points: mesh.points().to_vec(),
        owners,
        centres: centres.to_vec(),
    };
    domain.assemble(1.0)
}
