//! Solutions in other units of length and viscosity.

use models::{
    ErrorEstimate, FemModel, InstantaneousSolution, Resistances, Response, SphereModel,
    SpheresModel,
};
use nalgebra::Vector3;
use scene::Scene;
use testkit::{SceneText, within};

use crate::scenes::solve_at_start;

/// Powers of two, so that the numbers of both scenes differ in their exponents only.
const LENGTH: f64 = 1.0 / 1024.0;
const VISCOSITY: f64 = 4.0;

/// Two linked spheres and a loose one with a force and a torque, in units of the given length and
/// viscosity.
fn bodies(length: f64, viscosity: f64) -> SceneText {
    let vector = |v: [f64; 3], unit: f64| v.map(|x| x * unit);
    let force = viscosity * length.powi(2);
    SceneText::new()
        .sphere("a", length, vector([-3.0, 0.0, 0.5], length))
        .sphere("b", 1.5 * length, vector([2.0, 1.0, 0.0], length))
        .sphere("c", length, vector([0.0, -4.0, 0.0], length))
        .slide("arm", "b", "a")
        .with(
            "bodies.c.force",
            format!("{:?}", vector([1.0, 2.0, 3.0], force)),
        )
        .with(
            "bodies.c.torque",
            format!("{:?}", vector([4.0, -5.0, 6.0], force * length)),
        )
        .with("fluid.viscosity", format!("{viscosity:?}"))
}

fn assert_scaled(found: &[Vector3<f64>], reference: &[Vector3<f64>], unit: f64) {
    assert_eq!(found.len(), reference.len());
    for (found, reference) in found.iter().zip(reference) {
        assert_eq!(*found, reference * unit);
    }
}

fn assert_responses(found: &Response, reference: &Response) {
    let force = VISCOSITY * LENGTH.powi(2);
    assert_eq!(found.bodies.len(), reference.bodies.len());
    for (found, reference) in found.bodies.iter().zip(&reference.bodies) {
        assert_scaled(&[found.velocity], &[reference.velocity], LENGTH);
        assert_scaled(
            &[found.angular_velocity],
            &[reference.angular_velocity],
            1.0,
        );
        assert_scaled(&[found.force], &[reference.force], force);
        assert_scaled(&[found.torque], &[reference.torque], force * LENGTH);
    }
    assert_eq!(found.joint_loads.len(), reference.joint_loads.len());
    for (found, reference) in found.joint_loads.iter().zip(&reference.joint_loads) {
        assert_scaled(&[found.force], &[reference.force], force);
        assert_scaled(&[found.torque], &[reference.torque], force * LENGTH);
        // The only joint is a slide.
        assert_eq!(found.drive, reference.drive * force);
        assert!(reference.drive.abs() > 1e-3);
    }
    assert_scaled(&found.motion.spins, &reference.motion.spins, 1.0);
    assert_eq!(found.motion.frames.len(), reference.motion.frames.len());
    for (found, reference) in found.motion.frames.iter().zip(&reference.motion.frames) {
        assert_scaled(&[found.linear], &[reference.linear], LENGTH);
        assert_scaled(&[found.angular], &[reference.angular], 1.0);
    }
}

fn assert_bars(found: &ErrorEstimate, reference: &ErrorEstimate, unit: f64) {
    for ((name, found), (_, reference)) in found.sources().into_iter().zip(reference.sources()) {
        assert_eq!(found, reference.map(|bar| bar * unit), "{name}");
    }
}

fn assert_same_in_other_units(found: &InstantaneousSolution, reference: &InstantaneousSolution) {
    let force = VISCOSITY * LENGTH.powi(2);
    for reference in &reference.bodies {
        assert!(reference.torque.norm() > 1e-3 && reference.force.norm() > 1e-3);
    }
    assert_responses(&found.response, &reference.response);
    assert_eq!(found.power(), reference.power() * force * LENGTH);
    assert!(reference.error_estimate.total() > 0.0 && reference.power_error.total() > 0.0);
    assert_bars(&found.error_estimate, &reference.error_estimate, LENGTH);
    assert_bars(
        &found.angular_velocity_error,
        &reference.angular_velocity_error,
        1.0,
    );
    assert_bars(&found.torque_error, &reference.torque_error, force * LENGTH);
    assert_bars(&found.force_error, &reference.force_error, force);
    assert_bars(&found.power_error, &reference.power_error, force * LENGTH);
    assert_eq!(found.mesh_error.is_some(), reference.mesh_error.is_some());
    let (Some(found), Some(reference)) = (&found.mesh_error, &reference.mesh_error) else {
        return;
    };
    assert_responses(&found.response, &reference.response);
    let (own, other) = (found.uncertainty, reference.uncertainty);
    assert_eq!(own.velocity, other.velocity * LENGTH);
    assert_eq!(own.relative, other.relative);
}

