//! Each formulation on three linked spheres in a ball, on two meshes: assembly of the constrained
//! system, one product with it, one application of the preconditioner, the whole solve.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use linalg::{LinearOperator, Preconditioner};
use mesh::{NamedSurface, Surface, TetMesh};
use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};
use nalgebra::Vector3;
use rigid::{
    Arms, Articulation, BodyKind, DirectRows, Drive, Eliminated, ExternalLoad, Formulation, Joint,
    Lagrange,
};
use stokes::{Options, Problem};

const NAMES: [&str; 3] = ["left", "centre", "right"];
const FORMULATIONS: [&'static dyn Formulation; 3] = [&Eliminated, &Lagrange, &DirectRows];

fn spheres() -> [Sphere; 3] {
    [-10.0, 0.0, 10.0].map(|x| Sphere {
        centre: Vector3::new(x, 0.0, 0.0),
        radius: 1.0,
    })
}

/// Mesh of the fluid around the spheres, with elements of the given size on them.
fn ball_mesh(size: f64) -> TetMesh {
    let spheres = spheres();
    let container = Container::Ball(Sphere {
        centre: Vector3::zeros(),
        radius: 40.0,
    });
    let bodies: Vec<MeshedBody<'_>> = NAMES
        .iter()
        .zip(&spheres)
        .map(|(name, surface)| MeshedBody {
            name,
            surface,
            size,
        })
        .collect();
    let tets = generate(&bodies, &container, &GenerateParams::default())
        .expect("three spheres far apart")
        .mesh;
    let surfaces: Vec<NamedSurface> = NAMES
        .iter()
        .zip(&spheres)
        .map(|(name, sphere)| (*name, sphere as &dyn Surface))
        .chain([(Container::TAG, container.surface())])
        .collect();
    TetMesh::curved(tets, &surfaces).expect("a generated mesh")
}

fn formulations(criterion: &mut Criterion) {
    let centres = spheres().map(|sphere| sphere.centre);
    let joint = |body: usize| Joint::slide(NAMES[body], body, 1);
    let set = Articulation::new(
        &[BodyKind::Rigid; 3],
        vec![joint(0), joint(2)],
        Arms::Clamped,
        &centres,
    )
    .expect("a chain");
    // The left arm becomes shorter.
    let drive = Drive {
        set: &set,
        constraints: &set
            .constraints(&set.initial_state(), set.initial_shape(), &[-1.0, 0.0])
            .expect("a chain has no loop"),
        loads: &[ExternalLoad::default(); 3],
    };
    for size in [0.5, 0.25] {
        let mesh = ball_mesh(size);
        let bodies: Vec<_> = NAMES.into_iter().zip(centres).collect();
        let space = fem::TaylorHood::new(&mesh).expect("a mesh of moderate size");
        let problem = Problem::new(&mesh, &bodies, &[Container::TAG])
            .expect("tags of the mesh")
            .with_space(&space);
        let assemble = |formulation| {
            let system = problem.assemble(&drive, formulation);
            system.expect("consistent links")
        };
        let dofs = assemble(&Eliminated).rhs.len();
        let mut group = criterion.benchmark_group(format!("three_spheres_{dofs}"));
        group
            .sample_size(10)
            .throughput(Throughput::Elements(dofs as u64));
        for formulation in FORMULATIONS {
            let name = formulation.name();
            group.bench_function(format!("{name}/constrained system"), |b| {
                b.iter(|| assemble(formulation))
            });
            let system = assemble(formulation);
            let mut y = vec![0.0; system.rhs.len()];
            group.bench_function(format!("{name}/product"), |b| {
                b.iter(|| system.system.apply(&system.rhs, &mut y))
            });
            let mut block = system.preconditioner().expect("an elliptic block");
            group.bench_function(format!("{name}/preconditioner"), |b| {
                b.iter(|| block.apply(&system.rhs, &mut y))
            });
            let options = Options::default().with_formulation(formulation);
            group.bench_function(format!("{name}/whole solve"), |b| {
                b.iter(|| problem.solve(&drive, &options).expect("convergence"))
            });
        }
        group.finish();
    }
}

criterion_group!(benches, formulations);
criterion_main!(benches);
