//! Invariants of joint graphs, null spaces and the rigid border, on random inputs.

use nalgebra::{DMatrix, DVector, Isometry3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use rigid::{
    Arms, Articulation, BodyKind, Constraints, DirectRows, Drive, Eliminated, ExternalLoad,
    FluidMatrices, Formulation, Independent, Lagrange, Link, NodeRole, Reduction, RigidError,
    RigidFluid, State, SurfaceBody,
};

fn arms() -> impl Strategy<Value = Arms> {
    prop_oneof![Just(Arms::Clamped), Just(Arms::Free), Just(Arms::Lab)]
}

fn vector(range: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-range..range).prop_map(Vector3::from)
}

/// A random tree of 2..7 bodies, some of them points, at random places.
fn tree() -> impl Strategy<Value = Articulation> {
    (2usize..7).prop_flat_map(|n| {
        let parents: Vec<_> = (1..n).map(|child| 0..child).collect();
        (
            parents,
            prop::collection::vec(vector(5.0), n),
            prop::collection::vec(any::<bool>(), n),
            arms(),
        )
            .prop_filter_map("bodies too close", |(parents, jitter, points, arms)| {
                // Spread the bodies so that no two coincide.
                let positions: Vec<_> = jitter
                    .iter()
                    .enumerate()
                    .map(|(i, x)| x + Vector3::new(20.0 * i as f64, 0.0, 0.0))
                    .collect();
                // Two bodies with a surface at least, so that something meets resistance off any axis.
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
                let links = parents
                    .iter()
                    .enumerate()
                    .map(|(i, &to)| Link {
                        name: format!("arm {i}"),
                        body: i + 1,
                        to,
                    })
                    .collect();
                Articulation::new(&kinds, links, arms, &positions).ok()
            })
    })
}

fn scattered_state(set: &Articulation, seed: &[Vector3<f64>]) -> State {
    let mut state = set.initial_state();
    for (frame, turn) in state.frames.iter_mut().zip(seed) {
        *frame = Isometry3::from_parts(
            Translation3::from(frame.translation.vector + turn),
            UnitQuaternion::from_scaled_axis(*turn),
        );
    }
    state
}

fn constraints(set: &Articulation, state: &State, rates: &[f64]) -> Constraints {
    set.constraints(state, set.initial_lengths(), rates)
        .unwrap()
}

