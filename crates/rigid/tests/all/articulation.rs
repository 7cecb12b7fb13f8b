//! Invariants of articulated sets: constraints, null spaces and poses.

use nalgebra::{DVector, Vector3};
use proptest::prelude::*;
use rigid::{Arms, Articulation, BodyKind, Reduction, RigidError};

use crate::support::sets::{constraints, moved_state, slide, tree, values, vector};

fn check_reduction(set: &Articulation, rotation: Vector3<f64>, rates: &[f64], v: &[f64]) {
    let state = moved_state(set, &[rotation]);
    let c = set
        .constraints(&state, &values(set), &rates[..set.joints().len()])
        .unwrap();
    let reduction = Reduction::new(set, &c).unwrap();
    let q = reduction
        .velocities(&DVector::from_column_slice(&v[..reduction.dofs()]))
        .unwrap();
    // Arms are up to about 130 long and the elimination runs over at most 6 of them.
    assert!((&c.matrix * &q - &c.rates).amax() < 1e-10 * (1.0 + q.amax()) * c.matrix.amax());
    let singular = reduction.surface_basis.singular_values();
    assert!(singular.min() > 1e-9 * singular.max());
}

fn check_poses(set: &Articulation, rotation: Vector3<f64>, rates: &[f64], v: &[f64]) {
    let rates = &rates[..set.joints().len()];
    let state = moved_state(set, &[rotation]);
    let c = set.constraints(&state, &values(set), rates).unwrap();
    let reduction = Reduction::new(set, &c).unwrap();
    let q = reduction
        .velocities(&DVector::from_column_slice(&v[..reduction.dofs()]))
        .unwrap();
    let velocity = set.state_velocity(q.as_slice()).unwrap();
    let dt = 1e-5;
    let poses_at = |dt: f64| {
        let shape = values(set).into_iter().zip(rates);
        let shape: Vec<f64> = shape.map(|(l, r)| l + dt * r).collect();
        set.place(&set.advance(&state, &(&velocity * dt)).unwrap(), &shape)
            .unwrap()
    };
    for (body, (after, before)) in poses_at(dt).iter().zip(poses_at(-dt)).enumerate() {
        let first = c.layout.bodies()[body];
        let moved = (after.translation.vector - before.translation.vector) / (2.0 * dt);
        // Central differences: error dt^2 |Ω|^3 l / 6 and rounding 1e-16 l / dt, arms up to 130.
        assert!((moved - q.fixed_rows::<3>(first)).amax() < 1e-6);
        if set.kinds()[body] == BodyKind::Rigid {
            let rotated = (after.rotation * before.rotation.inverse()).scaled_axis() / (2.0 * dt);
            assert!((rotated - q.fixed_rows::<3>(first + 3)).amax() < 1e-6);
        }
    }
}

proptest! {
    #[test]
    fn eliminated_velocities_satisfy_every_constraint(
        set in tree(),
        rotation in vector(1.0),
        rates in prop::collection::vec(-2.0..2.0, 6),
        v in prop::collection::vec(-1.0..1.0, 42),
    ) {
        check_reduction(&set, rotation, &rates, &v);
    }

    #[test]
    fn poses_move_with_the_velocities_of_the_bodies(
        set in tree(),
        rotation in vector(1.0),
        rates in prop::collection::vec(-2.0..2.0, 6),
        v in prop::collection::vec(-1.0..1.0, 42),
    ) {
        check_poses(&set, rotation, &rates, &v);
    }
}

fn collinear(arms: Arms) -> Articulation {
    let x = [
        Vector3::new(-10.0, 0.0, 0.0),
        Vector3::zeros(),
        Vector3::new(10.0, 0.0, 0.0),
    ];
    Articulation::new(
        &[BodyKind::Rigid; 3],
        vec![slide(0, 1), slide(2, 1)],
        arms,
        &x,
    )
    .unwrap()
}

#[test]
fn arms_determine_the_number_of_free_motions() {
    // Clamped: one rigid motion. Lab: one translation and three rotations of bodies. Free: a frame
    // and three rotations of bodies, minus the rotation of the collinear frame about its own axis,
    // which moves no surface.
    for (arms, dofs) in [(Arms::Clamped, 6), (Arms::Lab, 3 + 9), (Arms::Free, 5 + 9)] {
        let set = collinear(arms);
        let c = constraints(&set, &set.initial_state(), &[-1.0, 0.0]);
        assert_eq!(Reduction::new(&set, &c).unwrap().dofs(), dofs, "{arms:?}");
    }
}

#[test]
fn lab_arms_are_equation_11_of_the_paper() {
    let set = collinear(Arms::Lab);
    let c = constraints(&set, &set.initial_state(), &[-1.0, 0.5]);
    let reduction = Reduction::new(&set, &c).unwrap();
    let q = reduction
        .velocities(&DVector::zeros(reduction.dofs()))
        .unwrap();
    let u = |body: usize| q.fixed_rows::<3>(c.layout.bodies()[body]).into_owned();
    // The left arm shortens: its outer sphere moves to the right relative to the centre. The right
    // arm becomes longer.
    assert_eq!(u(0) - u(1), Vector3::new(1.0, 0.0, 0.0));
    assert_eq!(u(2) - u(1), Vector3::new(0.5, 0.0, 0.0));
}

#[test]
fn redundant_loops_work_and_contradictory_ones_are_named() {
    let x = [Vector3::zeros(), 3.0 * Vector3::x(), 4.0 * Vector3::y()];
    let joints = vec![slide(1, 0), slide(2, 0), slide(2, 1)];
    for arms in [Arms::Clamped, Arms::Free, Arms::Lab] {
        let set = Articulation::new(&[BodyKind::Rigid; 3], joints.clone(), arms, &x).unwrap();
        let state = set.initial_state();
        // Uniform growth keeps the triangle closed.
        let grow: Vec<f64> = set.initial_shape().iter().map(|l| 0.1 * l).collect();
        assert!(Reduction::new(&set, &constraints(&set, &state, &grow)).is_ok());
        let one = constraints(&set, &state, &[1.0, 0.0, 0.0]);
        assert!(
            matches!(
                Reduction::new(&set, &one),
                Err(RigidError::IncompatibleJoints { .. })
            ),
            "{arms:?}"
        );
    }
}
