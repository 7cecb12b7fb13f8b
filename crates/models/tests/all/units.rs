//! Solutions in other units of length and viscosity.

use models::{
    Configuration, ErrorEstimate, FemModel, Hydrodynamics, InstantaneousSolution, SphereModel,
    SpheresModel,
};
use nalgebra::Vector3;
use scene::Scene;

/// Powers of two, so that the numbers of both scenes differ in their exponents only.
const LENGTH: f64 = 1.0 / 1024.0;
const VISCOSITY: f64 = 4.0;

/// Two linked spheres and a loose one with a force and a torque, in units of the given length and
/// viscosity.
fn bodies(length: f64, viscosity: f64, more: &str) -> Scene {
    let vector = |v: [f64; 3], unit: f64| format!("{:?}", v.map(|x| x * unit));
    let force = viscosity * length.powi(2);
    Scene::parse(&format!(
        r#"
        fluid.viscosity = {viscosity:?}
        {more}
        bodies = [
            {{ name = "a", radius = {:?}, position = {} }},
            {{ name = "b", radius = {:?}, position = {} }},
            {{ name = "c", radius = {:?}, position = {}, force = {}, torque = {} }},
        ]
        links = [{{ name = "arm", body = "b", to = "a" }}]
        "#,
        length,
        vector([-3.0, 0.0, 0.5], length),
        1.5 * length,
        vector([2.0, 1.0, 0.0], length),
        length,
        vector([0.0, -4.0, 0.0], length),
        vector([1.0, 2.0, 3.0], force),
        vector([4.0, -5.0, 6.0], force * length),
    ))
    .unwrap()
}

fn solve(model: &mut dyn Hydrodynamics, rate: f64) -> InstantaneousSolution {
    let scene = model.scene().clone();
    let state = scene.initial_state();
    let configuration = Configuration {
        state: &state,
        shape: scene.articulation().initial_shape(),
    };
    model.solve_one(configuration, &[rate]).unwrap()
}

fn assert_scaled(found: &[Vector3<f64>], reference: &[Vector3<f64>], unit: f64) {
    assert_eq!(found.len(), reference.len());
    for (found, reference) in found.iter().zip(reference) {
        assert_eq!(*found, reference * unit);
    }
}

fn assert_bars(found: &ErrorEstimate, reference: &ErrorEstimate, unit: f64) {
    for ((name, found), (_, reference)) in found.sources().into_iter().zip(reference.sources()) {
        assert_eq!(found, reference.map(|bar| bar * unit), "{name}");
    }
}

fn assert_same_in_other_units(found: &InstantaneousSolution, reference: &InstantaneousSolution) {
    let force = VISCOSITY * LENGTH.powi(2);
    for (found, reference) in found.bodies.iter().zip(&reference.bodies) {
        assert_scaled(&[found.velocity], &[reference.velocity], LENGTH);
        assert_scaled(
            &[found.angular_velocity],
            &[reference.angular_velocity],
            1.0,
        );
        assert_scaled(&[found.force], &[reference.force], force);
        assert_scaled(&[found.torque], &[reference.torque], force * LENGTH);
        assert!(reference.torque.norm() > 1e-3 && reference.force.norm() > 1e-3);
    }
    assert_scaled(&found.joint_forces, &reference.joint_forces, force);
    assert_scaled(&found.motion.spins, &reference.motion.spins, 1.0);
    for (found, reference) in found.motion.frames.iter().zip(&reference.motion.frames) {
        assert_scaled(&[found.linear], &[reference.linear], LENGTH);
        assert_scaled(&[found.angular], &[reference.angular], 1.0);
    }
    assert_eq!(found.power(), reference.power() * force * LENGTH);
    assert!(reference.error_estimate.total() > 0.0 && reference.power_error.total() > 0.0);
    assert_bars(&found.error_estimate, &reference.error_estimate, LENGTH);
    assert_bars(&found.force_error, &reference.force_error, force);
    assert_bars(&found.power_error, &reference.power_error, force * LENGTH);
    assert_eq!(found.mesh_error.is_some(), reference.mesh_error.is_some());
    let (Some(found), Some(reference)) = (&found.mesh_error, &reference.mesh_error) else {
        return;
    };
    for (found, reference) in found.bodies.iter().zip(&reference.bodies) {
        assert_scaled(&[found.velocity], &[reference.velocity], LENGTH);
        assert_scaled(&[found.force], &[reference.force], force);
        assert_scaled(&[found.torque], &[reference.torque], force * LENGTH);
    }
    assert_scaled(&found.joint_forces, &reference.joint_forces, force);
    let (own, other) = (found.uncertainty, reference.uncertainty);
    assert_eq!(own.velocity, other.velocity * LENGTH);
    assert_eq!(own.relative, other.relative);
    for (found, reference) in (found.motion.frames.iter()).zip(&reference.motion.frames) {
        assert_scaled(&[found.linear], &[reference.linear], LENGTH);
        assert_scaled(&[found.angular], &[reference.angular], 1.0);
    }
}

#[test]
fn models_of_spheres_give_the_same_solution_in_other_units() {
    let [reference, other] = [bodies(1.0, 1.0, ""), bodies(LENGTH, VISCOSITY, "")];
    let model = |scene: &Scene| SpheresModel::new(scene, SphereModel::Rpy).unwrap();
    let found = solve(&mut model(&other), 0.5 * LENGTH);
    assert_same_in_other_units(&found, &solve(&mut model(&reference), 0.5));
    // Forces per velocity, forces per angular velocity, torques per angular velocity.
    let matrix = |scene: &Scene| {
        let state = scene.initial_state();
        let shape = scene.articulation().initial_shape();
        let configuration = Configuration {
            state: &state,
            shape,
        };
        model(scene).resistance(configuration).unwrap()
    };
    let (found, reference) = (matrix(&other), matrix(&reference));
    let unit = |entry: usize| if entry % 6 < 3 { 1.0 } else { LENGTH };
    for i in 0..18 {
        for j in 0..18 {
            let expected = reference[(i, j)] * VISCOSITY * LENGTH * unit(i) * unit(j);
            assert_eq!(found[(i, j)], expected, "{i} {j}");
        }
    }
}

#[test]
fn finite_elements_give_the_same_solution_and_flow_in_other_units() {
    let scene = |length: f64, viscosity: f64| {
        let radius = 10.0 * length;
        let fem = format!(
            "model.kind = \"fem\"\nfem.surface_size = {:?}\n\
             domain = {{ kind = \"ball\", radius = {radius:?} }}",
            1.5 * length
        );
        bodies(length, viscosity, &fem)
    };
    let [(found, flow), (reference, reference_flow)] =
        [(LENGTH, VISCOSITY), (1.0, 1.0)].map(|(length, viscosity)| {
            let mut model = FemModel::new(&scene(length, viscosity)).unwrap();
            let solution = solve(&mut model, 0.5 * length);
            (solution, model.last_flow().unwrap())
        });
    assert_same_in_other_units(&found, &reference);
    assert!(found.mesh_error.is_some());
    assert_scaled(flow.mesh.points(), reference_flow.mesh.points(), LENGTH);
    assert_scaled(&flow.velocity, &reference_flow.velocity, LENGTH);
    for (found, reference) in flow.pressure.iter().zip(&reference_flow.pressure) {
        assert_eq!(*found, reference * VISCOSITY);
    }
}
