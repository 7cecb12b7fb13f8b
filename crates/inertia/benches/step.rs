//! A step of unsteady Stokes and of Navier-Stokes flow against one Stokes solution on the same
//! mesh.

use std::hint::black_box;

use ale::{Harmonic, MovingBody, ReferenceMap, Stiffening};
use criterion::{Criterion, criterion_group, criterion_main};
use inertia::{Bodies, BodyMass, Convection, Forcing, Integrator, MappedMesh, Parameters};
use mesh::TetMesh;
use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};
use nalgebra::{Isometry3, Vector3};
use rigid::{Arms, Articulation, BodyKind, Drive, ExternalLoad};
use stokes::{Options, Problem};

/// A load on the sphere that grows with time.
struct Pull;

impl Forcing for Pull {
    fn load(&self, time: f64, _body: usize, _pose: &Isometry3<f64>) -> ExternalLoad {
        ExternalLoad {
            force: Vector3::z() * (10.0 * time),
            torque: Vector3::zeros(),
        }
    }
}

fn steps(criterion: &mut Criterion) {
    let [sphere, ball] = [1.0, 5.0].map(|radius| Sphere {
        centre: Vector3::zeros(),
        radius,
    });
    let body = MeshedBody {
        name: "sphere",
        surface: &sphere,
        size: 0.25,
    };
    let container = Container::Ball(ball);
    let Ok(tets) = generate(&[body], &container, &GenerateParams::default()) else {
        return;
    };
    let surfaces = [("sphere", &sphere as _), (Container::TAG, &ball as _)];
    let (Ok(mesh), Ok(set)) = (
        TetMesh::curved(tets.mesh, &surfaces),
        Articulation::new(
            &[BodyKind::Rigid],
            vec![],
            Arms::Clamped,
            &[Vector3::zeros()],
        ),
    ) else {
        return;
    };
    let mut group = criterion.benchmark_group(format!("{} nodes", mesh.n_points()));
    group.sample_size(10);
    group.bench_function("Stokes solution", |bencher| {
        let problem = Problem::new(&mesh, &[("sphere", sphere.centre)], &[Container::TAG]);
        let constraints = set.constraints(&set.initial_state(), &[], &[]);
        let (Ok(problem), Ok(constraints)) = (problem, constraints) else {
            return;
        };
        let drive = Drive {
            set: &set,
            constraints: &constraints,
            loads: &[Pull.load(1.0, 0, &Isometry3::identity())],
        };
        bencher.iter(|| black_box(problem.solve(&drive, &Options::default()).map(|s| s.dofs)));
    });
    for (name, convection) in [
        ("step of unsteady Stokes flow", Convection::Neglected),
        ("step of Navier-Stokes flow", Convection::Full),
    ] {
        let moving = MovingBody {
            tag: "sphere".into(),
            centre: Vector3::zeros(),
            rotates: false,
        };
        let motion = Harmonic(Stiffening::default());
        let Ok(map) = ReferenceMap::new(mesh.clone(), &[moving], &motion) else {
            return;
        };
        let bodies = Bodies {
            set: &set,
            masses: vec![BodyMass::sphere(1.0, 1.0)],
            surfaces: vec!["sphere".into()],
            walls: vec![Container::TAG.into()],
        };
        let meshes = Box::new(MappedMesh::new(map, vec![Isometry3::identity()]));
        let parameters = Parameters::new(5.0).with_convection(convection);
        let Ok(mut run) = Integrator::from_rest(bodies, &Pull, meshes, parameters, 0.0) else {
            return;
        };
        group.bench_function(name, |bencher| {
            bencher.iter(|| black_box(run.step(5e-3).map(|report| report.iterations)));
        });
    }
    group.finish();
}

criterion_group!(benches, steps);
criterion_main!(benches);
