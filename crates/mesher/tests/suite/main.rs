//! All tests of the public interface.

use mesh::{LinearTets, NamedSurface, TetMesh, Vec3};
use mesher::{Container, GenerateError, GenerateParams, MeshedBody, Sphere, generate};

/// Asserts that a result is an error that matches a pattern.
macro_rules! assert_refused {
    ($result:expr, $error:pat) => {
        match $result {
            Err($error) => {}
            other => panic!("{other:?}"),
        }
    };
}

#[path = "../../../../fuzz/src/corpus.rs"]
mod corpus;
mod examples;
mod generation;
mod hostile;
#[path = "../../../../fuzz/src/surface.rs"]
mod surface_target;
mod symmetry;
mod triangulated;

#[test]
fn the_corpus_of_surfaces_is_read_or_refused() {
    corpus::replay("surface", surface_target::read);
}

/// A ball about the origin.
fn ball(radius: f64) -> Container {
    Container::Ball(Sphere::new(Vec3::zeros(), radius))
}

/// The generated tets, and the mesh with its boundary on the true surfaces.
fn curved(
    bodies: &[MeshedBody<'_>],
    container: &Container,
    params: &GenerateParams,
) -> Result<(LinearTets, TetMesh), GenerateError> {
    let tets = generate(bodies, container, params)?.mesh;
    let mesh = TetMesh::curved(tets.clone(), &surfaces(bodies, container))?;
    Ok((tets, mesh))
}

/// The surfaces of bodies and container by their tags.
fn surfaces<'a>(bodies: &[MeshedBody<'a>], container: &'a Container) -> Vec<NamedSurface<'a>> {
    let of_bodies = bodies.iter().map(|body| (body.name, body.surface));
    of_bodies
        .chain([(Container::TAG, container.surface())])
        .collect()
}

/// What `run` returns on a number of threads.
fn on_threads<T: Send>(threads: usize, run: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("threads").install(run)
}

/// `V - E + F` of the faces with a tag; every edge of a closed surface has two faces.
fn euler_characteristic(mesh: &LinearTets, tag: u16) -> i64 {
    let faces: Vec<[u32; 3]> = (mesh.faces.iter())
        .filter(|face| face.1 == tag)
        .map(|face| face.0)
        .collect();
    let mut vertices: Vec<u32> = faces.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    assert_eq!(faces.len() % 2, 0);
    vertices.len() as i64 - faces.len() as i64 / 2
}
