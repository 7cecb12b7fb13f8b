//! Joints of all kinds: the formulations agree, balances hold, contradictions are refused.

use nalgebra::{DMatrix, DVector, Matrix6, Vector3};
use proptest::prelude::*;
use rigid::linalg::LinearOperator;
use rigid::{
    Arms, Articulation, BodyKind, Constrained, DirectRows, Eliminated, ExternalLoad, FlowSolution,
    Formulation, Joint, JointDrive, JointKind, Lagrange, PassiveDrive, RigidError, Twist,
};

use crate::support::sets::{
    centres, drive, loads_on_bodies, moved_state, random_fluid, slide, tree, values, vector,
};

/// The flow of a system by a dense factorisation, and the condition of its matrix.
fn flow(system: &Constrained, set: &Articulation) -> (FlowSolution, f64) {
    let size = system.rhs.len();
    let mut matrix = DMatrix::zeros(size, size);
    let mut unit = vec![0.0; size];
    for column in 0..size {
        unit[column] = 1.0;
        let mut product = vec![0.0; size];
        system.system.apply(&unit, &mut product);
        unit[column] = 0.0;
        matrix.set_column(column, &DVector::from_vec(product));
    }
    let rhs = DVector::from_column_slice(&system.rhs);
    let singular = matrix.singular_values();
    let solution = matrix.full_piv_lu().solve(&rhs).unwrap();
    let flow = system.flow(solution.as_slice(), set).unwrap();
    (flow, singular.max() / singular.min())
}

fn check_formulations(
    set: &Articulation,
    rotation: Vector3<f64>,
    rates: &[f64],
    loads: &[ExternalLoad],
    seed: &[f64],
) {
    let state = moved_state(set, &[rotation]);
    let values = values(set);
    let mut constraints = set
        .constraints(&state, &values, &rates[..set.joints().len()])
        .unwrap();
    for body in set.held_bodies().collect::<Vec<_>>() {
        let velocity = Twist {
            linear: Vector3::new(0.3, -0.2, 0.5),
            angular: Vector3::new(0.1, 0.4, -0.6),
        };
        constraints = constraints.with_held_velocity(body, velocity).unwrap();
    }
    // Masses over time steps, of some bodies.
    for body in (0..set.kinds().len()).filter(|body| set.kinds()[*body] == BodyKind::Rigid) {
        if seed[body] > 0.0 {
            let factor = Matrix6::from_fn(|i, j| seed[6 * i + j]);
            constraints
                .body_damping
                .push((body, factor * factor.transpose()));
        }
    }
    let centres = centres(set, &state, &values);
    let fluid = random_fluid(&centres, seed);
    let drive = drive(set, &constraints, loads);
    let formulations: [&dyn Formulation; 3] = [&Eliminated, &Lagrange, &DirectRows];
    let systems = formulations.map(|formulation| formulation.constrain(fluid.clone(), &drive));
    // A drive may turn a frame of free arms in which only held bodies are, which nothing resists.
    let is_unresisted =
        |system: &Result<_, _>| matches!(system, Err(RigidError::Unresisted { .. }));
    if set.held_bodies().next().is_some() && systems.iter().any(is_unresisted) {
        assert!(systems.iter().all(is_unresisted));
        return;
    }
    let flows = systems.map(|system| flow(&system.unwrap(), set));
    // The random matrices are not definite. Rounding errors of 60 dofs grow with the condition.
    let condition = flows
        .iter()
        .map(|(_, condition)| *condition)
        .fold(0.0, f64::max);
    let flows = flows.map(|(flow, _)| flow);
    let tolerance = |values: &DVector<f64>| 1e-14 * condition * (1.0 + values.amax());
    let velocity = tolerance(&flows[0].generalised);
    // Forces are products with matrices of entries up to 30.
    let force = 30.0 * velocity + tolerance(&flows[0].forces) + tolerance(&flows[0].joint_loads);
    for other in &flows[1..] {
        assert!((&other.generalised - &flows[0].generalised).amax() < velocity);
        assert!((&other.forces - &flows[0].forces).amax() < force);
        assert!((&other.joint_loads - &flows[0].joint_loads).amax() < force);
    }
    // Held bodies have the given velocities to the last bit where velocities are eliminated, and
    // loads that the balance below contains.
    let holding = flows[0].holding_loads();
    assert_eq!(holding.len(), set.held_bodies().count());
    let (forces, velocities) = (&flows[0].forces, &flows[0].generalised);
    let balancing = drive.holding_loads(forces, velocities).unwrap();
    assert_eq!(balancing.len(), holding.len());
    for ((body, load), (other, balancing)) in holding.iter().zip(&balancing) {
        assert_eq!(body, other);
        assert!((load.force - balancing.force).amax() < force);
        assert!((load.torque - balancing.torque).amax() < force);
    }
    let surfaces = set.surface_velocities();
    for (body, _) in &holding {
        let first = constraints.layout.bodies()[*body];
        let expected = [0.3, -0.2, 0.5, 0.1, 0.4, -0.6];
        assert_eq!(flows[0].generalised.as_slice()[first..first + 6], expected);
        assert!(surfaces.contains(&first));
    }
    let flow = &flows[0];
    let missed = &constraints.matrix * &flow.generalised - &constraints.rates;
    assert!(missed.amax() < velocity * constraints.matrix.amax());
    // The loads of the joints and of the drives balance the forces: also those on passive joints.
    let mut sum = constraints.matrix.tr_mul(&flow.joint_loads);
    sum += drive.generalised_loads().unwrap();
    sum -= drive.damping_times(&flow.generalised).unwrap();
    for (row, force) in set.surface_velocities().into_iter().zip(flow.forces.iter()) {
        sum[row] -= force;
    }
    assert!(sum.amax() < force * constraints.matrix.amax(), "{sum}");
    let balancing = drive.joint_loads(&flow.forces, &flow.generalised).unwrap();
    // A drive does the work of all rows of its joint; a passive joint has the force of its spring,
    // less that of its dashpot.
    let (mut power, mut passive) = (0.0, 0);
    for (joint, &rate) in rates[..set.joints().len()].iter().enumerate() {
        let load = flow.joint_load(joint).unwrap();
        let other = balancing[joint];
        let pairs = [(other.force, load.force), (other.torque, load.torque)];
        assert!(pairs.iter().all(|(a, b)| (a - b).amax() < force));
        assert!((other.drive - load.drive).abs() < force * constraints.matrix.amax());
        match constraints.layout.joint(joint) {
            None => power += load.drive * rate,
            Some(column) => {
                let damping = constraints.joint_damping[passive] * flow.generalised[column];
                let expected = constraints.joint_forces[passive] - damping;
                assert!((load.drive - expected).abs() < force * constraints.matrix.amax());
                passive += 1;
            }
        }
    }
    for (body, load) in &holding {
        let first = constraints.layout.bodies()[*body];
        let at = |first: usize| flow.generalised.fixed_rows::<3>(first).into_owned();
        power += load.force.dot(&at(first)) + load.torque.dot(&at(first + 3));
    }
    let work = flow.joint_loads.dot(&constraints.rates);
    assert!((power - work).abs() < 1e-13 * (1.0 + flow.joint_loads.norm()));
}

