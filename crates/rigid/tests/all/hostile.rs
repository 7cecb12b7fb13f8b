//! Every public function on hostile arguments: a right answer or an error, never a panic.

use std::cell::Cell;

use nalgebra::{DMatrix, DVector, Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use rigid::linalg::Csr;
use rigid::{
    Arms, Articulation, BodyKind, DirectRows, Eliminated, ExternalLoad, FluidMatrices, FluidNodes,
    Formulation, GrandResistance, Independent, Joint, JointKind, Lagrange, NodeRole, NullSpace,
    Reduction, RigidError, RigidFluid, State, StateVelocity, SurfaceBody, SymmetryPlanes, Twist,
};

use crate::support::sets::{
    arms, constraints, drive, drive_with, fluid_matrices, random_fluid, slide,
};

const FORMULATIONS: [&dyn Formulation; 4] = [&Independent, &Eliminated, &Lagrange, &DirectRows];

/// Number of random cases: about 35 fluids and 80 sets of them are answered.
const CASES: u32 = 8192;

/// Smallest number of answers; fewer than 5 of 35 expected ones have a probability of 1e-9.
const MIN_ANSWERS: u32 = 5;

fn number() -> impl Strategy<Value = f64> {
    let hostile = [
        0.0,
        -1.0,
        5e-324,
        1e-300,
        1e300,
        f64::MAX,
        f64::NAN,
        f64::INFINITY,
    ];
    prop_oneof![12 => -9.0..9.0, 1 => proptest::sample::select(hostile.to_vec())]
}

fn vector() -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(number()).prop_map(Vector3::from)
}

fn index() -> impl Strategy<Value = usize> {
    prop_oneof![9 => 0..4usize, 1 => Just(usize::MAX)]
}

fn joint_kind() -> impl Strategy<Value = JointKind> {
    prop_oneof![
        2 => Just(JointKind::Slide),
        1 => Just(JointKind::Fixed),
        1 => vector().prop_map(|pivot| JointKind::Ball { pivot }),
        1 => (vector(), number()).prop_map(|(pivot, advance)| {
            JointKind::Turn { axis: Vector3::z(), pivot, advance }
        }),
        1 => (vector(), vector(), number()).prop_map(|(axis, pivot, advance)| {
            JointKind::Turn { axis, pivot, advance }
        }),
    ]
}

fn kind() -> impl Strategy<Value = BodyKind> {
    prop_oneof![4 => Just(BodyKind::Rigid), 1 => Just(BodyKind::Point)]
}

/// A state with frames and attitudes, some of which are no rotations.
fn state() -> impl Strategy<Value = State> {
    let rotation = || {
        prop_oneof![
            4 => prop::array::uniform3(-9.0..9.0)
                .prop_map(|v| UnitQuaternion::from_scaled_axis(Vector3::from(v))),
            1 => prop::array::uniform4(number())
                .prop_map(|[w, i, j, k]| UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k))),
        ]
    };
    let frame =
        (vector(), rotation()).prop_map(|(x, q)| Isometry3::from_parts(Translation3::from(x), q));
    let frames = prop::collection::vec(frame, 0..4);
    let attitudes = prop::collection::vec(rotation(), 0..4);
    let joints = prop::collection::vec(number(), 0..3);
    (frames, attitudes, joints).prop_map(|(frames, attitudes, joints)| State {
        frames,
        attitudes,
        joints,
    })
}

fn is_finite(numbers: &[f64]) -> bool {
    numbers.iter().all(|x| x.is_finite())
}

/// Calls `check` with random arguments; it returns whether they were answered to the end.
///
/// A few in a thousand are; a test in which all were refused would check nothing.
fn answer_or_refuse<S: Strategy>(
    arguments: S,
    check: impl Fn(S::Value) -> Result<bool, TestCaseError>,
) {
    let answered = Cell::new(0);
    let config = ProptestConfig {
        source_file: Some(file!()),
        ..ProptestConfig::with_cases(CASES)
    };
    let all = TestRunner::new(config).run(&arguments, |arguments| {
        answered.set(answered.get() + u32::from(check(arguments)?));
        Ok(())
    });
    all.unwrap();
    assert!(answered.get() >= MIN_ANSWERS, "{}", answered.get());
}

