//! Time of one harmonic extension of a sphere's translation, assembly and set-up included.

use ale::{Harmonic, MeshMotion, MovingMesh, Stiffening};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use fem::TaylorHood;
use mesh::{TetMesh, Vec3};
use mesher::{Container, GenerateParams, MeshedBody, Sphere};

/// The fluid between a unit sphere and a ball of radius 10.
fn mesh_around_sphere(size: f64) -> TetMesh {
    let sphere = Sphere::new(Vec3::zeros(), 1.0);
    let container = Container::Ball(Sphere::new(Vec3::zeros(), 10.0));
    let body = MeshedBody::new("sphere", &sphere, size);
    let tets = mesher::generate(&[body], &container, &GenerateParams::default())
        .expect("valid bodies")
        .mesh;
    let surfaces: [(&str, &dyn mesh::Surface); 2] =
        [("sphere", &sphere), (Container::TAG, container.surface())];
    TetMesh::curved(tets, &surfaces).expect("valid surfaces")
}

fn harmonic_extension(c: &mut Criterion) {
    let mut group = c.benchmark_group("harmonic_extension");
    group.sample_size(10);
    for size in [0.4, 0.2] {
        let mesh = mesh_around_sphere(size);
        let space = TaylorHood::new(&mesh).expect("valid mesh");
        let vertex_count = mesh.n_vertices();
        let mut prescribed = vec![false; vertex_count];
        for facet in mesh.facets() {
            for &vertex in &facet.nodes[..3] {
                prescribed[vertex as usize] = true;
            }
        }
        let mut displacement = vec![Vec3::zeros(); vertex_count];
        let tag = mesh.tag("sphere").expect("tag of the sphere");
        for node in mesh.nodes_on(tag) {
            if (node as usize) < vertex_count {
                displacement[node as usize] = Vec3::x();
            }
        }
        let moving = MovingMesh {
            mesh: &mesh,
            space: &space,
            prescribed: &prescribed,
        };
        let mut fields = [displacement];
        group.throughput(Throughput::Elements(vertex_count as u64));
        group.bench_function(BenchmarkId::from_parameter(vertex_count), |b| {
            b.iter(|| Harmonic(Stiffening::KanchiMasud).extend(&moving, &mut fields))
        });
    }
    group.finish();
}

criterion_group!(benches, harmonic_extension);
criterion_main!(benches);
