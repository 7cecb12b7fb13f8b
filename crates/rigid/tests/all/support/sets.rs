//! Random and simple articulated sets, and a fluid with random matrices.

use linalg::{Csr, Csr3};
use nalgebra::{DMatrix, Isometry3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use rigid::{
    Arms, Articulation, BodyKind, Constraints, Drive, ExternalLoad, FluidMatrices, FluidNodes,
    Joint, JointDrive, JointKind, NodeRole, PassiveDrive, RigidFluid, State, SurfaceBody,
};

pub fn slide(body: usize, to: usize) -> Joint {
    Joint::slide(&format!("{body}-{to}"), body, to)
}

pub fn vector(range: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-range..range).prop_map(Vector3::from)
}

pub fn arms() -> impl Strategy<Value = Arms> {
    prop_oneof![Just(Arms::Clamped), Just(Arms::Free), Just(Arms::Lab)]
}

/// Any joint about an axis or pivot within the range of the bodies of [`tree`].
fn joint_kind() -> impl Strategy<Value = JointKind> {
    let pivot = || vector(5.0);
    let axis = vector(1.0).prop_filter_map("no direction", |v| v.try_normalize(0.1));
    prop_oneof![
        4 => Just(JointKind::Slide),
        1 => Just(JointKind::Fixed),
        3 => (axis, pivot(), prop_oneof![Just(0.0), -1.0..1.0])
            .prop_map(|(axis, pivot, advance)| JointKind::Turn { axis, pivot, advance }),
        1 => pivot().prop_map(|pivot| JointKind::Ball { pivot }),
    ]
}

fn joint_drive() -> impl Strategy<Value = JointDrive> {
    let damping = prop_oneof![Just(0.0), 0.0..2.0];
    drive_with((-1.0..1.0, 0.0..2.0, -1.0..1.0, damping))
}

/// A prescribed joint, or a passive one with such a force, stiffness, rest value and damping.
pub fn drive_with(
    numbers: impl Strategy<Value = (f64, f64, f64, f64)>,
) -> impl Strategy<Value = JointDrive> {
    let passive = numbers.prop_map(|(force, stiffness, rest, damping)| {
        JointDrive::Passive(PassiveDrive {
            force,
            stiffness,
            rest,
            damping,
        })
    });
    prop_oneof![2 => Just(JointDrive::Prescribed), 1 => passive]
}

/// A random tree of 2 to 6 bodies, some of them points, at random positions, with any joints that
/// the arms allow.
pub fn tree() -> impl Strategy<Value = Articulation> {
    (2usize..7).prop_flat_map(|n| {
        let parents: Vec<_> = (1..n).map(|child| 0..child).collect();
        (
            parents,
            prop::collection::vec(vector(5.0), n),
            prop::collection::vec(any::<bool>(), n),
            arms(),
            prop::collection::vec((joint_kind(), joint_drive()), n),
        )
            .prop_filter_map(
                "bodies too close",
                |(parents, jitter, points, arms, joints)| {
                    // The bodies are far enough apart that no two coincide.
                    let positions: Vec<_> = jitter
                        .iter()
                        .enumerate()
                        .map(|(i, x)| x + Vector3::new(20.0 * i as f64, 0.0, 0.0))
                        .collect();
                    // At least two bodies have a surface: rotations about any axis are resisted.
                    let kinds: Vec<_> = points
                        .iter()
                        .enumerate()
                        .map(|(i, &p)| {
                            if p && i > 1 {
                                BodyKind::Point
                            } else {
                                BodyKind::Rigid
                            }
                        })
                        .collect();
                    let joints = parents
                        .iter()
                        .enumerate()
                        .zip(joints)
                        .map(|((i, &to), (kind, drive))| {
                            let is_allowed = match arms {
                                Arms::Clamped => true,
                                Arms::Free => !matches!(kind, JointKind::Ball { .. }),
                                Arms::Lab => !kind.turns(),
                            };
                            let joint = Joint::slide(&format!("arm {i}"), i + 1, to);
                            // Nothing would resist the motion of a point at the end of a joint.
                            if kinds[i + 1] == BodyKind::Point {
                                return joint;
                            }
                            joint
                                .with_kind(if is_allowed { kind } else { JointKind::Slide })
                                .with_drive(drive)
                        })
                        .collect();
                    Articulation::new(&kinds, joints, arms, &positions).ok()
                },
            )
    })
}

/// The initial state with its first frames translated and rotated.
pub fn moved_state(set: &Articulation, rotations: &[Vector3<f64>]) -> State {
    let mut state = set.initial_state();
    for value in &mut state.joints {
        *value += 0.3;
    }
    for (frame, rotation) in state.frames.iter_mut().zip(rotations) {
        *frame = Isometry3::from_parts(
            Translation3::from(frame.translation.vector + rotation),
            UnitQuaternion::from_scaled_axis(*rotation),
        );
    }
    state
}

