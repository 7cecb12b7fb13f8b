//! Several rates of the joints are several right-hand sides of one system.

use nalgebra::Vector3;
use proptest::prelude::*;
use rigid::{
    Arms, Articulation, BodyKind, Constrained, DirectRows, Eliminated, ExternalLoad, Formulation,
    Independent, Joint, Lagrange, RigidError,
};

use crate::support::sets::{
    centres, constraints, drive, loads_on_bodies, moved_state, random_fluid, tree, values, vector,
};

/// Compares a system at the second of two rates with a system that was built with it.
fn check_rates(
    set: &Articulation,
    rotation: Vector3<f64>,
    rates: &[f64],
    loads: &[ExternalLoad],
    seed: &[f64],
) {
    let joints = set.joints().len();
    let state = moved_state(set, &[rotation]);
    let [first, second] = [&rates[..joints], &rates[6..6 + joints]]
        .map(|rates| set.constraints(&state, &values(set), rates).unwrap());
    let centres = centres(set, &state, &values(set));
    let fluid = random_fluid(&centres, seed);
    let formulations: [&dyn Formulation; 3] = [&Eliminated, &Lagrange, &DirectRows];
    for formulation in formulations {
        let [system, direct] = [&first, &second].map(|c| {
            formulation
                .constrain(fluid.clone(), &drive(set, c, loads))
                .unwrap()
        });
        let imposed = system.imposed(&drive(set, &second, loads)).unwrap();
        assert_eq!(imposed.rhs, direct.rhs);
        // Any vector is the solution for some right-hand side.
        let solution: Vec<f64> = (0..direct.rhs.len()).map(|i| seed[(i * 7) % 50]).collect();
        let [a, b] = [
            system.flow_at(&solution, &imposed, set).unwrap(),
            direct.flow(&solution, set).unwrap(),
        ];
        assert_eq!(
            [a.generalised, a.bodies, a.forces, a.joint_loads],
            [b.generalised, b.bodies, b.forces, b.joint_loads]
        );
        assert_eq!(a.velocity, b.velocity);
        let bare = direct.clone().without_matrices().unwrap();
        let forces = |system: &Constrained| system.flow(&solution, set).unwrap().forces;
        assert_eq!(forces(&bare), forces(&direct));
        let (velocity, pressure) = direct.flow_of_loads(&solution).unwrap();
        assert_eq!(
            bare.rhs_of_forces(&velocity, &pressure).unwrap(),
            direct.rhs_of_forces(&velocity, &pressure).unwrap()
        );
        // Other loads have other joint loads, other values another matrix.
        let mut other_loads = loads.to_vec();
        other_loads[0].force.x += 1.0;
        let refused = system.imposed(&drive(set, &second, &other_loads)).err();
        assert_eq!(refused, Some(RigidError::OtherJoints));
        let longer: Vec<f64> = values(set).iter().map(|l| 1.1 * l).collect();
        let longer = set.constraints(&state, &longer, &rates[..joints]).unwrap();
        let has_other_values = |joint: &Joint| joint.kind.has_value() && !joint.is_passive();
        if set.joints().iter().any(has_other_values) {
            let refused = system.imposed(&drive(set, &longer, loads)).err();
            assert_eq!(refused, Some(RigidError::OtherJoints), "{:?}", set.arms());
        }
    }
}

proptest! {
    #[test]
    fn other_rates_are_another_right_hand_side_of_the_same_system(
        set in tree(),
        rotation in vector(1.0),
        rates in prop::collection::vec(-2.0..2.0, 12),
        vectors in prop::collection::vec(vector(1.0), 12),
        seed in prop::collection::vec(-1.0..1.0, 50),
    ) {
        let loads = loads_on_bodies(&set, &vectors);
        check_rates(&set, rotation, &rates, &loads, &seed);
    }
}

#[test]
fn independent_bodies_have_no_rates() {
    let x = [Vector3::zeros(), 5.0 * Vector3::x()];
    let set = Articulation::new(&[BodyKind::Rigid; 2], vec![], Arms::Clamped, &x).unwrap();
    let constraints = constraints(&set, &set.initial_state(), &[]);
    let loads = [ExternalLoad::default(); 2];
    let drive = drive(&set, &constraints, &loads);
    let fluid = random_fluid(&x, &[0.3, -0.1, 0.7]);
    let system = Independent.constrain(fluid, &drive).unwrap();
    assert_eq!(system.imposed(&drive).err(), Some(RigidError::OtherJoints));
}