#[test]
fn sets_with_hostile_numbers_answer_or_refuse() {
    let arguments = (
        prop::collection::vec(kind(), 0..4),
        prop::collection::vec((index(), index()), 0..4),
        (arms(), state()),
        prop::collection::vec(
            (
                joint_kind(),
                drive_with((number(), number(), number(), number())),
            ),
            4,
        ),
        prop::collection::vec(vector(), 0..4),
        prop::collection::vec(index(), 0..2),
        prop::array::uniform4(prop::collection::vec(number(), 0..4)),
        prop::collection::vec((vector(), vector()), 0..4),
        prop::collection::vec(number(), 0..24),
    );
    answer_or_refuse(
        arguments,
        |(kinds, ends, (arms, state), joints, positions, fixed, lists, loads, q)| {
            let joints: Vec<Joint> = ends
                .iter()
                .zip(joints)
                .map(|(&(body, to), (joint, drive))| {
                    Joint::slide("arm", body, to)
                        .with_kind(joint)
                        .with_drive(drive)
                })
                .collect();
            let set = Articulation::new(&kinds, joints, arms, &positions)
                .and_then(|set| set.with_held(&fixed, &fixed));
            let Ok(set) = set else { return Ok(false) };
            prop_assert!(is_finite(set.initial_shape()));
            let layout = set.velocity_layout();
            prop_assert_eq!(layout.body(kinds.len()), None);
            prop_assert_eq!(layout.frame(usize::MAX), None);
            let initial = set.initial_state();
            for state in [&state, &initial] {
                for shape in [&lists[0][..], set.initial_shape()] {
                    let directions = set.directions(state, shape);
                    prop_assert_eq!(directions.is_ok(), set.place(state, shape).is_ok());
                    if let Ok(poses) = set.place(state, shape) {
                        prop_assert!(
                            poses
                                .iter()
                                .all(|p| is_finite(p.to_homogeneous().as_slice()))
                        );
                    }
                }
                let twists = q
                    .as_chunks::<6>()
                    .0
                    .iter()
                    .map(|&[a, b, c, d, e, f]| Twist {
                        linear: Vector3::new(a, b, c),
                        angular: Vector3::new(d, e, f),
                    });
                let step = StateVelocity {
                    frames: twists.collect(),
                    spins: loads.iter().map(|load| load.1).collect(),
                    joints: lists[3].clone(),
                };
                let _ = &step + &(&step * f64::NAN);
                if let Ok(next) = set.advance(state, &step) {
                    let poses = next.frames.iter().map(|frame| frame.to_homogeneous());
                    prop_assert!(poses.into_iter().all(|pose| is_finite(pose.as_slice())));
                }
            }
            let _ = set.state_velocity(&q);
            let rates = if lists[1].len() == set.joints().len() {
                &lists[1]
            } else {
                &lists[2]
            };
            let Ok(constraints) = set.constraints(&initial, set.initial_shape(), rates) else {
                return Ok(false);
            };
            let masters: Vec<bool> = q.iter().map(|x| *x > 0.0).collect();
            let _ = NullSpace::new(&constraints, &masters);
            if let Ok(reduction) = Reduction::new(&set, &constraints) {
                let v = DVector::from_column_slice(&lists[3]);
                prop_assert_eq!(
                    reduction.velocities(&v).is_ok(),
                    v.len() == reduction.dofs()
                );
            }
            let loads: Vec<ExternalLoad> = loads
                .iter()
                .map(|&(force, torque)| ExternalLoad { force, torque })
                .collect();
            let drive = drive(&set, &constraints, &loads);
            if let Ok(loads) = drive.generalised_loads() {
                prop_assert!(is_finite(loads.as_slice()));
            }
            let q = DVector::from_column_slice(&q);
            let _ = drive.joint_loads(&q, &q);
            Ok(true)
        },
    );
}