proptest! {
    #[test]
    fn formulations_agree_on_random_joint_trees(
        set in tree(),
        rotation in vector(1.0),
        rates in prop::collection::vec(-2.0..2.0, 6),
        vectors in prop::collection::vec(vector(1.0), 12),
        seed in prop::collection::vec(-1.0..1.0, 50),
    ) {
        let loads = loads_on_bodies(&set, &vectors);
        check_formulations(&set, rotation, &rates, &loads, &seed);
    }
}

proptest! {
    /// A body with joints whose velocity is given: the tethered swimmer.
    #[test]
    fn formulations_agree_where_a_linked_body_is_held(
        set in tree(),
        held in 0..6usize,
        rotation in vector(1.0),
        rates in prop::collection::vec(-2.0..2.0, 6),
        vectors in prop::collection::vec(vector(1.0), 12),
        seed in prop::collection::vec(-1.0..1.0, 50),
    ) {
        let rigid: Vec<usize> = (0..set.kinds().len())
            .filter(|&body| set.kinds()[body] == BodyKind::Rigid)
            .collect();
        prop_assume!(!rigid.is_empty());
        let held = rigid[held % rigid.len()];
        let set = set.with_held(&[held], &[held]).unwrap();
        prop_assert_eq!(set.linkages()[set.linkage_of()[held]].root, held);
        let loads = loads_on_bodies(&set, &vectors);
        check_formulations(&set, rotation, &rates, &loads, &seed);
    }
}

fn hinge(pivot: Vector3<f64>) -> JointKind {
    JointKind::Turn {
        axis: Vector3::z(),
        pivot,
        advance: 0.0,
    }
}

#[test]
fn a_hinge_turns_its_body_about_the_pivot() {
    let x = [Vector3::zeros(), 3.0 * Vector3::x(), 5.0 * Vector3::x()];
    let joints = vec![slide(1, 0).with_kind(hinge(Vector3::x())), slide(2, 1)];
    let set = Articulation::new(&[BodyKind::Rigid; 3], joints, Arms::Clamped, &x).unwrap();
    let angle = std::f64::consts::FRAC_PI_2;
    let poses = set.place(&set.initial_state(), &[angle, 4.0]).unwrap();
    // Body 1 is 2 from the pivot and turns from x to y; body 2 follows it at the new length 4.
    assert!((poses[1].translation.vector - Vector3::new(1.0, 2.0, 0.0)).norm() < 1e-14);
    assert!((poses[2].translation.vector - Vector3::new(1.0, 6.0, 0.0)).norm() < 1e-14);
    assert!((poses[2].rotation.scaled_axis() - angle * Vector3::<f64>::z()).norm() < 1e-14);
    assert!(poses[0].rotation.angle() == 0.0);
}