proptest! {
    #[test]
    fn eliminated_velocities_satisfy_every_constraint(
        set in tree(), turn in vector(1.0), rates in prop::collection::vec(-2.0..2.0, 6), v in prop::collection::vec(-1.0..1.0, 42),
    ) {
        let state = scattered_state(&set, &[turn]);
        let c = constraints(&set, &state, &rates[..set.links().len()]);
        let reduction = Reduction::of(&set, &c).unwrap();
        let q = reduction.velocities(&DVector::from_column_slice(&v[..reduction.dofs()]));
        // Arms are up to about 130 long and the elimination runs over at most 6 of them.
        prop_assert!((&c.matrix * &q - &c.rates).amax() < 1e-10 * (1.0 + q.amax()) * c.matrix.amax());
        let singular = reduction.surface_basis.singular_values();
        prop_assert!(singular.min() > 1e-9 * singular.max());
    }

    #[test]
    fn poses_move_with_the_velocities_of_the_bodies(
        set in tree(), turn in vector(1.0), rates in prop::collection::vec(-2.0..2.0, 6), v in prop::collection::vec(-1.0..1.0, 42),
    ) {
        let rates = &rates[..set.links().len()];
        let state = scattered_state(&set, &[turn]);
        let c = constraints(&set, &state, rates);
        let reduction = Reduction::of(&set, &c).unwrap();
        let q = reduction.velocities(&DVector::from_column_slice(&v[..reduction.dofs()]));
        let velocity = set.state_velocity(q.as_slice()).unwrap();
        let dt = 1e-5;
        let pose_at = |dt: f64| {
            let lengths: Vec<f64> = set.initial_lengths().iter().zip(rates).map(|(l, r)| l + dt * r).collect();
            set.place(&set.advance(&state, &(&velocity * dt)).unwrap(), &lengths).unwrap()
        };
        for (body, (after, before)) in pose_at(dt).iter().zip(pose_at(-dt)).enumerate() {
            let first = c.layout.body(body);
            let moved = (after.translation.vector - before.translation.vector) / (2.0 * dt);
            // Central differences: error dt^2 |Omega|^3 l / 6 and rounding 1e-16 l / dt, arms up to 130.
            prop_assert!((moved - q.fixed_rows::<3>(first)).amax() < 1e-6);
            if set.kinds()[body] == BodyKind::Rigid {
                let spin = (after.rotation * before.rotation.inverse()).scaled_axis() / (2.0 * dt);
                prop_assert!((spin - q.fixed_rows::<3>(first + 3)).amax() < 1e-6);
            }
        }
    }

    #[test]
    fn other_rates_are_another_right_hand_side_of_the_same_system(
        set in tree(), turn in vector(1.0), rates in prop::collection::vec(-2.0..2.0, 12), pulls in prop::collection::vec(vector(1.0), 12),
        seed in prop::collection::vec(-1.0..1.0, 50),
    ) {
        let links = set.links().len();
        let state = scattered_state(&set, &[turn]);
        let loads: Vec<ExternalLoad> = (0..set.kinds().len()).map(|body| ExternalLoad { force: pulls[body], torque: pulls[body + 5] }).collect();
        let [first, other] = [&rates[..links], &rates[6..6 + links]].map(|rates| constraints(&set, &state, rates));
        fn drive<'a>(set: &'a Articulation, constraints: &'a Constraints, loads: &'a [ExternalLoad]) -> Drive<'a> {
            Drive { set, constraints, loads }
        }
        let fluid = made_up_fluid(set.surface_velocities().len() / 6, &seed);
        let formulations: [&dyn Formulation; 3] = [&Eliminated, &Lagrange, &DirectRows];
        for formulation in formulations {
            let [system, anew] = [&first, &other].map(|c| formulation.constrain(fluid.clone(), &drive(&set, c, &loads)).unwrap());
            let imposed = system.imposed(&drive(&set, &other, &loads)).unwrap();
            prop_assert_eq!(&imposed.rhs, &anew.rhs);
            // every vector solves something
            let solution: Vec<f64> = (0..anew.rhs.len()).map(|i| seed[(i * 7) % 50]).collect();
            let [a, b] = [system.flow_at(&solution, &imposed, &set).unwrap(), anew.flow(&solution, &set).unwrap()];
            prop_assert_eq!([a.generalised, a.bodies, a.forces, a.link_loads], [b.generalised, b.bodies, b.forces, b.link_loads]);
            prop_assert_eq!(a.velocity, b.velocity);
            // what differs in more than its rates has another matrix or other forces of links
            let mut pulled = loads.clone();
            pulled[0].force.x += 1.0;
            prop_assert_eq!(system.imposed(&drive(&set, &other, &pulled)).err(), Some(RigidError::OtherLinks));
            if set.arms() != Arms::Lab {
                let longer: Vec<f64> = set.initial_lengths().iter().map(|l| 1.1 * l).collect();
                let longer = set.constraints(&state, &longer, &rates[..links]).unwrap();
                prop_assert_eq!(system.imposed(&drive(&set, &longer, &loads)).err(), Some(RigidError::OtherLinks));
            }
        }
    }

    #[test]
    fn border_equals_the_dense_projection(seed in prop::collection::vec(-1.0..1.0f64, 200), roles in prop::collection::vec(0u8..5, 10)) {
        let nodes = 10;
        let vertices = 6;
        let roles: Vec<NodeRole> = roles
            .iter()
            .enumerate()
            .map(|(i, r)| match r {
                _ if i == 0 => NodeRole::Free,
                0 | 1 => NodeRole::Free,
                2 => NodeRole::Fixed,
                r => NodeRole::Body(u32::from(r - 3)),
            })
            .collect();
        let points: Vec<Vector3<f64>> = (0..nodes).map(|i| Vector3::new(seed[i], seed[i + 10], seed[i + 20])).collect();
        let half = DMatrix::from_fn(nodes, nodes, |i, j| if (i * 7 + j * 3) % 4 == 0 { seed[(i * 11 + j * 5) % 200] } else { 0.0 });
        let dense = &half + half.transpose();
        let k = csr(&dense);
        let interpolation = DMatrix::from_fn(nodes, vertices, |i, j| if i == j { 1.0 } else if i >= vertices && (i + j) % 3 == 0 { 0.5 } else { 0.0 });
        let b: Vec<DMatrix<f64>> = (0..3).map(|c| DMatrix::from_fn(vertices, nodes, |i, j| seed[(i * 13 + j * 7 + 31 * c) % 200])).collect();
        let b3 = linalg::Csr3::new(
            (vertices, nodes),
            (0..=vertices).map(|r| r * nodes).collect(),
            (0..vertices).flat_map(|_| 0..nodes as u32).collect(),
            (0..vertices).flat_map(|i| (0..nodes).map(move |j| (i, j))).map(|(i, j)| [b[0][(i, j)], b[1][(i, j)], b[2][(i, j)]]).collect(),
        );
        let bodies = [
            SurfaceBody { centre: Vector3::new(0.1, 0.2, 0.3), volume: 0.7 },
            SurfaceBody { centre: Vector3::new(-0.4, 0.0, 0.5), volume: 1.1 },
        ];
        let mass = csr(&DMatrix::identity(vertices, vertices));
        let vertex = csr(&DMatrix::identity(vertices, vertices));
        let fluid = RigidFluid::new(
            FluidMatrices {
                stiffness: k.clone(), divergence: b3.clone(), pressure_mass: mass, interpolation: csr(&interpolation),
                vertex_stiffness: vertex, points: &points, roles: &roles,
                on_symmetry_planes: Vec::new(),
            },
            &bodies,
        ).unwrap();

        // The dense rigid map: three rows a node, six columns a body.
        let mut p = DMatrix::zeros(3 * nodes, 12);
        for (node, role) in roles.iter().enumerate() {
            if let NodeRole::Body(body) = role {
                let body = *body as usize;
                let arm = points[node] - bodies[body].centre;
                p.fixed_view_mut::<3, 3>(3 * node, 6 * body).copy_from(&nalgebra::Matrix3::identity());
                p.fixed_view_mut::<3, 3>(3 * node, 6 * body + 3).copy_from(&-arm.cross_matrix());
            }
        }
        let k3 = dense.kronecker(&DMatrix::identity(3, 3));
        let b_dense = DMatrix::from_fn(vertices, 3 * nodes, |i, j| b[j % 3][(i, j / 3)]);
        // the order of the unknowns is the fluid's own
        let free: Vec<usize> = fluid.free_nodes.iter().map(|&node| node as usize).collect();
        let mut ascending = free.clone();
        ascending.sort_unstable();
        prop_assert!(ascending.into_iter().eq((0..nodes).filter(|&i| roles[i] == NodeRole::Free)));
        let free_rows: Vec<usize> = free.iter().flat_map(|i| 3 * i..3 * i + 3).collect();
        let kp = &k3 * &p;
        // Sums of at most 10 terms of size 1: a few rounding errors.
        let close = |a: &DMatrix<f64>, b: &DMatrix<f64>| (a - b).amax() < 1e-13;
        prop_assert!(close(&to_dense(&fluid.border), &kp.select_rows(&free_rows)));
        let mut corner = p.transpose() * &kp;
        for (i, body) in bodies.iter().enumerate() {
            for a in 3..6 {
                corner[(6 * i + a, 6 * i + a)] += 2.0 * body.volume;
            }
        }
        prop_assert!(close(&fluid.corner, &corner));
        prop_assert!(close(&to_dense(&fluid.rigid_divergence), &(&b_dense * &p)));
        prop_assert!(close(&to_dense(&fluid.stiffness), &dense.select_rows(&free).select_columns(&free)));
        let j3 = interpolation.kronecker(&DMatrix::identity(3, 3));
        let p_vertices = p.rows(0, 3 * vertices).into_owned();
        prop_assert!(close(&to_dense(&fluid.interpolation_border), &(j3 * p_vertices).select_rows(&free_rows)));
        let free_vertices: Vec<usize> = (0..vertices).filter(|&i| roles[i] == NodeRole::Free).collect();
        prop_assert!(close(
            &to_dense(&fluid.interpolation),
            &interpolation.select_rows(&free).select_columns(&free_vertices),
        ));
    }
}