/// Values of the joints away from those at the start.
pub fn values(set: &Articulation) -> Vec<f64> {
    set.initial_shape().iter().map(|l| l + 0.4).collect()
}

/// Centres of the bodies with surfaces.
pub fn centres(set: &Articulation, state: &State, values: &[f64]) -> Vec<Vector3<f64>> {
    let poses = set.place(state, values).unwrap();
    let rigid = poses.iter().zip(set.kinds());
    rigid
        .filter(|(_, kind)| **kind == BodyKind::Rigid)
        .map(|(pose, _)| pose.translation.vector)
        .collect()
}

/// Forces and torques on the bodies with surfaces, from twelve vectors.
///
/// A load on a point may act on a rotation of free arms that nothing resists.
pub fn loads_on_bodies(set: &Articulation, vectors: &[Vector3<f64>]) -> Vec<ExternalLoad> {
    let load = |(body, kind): (usize, &BodyKind)| match kind {
        BodyKind::Rigid => ExternalLoad {
            force: vectors[body],
            torque: vectors[body + 5],
        },
        BodyKind::Point => ExternalLoad::default(),
    };
    set.kinds().iter().enumerate().map(load).collect()
}

/// The constraints at the values at the start.
pub fn constraints(set: &Articulation, state: &State, rates: &[f64]) -> Constraints {
    set.constraints(state, set.initial_shape(), rates).unwrap()
}

/// The drive of a set under loads, by its constraints.
pub fn drive<'a>(
    set: &'a Articulation,
    constraints: &'a Constraints,
    loads: &'a [ExternalLoad],
) -> Drive<'a> {
    Drive {
        set,
        constraints,
        loads,
    }
}

/// A fluid with random matrices: three free nodes, one on a moving wall, one on each body.
///
/// The surfaces of the bodies have the given centres.
pub fn random_fluid(centres: &[Vector3<f64>], seed: &[f64]) -> RigidFluid {
    let bodies = centres.len();
    let (vertices, nodes) = (3, 4 + bodies);
    let entry = |i: usize, j: usize| seed[(11 * i + 5 * j) % seed.len()];
    let roles: Vec<NodeRole> = (0..nodes)
        .map(|node| match node {
            0..3 => NodeRole::Free,
            3 => NodeRole::Fixed,
            body => NodeRole::Body(body as u32 - 4),
        })
        .collect();
    let points: Vec<Vector3<f64>> = (0..nodes)
        .map(|i| Vector3::from_fn(|axis, _| entry(i, axis)))
        .collect();
    let volume = 1.0;
    let surfaces: Vec<SurfaceBody> = (centres.iter())
        .map(|&centre| SurfaceBody { centre, volume })
        .collect();
    let matrices = fluid_matrices(vertices, nodes, seed);
    let nodes = FluidNodes::new(&points, &roles).with_wall_velocity(&points);
    RigidFluid::new(matrices, nodes, &surfaces).unwrap()
}

/// Matrices of random numbers, with a stiffness whose diagonal is larger than the sum of the other
/// entries of its row.
pub fn fluid_matrices(vertices: usize, nodes: usize, seed: &[f64]) -> FluidMatrices {
    let entry = |i: usize, j: usize| seed[(11 * i + 5 * j) % seed.len()];
    let stiffness = DMatrix::from_fn(nodes, nodes, |i, j| match i == j {
        true => 2.0 * nodes as f64,
        false => entry(i, j) + entry(j, i),
    });
    let interpolation = DMatrix::from_fn(nodes, vertices, |i, j| match i < vertices {
        true => f64::from(i == j),
        false => 1.0 / vertices as f64,
    });
    let divergence = Csr3::new(
        (vertices, nodes),
        (0..=vertices).map(|row| row * nodes).collect(),
        (0..vertices).flat_map(|_| 0..nodes as u32).collect(),
        (0..vertices * nodes)
            .map(|k| std::array::from_fn(|axis| entry(k, axis)))
            .collect(),
    );
    FluidMatrices {
        stiffness: csr(&stiffness),
        divergence,
        pressure_mass: csr(&DMatrix::identity(vertices, vertices)),
        interpolation: csr(&interpolation),
        vertex_stiffness: csr(&DMatrix::identity(vertices, vertices)),
    }
}

fn csr(dense: &DMatrix<f64>) -> Csr {
    let (mut pointers, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
    for row in dense.row_iter() {
        for (j, &v) in row.iter().enumerate().filter(|e| *e.1 != 0.0) {
            indices.push(j as u32);
            values.push(v);
        }
        pointers.push(indices.len());
    }
    Csr::new(dense.shape(), pointers, indices, values)
}
