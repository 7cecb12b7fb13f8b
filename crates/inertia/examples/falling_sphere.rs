//! A sphere that falls from rest by a finite distance, by the Navier-Stokes equations.

use ale::{Harmonic, MovingBody, ReferenceMap, Stiffening};
use inertia::{Bodies, BodyMass, Forcing, Integrator, MappedMesh, Parameters};
use mesh::TetMesh;
use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};
use nalgebra::{Isometry3, Vector3};
use rigid::{Arms, Articulation, BodyKind, ExternalLoad};

/// Density of the sphere, and of the fluid.
const DENSITIES: [f64; 2] = [10.0, 5.0];

/// Weight less buoyancy, along z.
struct Weight(f64);

impl Forcing for Weight {
    fn load(&self, _time: f64, _body: usize, _pose: &Isometry3<f64>) -> ExternalLoad {
        ExternalLoad {
            force: Vector3::z() * self.0,
            torque: Vector3::zeros(),
        }
    }
}

/// Prints the speed while it falls, and checks that the momentum of the sphere balances.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let [sphere, ball] = [1.0, 4.0].map(|radius| Sphere {
        centre: Vector3::zeros(),
        radius,
    });
    let body = MeshedBody {
        name: "sphere",
        surface: &sphere,
        size: 0.7,
    };
    // a quarter of the fluid: the flow is symmetric about the planes x = 0 and y = 0
    let mut parameters = GenerateParams::default();
    parameters.symmetry_planes = [true, true, false];
    let tets = generate(&[body], &Container::Ball(ball), &parameters)?.mesh;
    let mesh = TetMesh::curved(tets, &[("sphere", &sphere), (Container::TAG, &ball)])?;
    let moving = MovingBody {
        tag: "sphere".into(),
        centre: Vector3::zeros(),
        rotates: false,
    };
    let map = ReferenceMap::new(mesh, &[moving], &Harmonic(Stiffening::default()))?;
    let meshes = Box::new(MappedMesh::new(map, vec![Isometry3::identity()]));

    let set = Articulation::new(
        &[BodyKind::Rigid],
        vec![],
        Arms::Clamped,
        &[Vector3::zeros()],
    )?;
    let [of_sphere, of_fluid] = DENSITIES;
    let mass = BodyMass::sphere(1.0, of_sphere);
    let bodies = Bodies {
        set: &set,
        masses: vec![mass],
        surfaces: vec!["sphere".into()],
        walls: vec![Container::TAG.into()],
    };
    let weight = Weight(60.0);
    let mut run = Integrator::from_rest(bodies, &weight, meshes, Parameters::new(of_fluid), 0.0)?;
    let (mut impulse, mut speed, mut before) = (0.0, 0.0, 0.0);
    run.advance_to(0.5, 1e-2, 1e-3, |step| {
        speed = step.solved.flow.bodies[2];
        let position = step.poses[0].translation.vector.z;
        let force = weight.0 - step.solved.flow.forces[2];
        // the first force is that of the released sphere: that of the first step stands for it
        impulse += step.length
            * if before == 0.0 {
                force
            } else {
                0.5 * (force + before)
            };
        before = force;
        println!("t {:.4}  z {position:.5}  speed {speed:.5}", step.time);
    })?;
    println!("momentum {:.4}, impulse {impulse:.4}", mass.mass * speed);
    assert!((mass.mass * speed / impulse - 1.0).abs() < 0.02);
    Ok(())
}