#[test]
fn fluids_with_hostile_numbers_answer_or_refuse() {
    let arguments = (
        prop::collection::vec(vector(), 6),
        prop::collection::vec(
            prop_oneof![
                4 => Just(NodeRole::Free),
                2 => Just(NodeRole::Fixed),
                3 => (0..3u32).prop_map(NodeRole::Body),
            ],
            5..7,
        ),
        prop::collection::vec((0..9u32, any::<[bool; 3]>()), 0..3),
        prop::option::of(prop::collection::vec(vector(), 5..7)),
        prop::collection::vec((vector(), number()), 0..3),
        (prop::collection::vec(number(), 50), 0..12usize),
    );
    answer_or_refuse(
        arguments,
        |(points, roles, planes, walls, bodies, (seed, at))| {
            let mut answers = false;
            let mut matrices: FluidMatrices = fluid_matrices(3, 6, &seed);
            match at {
                0 => matrices.stiffness = Csr::eye(5),
                1 => matrices.interpolation = Csr::eye(6),
                2 => matrices.vertex_stiffness = Csr::eye(4),
                3 => matrices.pressure_mass = Csr::eye(2),
                4 => matrices.stiffness = matrices.stiffness.to_csc(),
                5 => matrices.divergence = matrices.divergence.to_csc(),
                _ => {}
            }
            let mut nodes = FluidNodes::new(&points, &roles);
            if let Some(walls) = &walls {
                nodes = nodes.with_wall_velocity(walls);
            }
            if at > 8 {
                nodes = nodes.with_symmetry_planes(planes);
            }
            let surfaces: Vec<SurfaceBody> = bodies
                .iter()
                .map(|&(centre, volume)| SurfaceBody { centre, volume })
                .collect();
            let Ok(fluid) = RigidFluid::new(matrices, nodes, &surfaces) else {
                return Ok(false);
            };
            prop_assert!(fluid.bodies() == bodies.len());
            let _ = (
                fluid.symmetry_planes().parts(),
                fluid.clone().with_pressure_stiffness(Csr::eye(at)),
            );
            let centres: Vec<_> = bodies.iter().map(|(centre, _)| *centre).collect();
            let kinds = vec![BodyKind::Rigid; centres.len()];
            let Ok(set) = Articulation::new(&kinds, Vec::new(), Arms::Free, &centres) else {
                return Ok(false);
            };
            let constraints = constraints(&set, &set.initial_state(), &[]);
            let loads = vec![ExternalLoad::default(); centres.len()];
            let drive = drive(&set, &constraints, &loads);
            for formulation in FORMULATIONS {
                let Ok(system) = formulation.constrain(fluid.clone(), &drive) else {
                    continue;
                };
                answers = true;
                let _ = system.preconditioner();
                let _ = system.imposed(&drive);
                let _ = system.rhs_of_loads(&DVector::from_column_slice(&seed[..at]));
                let _ = system.rhs_of_forces(&points, &seed[..at]);
                for length in [at, system.rhs.len()] {
                    let x = DVector::from_fn(length, |i, _| seed[i % seed.len()]);
                    let _ = system.flow(x.as_slice(), &set);
                    let _ = system.generalised_of_loads(x.as_slice());
                    let _ = system.flow_of_loads(x.as_slice());
                }
                let solved = GrandResistance::new(&system, at, |_, x| {
                    x.iter_mut().for_each(|x| x.fill(seed[0]));
                    Ok::<(), RigidError>(())
                });
                if let Ok(grand) = solved {
                    prop_assert!(is_finite(grand.resistance.as_slice()));
                }
            }
            Ok(answers)
        },
    );
}

/// Two linked bodies with their fluid, in one formulation.
fn linked_pair(distance: f64) -> (Articulation, [Vector3<f64>; 2]) {
    let x = [Vector3::zeros(), distance * Vector3::x()];
    let set = Articulation::new(&[BodyKind::Rigid; 2], vec![slide(1, 0)], Arms::Clamped, &x);
    (set.unwrap(), x)
}