#[test]
fn models_of_spheres_give_the_same_solution_in_other_units() {
    let [reference, other] = [bodies(1.0, 1.0), bodies(LENGTH, VISCOSITY)].map(|text| text.scene());
    let model = |scene: &Scene| SpheresModel::new(scene, SphereModel::Rpy).unwrap();
    let found = solve_at_start(&mut model(&other), &[0.5 * LENGTH]);
    assert_same_in_other_units(&found, &solve_at_start(&mut model(&reference), &[0.5]));
    // Forces per velocity, forces per angular velocity, torques per angular velocity.
    let matrix = |scene: &Scene| {
        let state = scene.initial_state();
        let shape = scene.articulation().initial_shape();
        let configuration = testkit::at(&state, shape);
        let resistance = Resistances::resistance(&mut model(scene), configuration);
        resistance.unwrap().matrix
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

/// A hinge transmits the force and the torque of its body, and its drive does the work of both
/// bodies.
#[test]
fn loads_of_a_hinge_have_force_torque_and_drive_in_any_units() {
    let scene = |length: f64, viscosity: f64| {
        let at = |x: f64| [x * length, 0.0, 0.0];
        let hinge = format!("joint = \"hinge\", axis = [0, 0, 1], pivot = {:?}", at(3.0));
        SceneText::new()
            .sphere("a", length, at(0.0))
            .sphere("b", 1.5 * length, at(5.0))
            .joint("elbow", "b", "a", &hinge)
            .with("fluid.viscosity", format!("{viscosity:?}"))
            .scene()
    };
    let solve = |length: f64, viscosity: f64| {
        let mut model = SpheresModel::new(&scene(length, viscosity), SphereModel::Rpy).unwrap();
        solve_at_start(&mut model, &[0.25])
    };
    let solution = solve(1.0, 1.0);
    let (load, b) = (solution.joint_loads[0], solution.bodies[1]);
    let torque = b.torque + Vector3::new(2.0, 0.0, 0.0).cross(&b.force);
    assert!(load.drive > 1.0, "{load:?}");
    for (difference, what) in [
        ((load.force - b.force).norm(), "force"),
        ((load.torque - torque).norm(), "torque about the pivot"),
        (load.drive - load.torque.z, "drive about the axis"),
        (0.25 * load.drive - solution.power(), "power"),
    ] {
        let why = "rounding of a small system with forces of about ten";
        within(difference, 1e-12, format!("{what}: {why}"));
    }
    let (found, force) = (solve(LENGTH, VISCOSITY), VISCOSITY * LENGTH.powi(2));
    assert_scaled(&[found.joint_loads[0].force], &[load.force], force);
    assert_scaled(
        &[found.joint_loads[0].torque],
        &[load.torque],
        force * LENGTH,
    );
    assert_eq!(found.joint_loads[0].drive, load.drive * force * LENGTH);
}

#[test]
fn finite_elements_give_the_same_solution_and_flow_in_other_units() {
    let scene = |length: f64, viscosity: f64| {
        let text = bodies(length, viscosity).ball(10.0 * length);
        text.elements(1.5 * length).scene()
    };
    let [(found, flow), (reference, reference_flow)] =
        [(LENGTH, VISCOSITY), (1.0, 1.0)].map(|(length, viscosity)| {
            let mut model = FemModel::new(&scene(length, viscosity)).unwrap();
            let solution = solve_at_start(&mut model, &[0.5 * length]);
            let flow = solution.flow.clone().unwrap().into_field().unwrap();
            (solution, flow)
        });
    assert_same_in_other_units(&found, &reference);
    assert!(found.mesh_error.is_some());
    assert_scaled(flow.mesh.points(), reference_flow.mesh.points(), LENGTH);
    assert_scaled(&flow.velocity, &reference_flow.velocity, LENGTH);
    for (found, reference) in flow.pressure.iter().zip(&reference_flow.pressure) {
        assert_eq!(*found, reference * VISCOSITY);
    }
}