/// Matrices that stand for a fluid around so many bodies: three free nodes, one on a wall, one on each body.
fn made_up_fluid(bodies: usize, seed: &[f64]) -> RigidFluid {
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
    // the diagonal outweighs the rest
    let stiffness = DMatrix::from_fn(nodes, nodes, |i, j| match i == j {
        true => 2.0 * nodes as f64,
        false => entry(i, j) + entry(j, i),
    });
    let interpolation = DMatrix::from_fn(nodes, vertices, |i, j| match i < vertices {
        true => f64::from(i == j),
        false => 1.0 / vertices as f64,
    });
    let divergence = linalg::Csr3::new(
        (vertices, nodes),
        (0..=vertices).map(|row| row * nodes).collect(),
        (0..vertices).flat_map(|_| 0..nodes as u32).collect(),
        (0..vertices * nodes)
            .map(|k| std::array::from_fn(|axis| entry(k, axis)))
            .collect(),
    );
    let surfaces: Vec<SurfaceBody> = (0..bodies)
        .map(|body| SurfaceBody {
            centre: Vector3::repeat(entry(body, 3)),
            volume: 1.0,
        })
        .collect();
    let matrices = FluidMatrices {
        stiffness: csr(&stiffness),
        divergence,
        pressure_mass: csr(&DMatrix::identity(vertices, vertices)),
        interpolation: csr(&interpolation),
        vertex_stiffness: csr(&DMatrix::identity(vertices, vertices)),
        points: &points,
        roles: &roles,
        on_symmetry_planes: Vec::new(),
    };
    RigidFluid::new(matrices, &surfaces).unwrap()
}