#[test]
fn a_screw_advances_by_its_rotation() {
    let x = [Vector3::zeros(), 3.0 * Vector3::x()];
    let screw = JointKind::Turn {
        axis: Vector3::x(),
        pivot: x[1],
        advance: 0.5,
    };
    let joints = vec![slide(1, 0).with_kind(screw)];
    let set = Articulation::new(&[BodyKind::Rigid; 2], joints, Arms::Clamped, &x).unwrap();
    let poses = set.place(&set.initial_state(), &[2.0]).unwrap();
    assert!((poses[1].translation.vector - 4.0 * Vector3::<f64>::x()).norm() < 1e-14);
    assert!((poses[1].rotation.scaled_axis() - 2.0 * Vector3::<f64>::x()).norm() < 1e-14);
}

#[test]
fn a_loop_of_hinges_closes_only_at_matching_angles() {
    // A parallelogram of four hinges: the angles are v, -v, v, -v.
    let x = [
        Vector3::zeros(),
        4.0 * Vector3::x(),
        Vector3::new(4.0, 3.0, 0.0),
        3.0 * Vector3::y(),
    ];
    let turning = |body: usize, to: usize| slide(body, to).with_kind(hinge(x[to]));
    let joints = vec![turning(1, 0), turning(2, 1), turning(3, 2), turning(0, 3)];
    let set = Articulation::new(&[BodyKind::Rigid; 4], joints, Arms::Clamped, &x).unwrap();
    let state = set.initial_state();
    let v = 0.3;
    assert!(set.place(&state, &[v, -v, v, -v]).is_ok());
    let open = set.place(&state, &[v, -v, v, v]);
    assert!(matches!(open, Err(RigidError::OpenLoop { .. })));
    let rates = |rates: [f64; 4]| {
        let constraints = set.constraints(&state, &[v, -v, v, -v], &rates).unwrap();
        rigid::Reduction::new(&set, &constraints).map(|reduction| reduction.dofs())
    };
    assert_eq!(rates([1.0, -1.0, 1.0, -1.0]), Ok(6));
    assert!(matches!(
        rates([1.0, -1.0, 1.0, 1.0]),
        Err(RigidError::IncompatibleJoints { .. })
    ));
}

#[test]
fn joints_that_do_not_fit_the_arms_are_refused() {
    let x = [Vector3::zeros(), 3.0 * Vector3::x()];
    let new = |joint, arms| {
        let joints = vec![slide(1, 0).with_kind(joint)];
        Articulation::new(&[BodyKind::Rigid; 2], joints, arms, &x)
    };
    let ball = JointKind::Ball { pivot: x[0] };
    assert!(new(ball, Arms::Clamped).is_ok());
    for (joint, arms) in [
        (hinge(x[0]), Arms::Lab),
        (ball, Arms::Lab),
        (ball, Arms::Free),
        (
            JointKind::Turn {
                axis: 2.0 * Vector3::x(),
                pivot: x[0],
                advance: 0.0,
            },
            Arms::Clamped,
        ),
    ] {
        let refused = new(joint, arms);
        assert!(
            matches!(refused, Err(RigidError::BadJoint { .. })),
            "{joint:?}"
        );
    }
    let drive = JointDrive::Passive(PassiveDrive {
        stiffness: -1.0,
        ..PassiveDrive::default()
    });
    let joints = vec![Joint::slide("spring", 1, 0).with_drive(drive)];
    let refused = Articulation::new(&[BodyKind::Rigid; 2], joints, Arms::Clamped, &x);
    assert!(matches!(refused, Err(RigidError::BadJoint { .. })));
}

#[test]
fn a_force_on_a_joint_that_moves_no_surface_is_refused() {
    let x = [Vector3::zeros(), 5.0 * Vector3::x(), 3.0 * Vector3::y()];
    let kinds = [BodyKind::Rigid, BodyKind::Rigid, BodyKind::Point];
    let at_force = |force| {
        let passive = JointDrive::Passive(PassiveDrive {
            force,
            ..PassiveDrive::default()
        });
        let joints = vec![slide(1, 0), slide(2, 0).with_drive(passive)];
        let set = Articulation::new(&kinds, joints, Arms::Clamped, &x).unwrap();
        let shape = set.initial_shape().to_vec();
        let constraints = set.constraints(&set.initial_state(), &shape, &[0.0; 2]);
        let constraints = constraints.unwrap();
        let loads = [ExternalLoad::default(); 3];
        let drive = drive(&set, &constraints, &loads);
        let fluid = random_fluid(&x[..2], &[0.3, -0.1, 0.7]);
        Eliminated.constrain(fluid, &drive).map(drop)
    };
    assert_eq!(at_force(0.0), Ok(()));
    assert!(matches!(at_force(2.0), Err(RigidError::Unresisted { .. })));
}
