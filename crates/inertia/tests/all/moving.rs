//! Moving meshes: uniform flow, accelerated containers, order in time, energy, remeshing.

use ale::{Harmonic, MovingBody, ReferenceMap, Stiffening};
use inertia::{
    Bodies, BodyMass, Forcing, InertiaError, Integrator, MappedMesh, Meshes, Parameters,
    SteadyFlow, SteadyParameters, SuppliedMesh,
};
use linalg::TimeDerivative;
use mesh::{LinearTets, TetMesh};
use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};
use nalgebra::{Isometry3, Matrix3};
use rigid::{Arms, Articulation, BodyKind, Drive, ExternalLoad, Joint};
use stokes::Options;
use stokes::rheology::{Law, ViscosityLaw};

use crate::support::{QUARTER, STOKES, Vec3, bodies, free_sphere, sphere_in_ball};

/// A cube whose inner nodes are displaced at random in each mesh.
struct Jiggled {
    mesh: TetMesh,
    calls: u64,
}

impl Meshes for Jiggled {
    fn mesh(&mut self, _: f64, _: &[Isometry3<f64>]) -> Result<Option<SuppliedMesh>, InertiaError> {
        self.calls += 1;
        let mut seed = self.calls;
        let mut random = || {
            // Knuth's linear congruential generator
            seed = seed
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let inside = |x: &Vec3| x.iter().all(|c| *c > 1e-9 && *c < 1.0 - 1e-9);
        let mut points = self.mesh.points().to_vec();
        for x in points.iter_mut().filter(|x| inside(x)) {
            *x += 0.04 * Vec3::new(random(), random(), random());
        }
        Ok(Some(self.mesh.with_points(points)?.into()))
    }
}

/// All walls move with one velocity.
struct UniformWalls(Vec3);

impl Forcing for UniformWalls {
    fn has_moving_walls(&self) -> bool {
        true
    }
    fn wall_velocity(&self, _: f64, _: &Vec3) -> Vec3 {
        self.0
    }
}

#[test]
fn uniform_flow_on_a_jiggled_mesh_stays_uniform() {
    let mesh = TetMesh::straight(LinearTets::cube(3)).unwrap();
    let set = Articulation::new(&[], vec![], Arms::Free, &[]).unwrap();
    let walls = ["x0", "x1", "y0", "y1", "z0", "z1"]
        .map(String::from)
        .to_vec();
    let bodies = Bodies {
        set: &set,
        masses: vec![],
        surfaces: vec![],
        walls,
    };
    let velocity = Vec3::new(1.0, -2.0, 0.5);
    let forcing = UniformWalls(velocity);
    let options = Options::default().with_rtol(1e-12);
    let parameters = Parameters::new(10.0).with_options(options);
    let nodes = mesh.n_points();
    let meshes = Box::new(Jiggled { mesh, calls: 0 });
    let mut run = Integrator::from_rest(bodies, &forcing, meshes, parameters, 0.0).unwrap();
    run.set_flow(vec![velocity; nodes], &[]).unwrap();
    for length in [0.01, 0.013, 0.008, 0.02] {
        run.step(length).unwrap();
        let largest = run
            .velocity()
            .iter()
            .map(|u| (u - velocity).norm())
            .fold(0.0, f64::max);
        // the solver's tolerance, times the condition of a small system
        assert!(largest < 1e-9, "{largest:e}");
    }
}

/// The map of a mesh with a sphere that moves from the origin.
fn mapped(mesh: TetMesh) -> MappedMesh {
    let body = MovingBody {
        tag: "sphere".into(),
        centre: Vec3::zeros(),
        rotates: false,
    };
    let map = ReferenceMap::new(mesh, &[body], &Harmonic(Stiffening::default())).unwrap();
    MappedMesh::new(map, vec![Isometry3::identity()])
}

/// A mesh in a container at these positions after each step of a length.
struct Carried {
    inner: MappedMesh,
    positions: Vec<f64>,
    step: f64,
}

impl Meshes for Carried {
    fn mesh(
        &mut self,
        time: f64,
        poses: &[Isometry3<f64>],
    ) -> Result<Option<SuppliedMesh>, InertiaError> {
        let shift = Vec3::z() * self.positions[(time / self.step).round() as usize];
        let relative = poses.iter().map(|pose| {
            let mut pose = *pose;
            pose.translation.vector -= shift;
            pose
        });
        let Some(moved) = self.inner.mesh(time, &relative.collect::<Vec<_>>())? else {
            return Ok(None);
        };
        let mesh = moved.mesh;
        let points = mesh.points().iter().map(|x| x + shift).collect();
        Ok(Some(mesh.with_points(points)?.into()))
    }
}

/// A squirmer in a container with the acceleration `a` along z.
struct Accelerated {
    a: f64,
}

impl Forcing for Accelerated {
    fn has_slip(&self) -> bool {
        true
    }
    fn slip(&self, time: f64, _: usize, x: &Vec3) -> Vec3 {
        let n = x.normalize();
        // No slip in the first step: extrapolation knows the acceleration from the second one on,
        // and a uniform flow does not feel with which velocity it is convected.
        let time = (time - 0.06).max(0.0);
        1.5 * time * (1.0 + 2.0 * n.z) * (n.z * n - Vec3::z())
    }
    fn has_moving_walls(&self) -> bool {
        true
    }
    fn wall_velocity(&self, time: f64, _: &Vec3) -> Vec3 {
        Vec3::z() * (self.a * time)
    }
}

/// The same mesh with each midside node in the middle of its edge.
fn straightened(mesh: &TetMesh) -> TetMesh {
    let mut points = mesh.points().to_vec();
    for cell in mesh.cells() {
        for (k, [a, b]) in mesh::TET_EDGES.into_iter().enumerate() {
            let [a, b] = [cell[a], cell[b]].map(|vertex| mesh.points()[vertex as usize]);
            points[cell[4 + k] as usize] = (a + b) / 2.0;
        }
    }
    mesh.with_points(points).unwrap()
}

#[test]
fn scene_and_container_accelerated_together_change_forces_by_the_displaced_mass() {
    let (density, length, steps) = (5.0, 0.05, 5);
    // Straight cells: the pressure ρ a z of the acceleration is then a linear element function.
    let curved = sphere_in_ball(0.7, 3.0, QUARTER);
    let mesh = straightened(&curved);
    let volume = 4.0
        * fem::surface_measures(&mesh, mesh.tag("sphere").unwrap())
            .unwrap()
            .volume;
    let set = free_sphere(Vec3::zeros());
    let run = |a: f64| {
        // positions of the container by the formula of the steps
        let (mut positions, mut last) = (vec![0.0], 0.0);
        for step in 1..=steps {
            let velocity = a * step as f64 * length;
            let increment = match step {
                1 => length * velocity,
                _ => (length * velocity + 0.5 * last) / 1.5,
            };
            positions.push(positions[step - 1] + increment);
            last = increment;
        }
        let meshes = Carried {
            inner: mapped(mesh.clone()),
            positions,
            step: length,
        };
        let forcing = Accelerated { a };
        // neutrally buoyant in the discrete fluid: the acceleration needs no external force
        let mut bodies = bodies(&set, 0.0);
        bodies.masses = vec![BodyMass {
            mass: density * volume,
            ..BodyMass::default()
        }];
        let options = Options::default().with_rtol(1e-11);
        let mut parameters = Parameters::new(density).with_options(options);
        // predictions do not know of the container: correct them to rounding
        parameters.mesh_tolerance = 1e-12;
        parameters.max_corrections = 20;
        let mut run =
            Integrator::from_rest(bodies, &forcing, Box::new(meshes), parameters, 0.0).unwrap();
        (0..steps)
            .map(|_| run.step(length).unwrap())
            .collect::<Vec<_>>()
    };
    let a = 3.0;
    for (still, moved) in run(0.0).iter().zip(run(a)) {
        let speed = moved.bodies[2] - a * moved.time - still.bodies[2];
        assert!(speed.abs() < 1e-7, "{}: {speed:e}", still.time);
        let change = moved.forces[2] - still.forces[2] + density * volume * a;
        // bodies exert the opposite of the buoyancy ρ V a on the fluid
        assert!(
            change.abs() < 1e-6 * density * volume * a,
            "{}: {change:e}",
            still.time
        );
    }
}

/// A force that grows as `t^2`, so that the start is smooth.
struct GrowingPull;

impl Forcing for GrowingPull {
    fn load(&self, time: f64, _: usize, _: &Isometry3<f64>) -> ExternalLoad {
        ExternalLoad {
            force: Vec3::z() * (2.0 * STOKES * time * time),
            torque: Vec3::zeros(),
        }
    }
}

/// Speed and position at time 1, and the relative defects of the balances of energy and momentum.
fn pulled(mesh: &TetMesh, steps: usize, law: Option<&Law>) -> [f64; 4] {
    let (density, of_body) = (4.0, 8.0);
    let set = free_sphere(Vec3::zeros());
    let meshes = Box::new(mapped(mesh.clone()));
    let options = Options::default().with_rtol(1e-10);
    let mut parameters = Parameters::new(density).with_options(options);
    if let Some(law) = law {
        parameters = parameters.with_law(law);
    }
    // the stress without the pressure, as the stiffness has it
    let viscous = |gradient: Matrix3<f64>| match law {
        None => gradient,
        Some(law) => {
            let twice = gradient + gradient.transpose();
            law.viscosity(twice.norm() / f64::sqrt(2.0)) * twice
        }
    };
    let (bodies, forcing) = (bodies(&set, of_body), GrowingPull);
    let mass = bodies.masses[0].mass;
    let mut run = Integrator::from_rest(bodies, &forcing, meshes, parameters, 0.0).unwrap();
    let length = 1.0 / steps as f64;
    let (mut power_before, mut work, mut kinetic, mut done) = (0.0, 0.0, 0.0, 0.0);
    let (mut speed, mut position) = (0.0, 0.0);
    let wall = mesh.nodes_on(mesh.tag(Container::TAG).unwrap());
    let mut weight = vec![Vec3::zeros(); mesh.n_points()];
    for node in wall {
        weight[node as usize] = Vec3::z();
    }
    // positions and velocities of the nodes at earlier times, the last one first
    let mut before = vec![(mesh.points().to_vec(), run.velocity().to_vec())];
    let [mut impulse, mut pushed, mut force_before, mut momentum] = [0.0; 4];
    for _ in 0..steps {
        let step = run.try_step(length).unwrap();
        speed = step.solved.flow.bodies[2];
        position = step.poses[0].translation.vector.z;
        let load = forcing.load(step.time, 0, &step.poses[0]).force.z;
        let (mesh, flow) = (step.mesh(), &step.solved.flow.velocity);
        // The balance of the discrete equations, tested with their velocity: dissipation in the
        // form of the stiffness, and what the divergence between the vertices does to the energy.
        let lost = fem::integrate(mesh, 6, |p| {
            let gradient = p.gradient(flow);
            viscous(gradient).dot(&gradient)
                - 0.5 * density * p.value(flow).norm_squared() * gradient.trace()
        });
        let power = load * speed - 4.0 * lost.unwrap();
        work += 0.5 * length * (power + power_before);
        done += length * load * speed;
        power_before = power;
        // Force of the wall on the fluid: the momentum equation tested with a velocity that is one
        // on the wall and zero at all other nodes.
        let formula = TimeDerivative::new(length, &vec![length; before.len() - 1]);
        let rate = |now: &[Vec3], earlier: &dyn Fn(usize) -> Vec<Vec3>| -> Vec<Vec3> {
            let mut sum: Vec<Vec3> = now.iter().map(|v| formula.newest() * v).collect();
            for k in 1..=before.len() {
                for (sum, v) in sum.iter_mut().zip(earlier(k - 1)) {
                    *sum += formula.older(k) * v;
                }
            }
            sum
        };
        let of_mesh = rate(mesh.points(), &|k| before[k].0.clone());
        let of_nodes = rate(flow, &|k| before[k].1.clone());
        let pressure = &step.solved.flow.pressure;
        let [of_wall, of_divergence] = fem::integrate(mesh, 6, |p| {
            let (test, gradient) = (p.value(&weight), p.gradient(flow));
            let test_gradient = p.gradient(&weight);
            let (u, w) = (p.value(flow), p.value(&of_mesh));
            let acceleration = p.value(&of_nodes) + gradient * (u - w);
            let stress =
                viscous(gradient).dot(&test_gradient) - p.value(pressure) * test_gradient.trace();
            [
                density * acceleration.dot(&test) + stress,
                density * u.z * gradient.trace(),
            ]
        })
        .unwrap();
        // The convective term is not in the form of a divergence: what there is of one between the
        // vertices is an error of the elements, and no part of the balance.
        let force = load + 4.0 * (of_wall + of_divergence);
        impulse += 0.5 * length * (force + force_before);
        pushed += length * load;
        force_before = force;
        momentum = 4.0 * density * fem::integrate(mesh, 6, |p| p.value(flow).z).unwrap();
        momentum += mass * speed;
        before.insert(0, (mesh.points().to_vec(), flow.clone()));
        before.truncate(2);
        run.accept(step).unwrap();
        let of_body = run.bodies_kinetic_energy();
        // rounding of a product
        assert!((of_body - 0.5 * mass * speed * speed).abs() < 1e-14 * of_body);
        kinetic = 4.0 * run.kinetic_energy().unwrap() + of_body;
    }
    let defects = [(kinetic - work) / done, (momentum - impulse) / pushed];
    [speed, position, defects[0], defects[1]]
}

#[test]
fn steps_are_of_second_order_and_the_balances_of_energy_and_momentum_close_with_them() {
    let mesh = sphere_in_ball(0.7, 3.0, QUARTER);
    check_orders([10, 20, 40].map(|steps| pulled(&mesh, steps, None)));
}

#[test]
fn steps_of_a_fluid_that_thins_are_of_second_order_and_the_balances_close_with_its_stress() {
    let mesh = sphere_in_ball(0.7, 3.0, QUARTER);
    let law = Law::Carreau {
        zero_shear_viscosity: 1.0,
        infinite_shear_viscosity: 0.0,
        relaxation_time: 3.0,
        index: 0.5,
    };
    check_orders([10, 20, 40].map(|steps| pulled(&mesh, steps, Some(&law))));
}

/// Checks the order of speeds, positions and balances of runs of 10, 20 and 40 steps.
fn check_orders(runs: [[f64; 4]; 3]) {
    println!("{runs:?}");
    for (k, what) in ["speed", "position"].into_iter().enumerate() {
        let ratio = (runs[1][k] - runs[0][k]) / (runs[2][k] - runs[1][k]);
        let order = ratio.log2();
        println!("{what}: order {order}");
        assert!(order > 1.8, "{what}: {order}");
    }
    // the defects are of second order too
    for (k, what) in [(2, "energy"), (3, "momentum")] {
        let defects = runs.map(|run| run[k].abs());
        let order = (defects[1] / defects[2]).log2();
        println!("balance of {what}: order {order}, defects {defects:?}");
        assert!(order > 1.8 && defects[2] < 2e-3, "{what}: {defects:?}");
    }
}

/// Meshes that are replaced by one of two at each call of `renew`.
struct Alternating {
    meshes: [TetMesh; 2],
    present: usize,
}

impl Meshes for Alternating {
    fn mesh(&mut self, _: f64, _: &[Isometry3<f64>]) -> Result<Option<SuppliedMesh>, InertiaError> {
        Ok(Some(self.meshes[self.present].clone().into()))
    }
    fn renew(
        &mut self,
        _: f64,
        _: &[Isometry3<f64>],
    ) -> Result<Option<SuppliedMesh>, InertiaError> {
        self.present = 1 - self.present;
        Ok(Some(self.meshes[self.present].clone().into()))
    }
}

#[test]
fn remeshing_at_every_step_changes_a_steady_force_by_the_mesh_error() {
    let density = 2.0;
    let meshes = [0.5, 0.45].map(|size| sphere_in_ball(size, 4.0, QUARTER));
    let set = free_sphere(Vec3::zeros()).with_held(&[0], &[0]).unwrap();
    let drive = Drive {
        set: &set,
        constraints: &set.constraints(&set.initial_state(), &[], &[]).unwrap(),
        loads: &[ExternalLoad::default()],
    };
    let steady = meshes.each_ref().map(|mesh| {
        let wall = vec![Vec3::z(); mesh.n_points()];
        let flow = SteadyFlow {
            mesh,
            bodies: &[("sphere", Vec3::zeros())],
            walls: &[Container::TAG],
            slip: None,
            wall_velocity: Some(&wall),
            moves_with_body: false,
        };
        flow.solve(&drive, density, &SteadyParameters::default())
            .unwrap()
            .solved
            .flow
    });
    let exact = steady[0].forces[2];
    let mesh_error = (steady[1].forces[2] / exact - 1.0).abs();
    println!("steady {exact}, other mesh {mesh_error:e}");
    // A projected flow has the velocities of the steady one, but its force is no longer a residual
    // that vanishes: it errs as the stress on the surfaces of both meshes does, at any step.
    let stress_error = |(mesh, flow): (&TetMesh, &rigid::FlowSolution)| {
        let (tag, centre) = (mesh.tag("sphere").unwrap(), Vec3::zeros());
        let load = fem::stress_load(mesh, tag, &flow.velocity, &flow.pressure, centre).unwrap();
        (4.0 * load.force.z / flow.forces[2] - 1.0).abs()
    };
    let stress_errors: f64 = meshes.iter().zip(&steady).map(stress_error).sum();
    println!("stress errors {stress_errors:e}");
    let forcing = UniformWalls(Vec3::z());
    for length in [1e-1, 1e-2, 1e-3] {
        let alternating = Box::new(Alternating {
            meshes: meshes.clone(),
            present: 0,
        });
        let parameters = Parameters::new(density);
        let mut run =
            Integrator::from_rest(bodies(&set, 0.0), &forcing, alternating, parameters, 0.0)
                .unwrap();
        run.set_flow(steady[0].velocity.clone(), steady[0].generalised.as_slice())
            .unwrap();
        let mut largest: f64 = 0.0;
        for _ in 0..6 {
            assert!(run.renew_mesh().unwrap());
            let report = run.step(length).unwrap();
            largest = largest.max((report.forces[2] / exact - 1.0).abs());
        }
        let jump = run.last_jump().unwrap();
        println!("step {length}: largest change of the force {largest:e}, {jump:?}");
        assert!(largest < stress_errors, "step {length}: {largest:e}");
    }
}

/// An arm that lengthens and shortens.
struct Arm;

impl Arm {
    fn length(time: f64) -> f64 {
        3.2 + 0.4 * (4.0 * time).sin()
    }
}

impl Forcing for Arm {
    fn shape(&self, time: f64) -> Vec<f64> {
        vec![Self::length(time)]
    }
}

#[test]
fn a_dumbbell_keeps_its_arm_and_its_momentum_balances() {
    let centres = [Vec3::new(0.0, 0.0, -1.6), Vec3::new(0.0, 0.0, 1.6)];
    let spheres = [1.0, 0.7].into_iter().zip(centres);
    let spheres: Vec<Sphere> = spheres
        .map(|(radius, centre)| Sphere { centre, radius })
        .collect();
    let ball = Sphere {
        centre: Vec3::zeros(),
        radius: 6.0,
    };
    let names = ["large", "small"];
    let parts: Vec<MeshedBody> = (names.iter().zip(&spheres))
        .map(|(name, surface)| MeshedBody {
            name,
            surface,
            size: 0.8,
        })
        .collect();
    let mut parameters = GenerateParams::default();
    parameters.symmetry_planes = QUARTER;
    let tets = generate(&parts, &Container::Ball(ball), &parameters)
        .unwrap()
        .mesh;
    let mesh = TetMesh::curved(
        tets,
        &[
            ("large", &spheres[0]),
            ("small", &spheres[1]),
            (Container::TAG, &ball),
        ],
    )
    .unwrap();
    let moving = names.iter().zip(centres).map(|(name, centre)| MovingBody {
        tag: (*name).into(),
        centre,
        rotates: false,
    });
    let map = ReferenceMap::new(
        mesh,
        &moving.collect::<Vec<_>>(),
        &Harmonic(Stiffening::default()),
    )
    .unwrap();
    let initial = centres
        .map(|c| Isometry3::translation(c.x, c.y, c.z))
        .to_vec();
    let joint = Joint::slide("arm", 1, 0);
    let set = Articulation::new(&[BodyKind::Rigid; 2], vec![joint], Arms::Clamped, &centres);
    let set = set.unwrap();
    // the small sphere has no mass
    let masses = vec![BodyMass::sphere(1.0, 3.0), BodyMass::default()];
    let mass = masses[0].mass;
    let bodies = Bodies {
        set: &set,
        masses,
        surfaces: names.map(String::from).to_vec(),
        walls: vec![Container::TAG.into()],
    };
    let meshes = Box::new(MappedMesh::new(map, initial));
    let options = Options::default().with_rtol(1e-10);
    let parameters = Parameters::new(5.0).with_options(options);
    let mut run = Integrator::from_rest(bodies, &Arm, meshes, parameters, 0.0).unwrap();
    let (length, mut speeds) = (0.05, vec![0.0]);
    for step in 1..=8 {
        let step_of = run.try_step(length).unwrap();
        let apart = step_of.poses[1].translation.vector - step_of.poses[0].translation.vector;
        assert!((apart.norm() - Arm::length(step_of.time)).abs() < 1e-12);
        speeds.push(step_of.solved.flow.bodies[2]);
        let last = |k: usize| speeds[speeds.len() - 1 - k];
        let rate = match step {
            1 => last(0) - last(1),
            _ => 1.5 * last(0) - 2.0 * last(1) + 0.5 * last(2),
        };
        let forces = [step_of.solved.flow.forces[2], step_of.solved.flow.forces[8]];
        let sum = forces[0] + forces[1] + mass * rate / length;
        assert!(
            sum.abs() < 1e-7 * forces[0].abs().max(forces[1].abs()),
            "{step}: {sum:e}"
        );
        run.accept(step_of).unwrap();
    }
}

/// A mesh that turns with a body at its centre, and is renewed by itself.
struct Turning(TetMesh);

impl Meshes for Turning {
    fn mesh(
        &mut self,
        _: f64,
        poses: &[Isometry3<f64>],
    ) -> Result<Option<SuppliedMesh>, InertiaError> {
        let turned = (self.0.points().iter()).map(|x| poses[0].rotation * x);
        Ok(Some(self.0.with_points(turned.collect())?.into()))
    }
    fn renew(
        &mut self,
        time: f64,
        poses: &[Isometry3<f64>],
    ) -> Result<Option<SuppliedMesh>, InertiaError> {
        self.mesh(time, poses)
    }
}

/// A squirmer along its own z axis that a torque about x turns.
struct TurningSquirmer;

impl Forcing for TurningSquirmer {
    fn load(&self, _: f64, _: usize, _: &Isometry3<f64>) -> ExternalLoad {
        ExternalLoad {
            force: Vec3::zeros(),
            torque: Vec3::x() * (8.0 * std::f64::consts::PI),
        }
    }
    fn has_slip(&self) -> bool {
        true
    }
    fn slip(&self, _: f64, _: usize, x: &Vec3) -> Vec3 {
        let n = x.normalize();
        n.z * n - Vec3::z()
    }
}

/// Remeshing took the slip of all bodies in the axes of the laboratory.
#[test]
fn slip_turns_with_its_body_when_the_mesh_is_renewed() {
    let mesh = sphere_in_ball(0.9, 2.5, [false; 3]);
    let set = free_sphere(Vec3::zeros()).with_held(&[0], &[]).unwrap();
    let parameters = Parameters::new(1.0);
    let (bodies, forcing) = (bodies(&set, 1.0), TurningSquirmer);
    let mut run =
        Integrator::from_rest(bodies, &forcing, Box::new(Turning(mesh)), parameters, 0.0).unwrap();
    for _ in 0..2 {
        run.step(0.5).unwrap();
    }
    assert!(run.poses().unwrap()[0].rotation.angle() > 0.3);
    let nodes = run.mesh().nodes_on(run.mesh().tag("sphere").unwrap());
    let before = run.velocity().to_vec();
    assert!(run.renew_mesh().unwrap());
    for node in nodes {
        let change = (run.velocity()[node as usize] - before[node as usize]).norm();
        // the mesh of a step is within 1e-4 of the poses, and slip and rotation change by at most
        // 3 per radius; in the axes of the laboratory the slip differs by the angle
        assert!(change < 3e-4, "node {node}: {change:e}");
    }
}