#[test]
fn independent_bodies_have_no_rates() {
    let x = [Vector3::zeros(), 5.0 * Vector3::x()];
    let set = Articulation::new(&[BodyKind::Rigid; 2], vec![], Arms::Clamped, &x).unwrap();
    let drive = Drive {
        set: &set,
        constraints: &constraints(&set, &set.initial_state(), &[]),
        loads: &[ExternalLoad::default(); 2],
    };
    let fluid = made_up_fluid(2, &[0.3, -0.1, 0.7]);
    let system = Independent.constrain(fluid, &drive).unwrap();
    assert_eq!(system.imposed(&drive).err(), Some(RigidError::OtherLinks));
}

fn csr(dense: &DMatrix<f64>) -> linalg::Csr {
    let (mut pointers, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
    for row in dense.row_iter() {
        for (j, &v) in row.iter().enumerate().filter(|e| *e.1 != 0.0) {
            indices.push(j as u32);
            values.push(v);
        }
        pointers.push(indices.len());
    }
    linalg::Csr::new(dense.shape(), pointers, indices, values)
}

fn to_dense(matrix: &linalg::Csr) -> DMatrix<f64> {
    let mut dense = DMatrix::zeros(matrix.rows(), matrix.cols());
    for (i, row) in matrix.outer_iterator().enumerate() {
        for (j, &v) in row.iter() {
            dense[(i, j)] += v;
        }
    }
    dense
}

fn link(body: usize, to: usize) -> Link {
    Link {
        name: format!("{body}-{to}"),
        body,
        to,
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
        vec![link(0, 1), link(2, 1)],
        arms,
        &x,
    )
    .unwrap()
}

#[test]
fn arms_fix_the_number_of_unknown_motions() {
    // Clamped: one rigid motion. Lab: one translation and three spins. Free: a frame and three spins, but the
    // collinear frame's turn about its own axis moves no surface and is dropped.
    for (arms, unknowns) in [(Arms::Clamped, 6), (Arms::Lab, 3 + 9), (Arms::Free, 5 + 9)] {
        let set = collinear(arms);
        let c = constraints(&set, &set.initial_state(), &[-1.0, 0.0]);
        assert_eq!(
            Reduction::of(&set, &c).unwrap().dofs(),
            unknowns,
            "{arms:?}"
        );
    }
}

#[test]
fn lab_arms_are_equation_11_of_the_paper() {
    let set = collinear(Arms::Lab);
    let c = constraints(&set, &set.initial_state(), &[-1.0, 0.5]);
    let reduction = Reduction::of(&set, &c).unwrap();
    let q = reduction.velocities(&DVector::zeros(reduction.dofs()));
    let u = |body: usize| q.fixed_rows::<3>(c.layout.body(body)).into_owned();
    // The left arm closes: its outer sphere moves right against the centre; the right arm opens.
    assert_eq!(u(0) - u(1), Vector3::new(1.0, 0.0, 0.0));
    assert_eq!(u(2) - u(1), Vector3::new(0.5, 0.0, 0.0));
}

#[test]
fn redundant_loops_work_and_contradictory_ones_are_named() {
    let x = [Vector3::zeros(), 3.0 * Vector3::x(), 4.0 * Vector3::y()];
    let links = vec![link(1, 0), link(2, 0), link(2, 1)];
    for arms in [Arms::Clamped, Arms::Free, Arms::Lab] {
        let set = Articulation::new(&[BodyKind::Rigid; 3], links.clone(), arms, &x).unwrap();
        let state = set.initial_state();
        // Uniform growth keeps the triangle closed.
        let grow: Vec<f64> = set.initial_lengths().iter().map(|l| 0.1 * l).collect();
        assert!(Reduction::of(&set, &constraints(&set, &state, &grow)).is_ok());
        let one = constraints(&set, &state, &[1.0, 0.0, 0.0]);
        assert!(
            matches!(
                Reduction::of(&set, &one),
                Err(RigidError::IncompatibleLinks { .. })
            ),
            "{arms:?}"
        );
    }
}