const SEED: [f64; 3] = [0.3, -0.1, 0.7];

#[test]
fn bug_surfaces_at_other_places_than_their_bodies_were_accepted() {
    let (set, x) = linked_pair(5.0);
    let constraints = constraints(&set, &set.initial_state(), &[1.0]);
    let loads = [ExternalLoad::default(); 2];
    let drive = drive(&set, &constraints, &loads);
    for formulation in &FORMULATIONS[1..] {
        let constrain = |centres: &[Vector3<f64>]| {
            let system = formulation.constrain(random_fluid(centres, &SEED), &drive);
            system.map(|_| ())
        };
        assert!(constrain(&x).is_ok());
        // rounding, as of a mesh that was moved
        assert!(constrain(&[x[0], x[1] + Vector3::repeat(1e-12)]).is_ok());
        let misplaced = Err(RigidError::Misplaced {
            body: 1,
            distance: 1.0,
        });
        assert_eq!(constrain(&[x[0], 4.0 * Vector3::x()]), misplaced);
        let swapped = Err(RigidError::Misplaced {
            body: 0,
            distance: 5.0,
        });
        assert_eq!(constrain(&[x[1], x[0]]), swapped);
    }
}

#[test]
fn bug_bodies_without_a_positive_volume_were_accepted() {
    for volume in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let points = [Vector3::zeros(); 6];
        let nodes = FluidNodes::new(&points, &[NodeRole::Free; 6]);
        let body = SurfaceBody {
            centre: Vector3::zeros(),
            volume,
        };
        let refused = RigidFluid::new(fluid_matrices(3, 6, &SEED), nodes, &[body]).map(|_| ());
        assert!(matches!(
            refused,
            Err(RigidError::BadVolume { body: 0, .. })
        ));
    }
}

#[test]
fn bug_the_force_of_a_joint_that_does_not_exist_ended_the_program() {
    let (set, x) = linked_pair(5.0);
    let constraints = constraints(&set, &set.initial_state(), &[1.0]);
    let loads = [ExternalLoad::default(); 2];
    let drive = drive(&set, &constraints, &loads);
    let system = Eliminated
        .constrain(random_fluid(&x, &SEED), &drive)
        .unwrap();
    let flow = system.flow(&system.rhs, &set).unwrap();
    assert!(flow.joint_load(0).is_ok());
    // rows 3 to 5 are the torque of a clamp
    for joint in [1, 9, usize::MAX] {
        assert_eq!(
            flow.joint_load(joint),
            Err(RigidError::NoSuchJoint { joint, joints: 1 })
        );
    }
}

#[test]
fn constraints_of_another_set_or_with_changed_fields_are_refused() {
    let (set, x) = linked_pair(5.0);
    let free = Articulation::new(&[BodyKind::Rigid; 2], vec![], Arms::Free, &x).unwrap();
    let others = constraints(&free, &free.initial_state(), &[]);
    assert_eq!(
        Reduction::new(&set, &others).map(|_| ()),
        Err(RigidError::OtherSet)
    );
    let own = constraints(&set, &set.initial_state(), &[1.0]);
    for change in 0..4 {
        let mut changed = own.clone();
        match change {
            0 => changed.labels.truncate(1),
            1 => changed.rates = DVector::zeros(1),
            2 => changed.matrix = DMatrix::zeros(2, 2),
            _ => changed.rates[0] = f64::NAN,
        }
        assert!(Reduction::new(&set, &changed).is_err(), "{change}");
        assert!(NullSpace::new(&changed, &[]).is_err(), "{change}");
        let loads = [ExternalLoad::default(); 2];
        let drive = drive(&set, &changed, &loads);
        for formulation in FORMULATIONS {
            let system = formulation.constrain(random_fluid(&x, &SEED), &drive);
            assert!(system.is_err(), "{change}");
        }
    }
    assert_eq!(SymmetryPlanes::from_nodes(&[]), SymmetryPlanes::default());
}
