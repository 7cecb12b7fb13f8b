//! Each formulation on three linked spheres in a ball, on two meshes: building the system, one
//! product with it, one application of the preconditioner, the whole solve.

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use fem::TaylorHood;
use linalg::{Csr, Csr3, KrylovParams, LinearOperator, Preconditioner, fgmres};
use mesh::{
    Container, GenerateParams, MeshedBody, NamedSurface, Sphere, Surface, TetMesh, generate,
};
use nalgebra::Vector3;
use rigid::{
    Arms, Articulation, BodyKind, Constrained, Constraints, DirectRows, Drive, Eliminated,
    ExternalLoad, FluidMatrices, FluidNodes, Formulation, Lagrange, Link, NodeRole, RigidFluid,
    SurfaceBody,
};

const NAMES: [&str; 3] = ["left", "centre", "right"];
const CENTRES: [f64; 3] = [-10.0, 0.0, 10.0];
const FORMULATIONS: [&dyn Formulation; 3] = [&Eliminated, &Lagrange, &DirectRows];

/// Matrices over all nodes around three spheres, and their links; the left arm closes.
struct Scene {
    mesh: TetMesh,
    stiffness: Csr,
    divergence: Csr3,
    pressure_mass: Csr,
    interpolation: Csr,
    vertex_stiffness: Csr,
    roles: Vec<NodeRole>,
    bodies: Vec<SurfaceBody>,
    set: Articulation,
    constraints: Constraints,
}

impl Scene {
    fn new(size: f64) -> Self {
        let spheres = CENTRES.map(|x| Sphere {
            centre: Vector3::new(x, 0.0, 0.0),
            radius: 1.0,
        });
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
        let mesh = TetMesh::curved(tets, &surfaces).expect("a generated mesh");
        let mut roles = vec![NodeRole::Free; mesh.n_points()];
        let mut mark = |name: &str, role: NodeRole| {
            let tag = mesh.tag(name).expect("a tag of the mesh");
            for node in mesh.nodes_on(tag) {
                roles[node as usize] = role;
            }
            tag
        };
        mark(Container::TAG, NodeRole::Fixed);
        let tags: Vec<_> = (0..3)
            .map(|body| mark(NAMES[body], NodeRole::Body(body as u32)))
            .collect();
        let bodies = tags
            .into_iter()
            .zip(&spheres)
            .map(|(tag, sphere)| SurfaceBody {
                centre: sphere.centre,
                volume: fem::surface_measures(&mesh, tag).expect("a surface").volume,
            })
            .collect();
        let link = |body: usize| Link {
            name: NAMES[body].into(),
            body,
            to: 1,
        };
        let set = Articulation::new(
            &[BodyKind::Rigid; 3],
            vec![link(0), link(2)],
            Arms::Clamped,
            &spheres.map(|sphere| sphere.centre),
        )
        .expect("a chain");
        let constraints = set
            .constraints(&set.initial_state(), set.initial_lengths(), &[-1.0, 0.0])
            .expect("a chain has no loop");
        let space = TaylorHood::new(&mesh).expect("a mesh of moderate size");
        Self {
            stiffness: space.stiffness(&mesh).expect("no degenerate cell"),
            divergence: space.divergence(&mesh).expect("no degenerate cell"),
            pressure_mass: space.pressure_mass(&mesh).expect("no degenerate cell"),
            interpolation: space.vertex_interpolation(&mesh).expect("a matching mesh"),
            vertex_stiffness: space.vertex_stiffness(&mesh).expect("no degenerate cell"),
            roles,
            bodies,
            set,
            constraints,
            mesh,
        }
    }

    fn fluid(&self) -> RigidFluid {
        let matrices = FluidMatrices {
            stiffness: self.stiffness.clone(),
            divergence: self.divergence.clone(),
            pressure_mass: self.pressure_mass.clone(),
            interpolation: self.interpolation.clone(),
            vertex_stiffness: self.vertex_stiffness.clone(),
        };
        RigidFluid::new(
            matrices,
            FluidNodes::new(self.mesh.points(), &self.roles),
            &self.bodies,
        )
        .expect("matrices of one mesh")
    }

    fn constrain(&self, formulation: &dyn Formulation, fluid: RigidFluid) -> Constrained {
        let drive = Drive {
            set: &self.set,
            constraints: &self.constraints,
            loads: &[ExternalLoad::default(); 3],
        };
        formulation
            .constrain(fluid, &drive)
            .expect("consistent links")
    }
}

fn formulations(criterion: &mut Criterion) {
    for size in [0.5, 0.25] {
        let scene = Scene::new(size);
        let fluid = scene.fluid();
        let dofs = scene.constrain(&Eliminated, fluid.clone()).rhs.len();
        let mut group = criterion.benchmark_group(format!("three_spheres_{dofs}"));
        group
            .sample_size(10)
            .throughput(Throughput::Elements(dofs as u64));
        group.bench_function("fluid block", |b| b.iter(|| scene.fluid()));
        for formulation in FORMULATIONS {
            let name = formulation.name();
            group.bench_function(format!("{name}/constrain"), |b| {
                b.iter_batched(
                    || fluid.clone(),
                    |fluid| scene.constrain(formulation, fluid),
                    BatchSize::LargeInput,
                )
            });
            let system = scene.constrain(formulation, fluid.clone());
            let mut y = vec![0.0; dofs.max(system.rhs.len())];
            let y = &mut y[..system.rhs.len()];
            group.bench_function(format!("{name}/product"), |b| {
                b.iter(|| system.system.apply(&system.rhs, y))
            });
            let mut block = system.preconditioner().expect("an elliptic block");
            group.bench_function(format!("{name}/preconditioner"), |b| {
                b.iter(|| block.apply(&system.rhs, y))
            });
            group.bench_function(format!("{name}/set-up and solve"), |b| {
                b.iter(|| {
                    let mut solution = vec![0.0; system.rhs.len()];
                    fgmres(
                        &system.system,
                        &mut system.preconditioner().expect("an elliptic block"),
                        &system.rhs,
                        &mut solution,
                        &KrylovParams::default(),
                    )
                    .expect("convergence")
                })
            });
        }
        group.finish();
    }
}

criterion_group!(benches, formulations);
criterion_main!(benches);
