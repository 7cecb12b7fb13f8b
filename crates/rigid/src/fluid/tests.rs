//! Sizes that do not fit, and the blocks against dense products.

use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use super::*;
use crate::constrained::to_csr;

fn identity(rows: usize, cols: usize) -> Csr {
    let ends = (0..=rows).map(|row| row.min(cols)).collect();
    let nnz = rows.min(cols);
    let columns = (0..nnz as u32).collect();
    Csr::new((rows, cols), ends, columns, vec![1.0; nnz])
}

const POINTS: [Vector3<f64>; 4] = [Vector3::new(0.0, 0.0, 0.0); 4];
const ROLES: [NodeRole; 4] = [NodeRole::Free; 4];

/// Four nodes, two of them vertices.
fn matrices() -> FluidMatrices {
    FluidMatrices {
        stiffness: identity(4, 4),
        divergence: Csr3::zero((2, 4)),
        pressure_mass: identity(2, 2),
        interpolation: identity(4, 2),
        vertex_stiffness: identity(2, 2),
    }
}

fn fluid(matrices: FluidMatrices) -> Result<RigidFluid, RigidError> {
    RigidFluid::new(matrices, FluidNodes::new(&POINTS, &ROLES), &[])
}

#[test]
fn matrices_that_do_not_fit_are_refused() {
    let changed = |change: &dyn Fn(&mut FluidMatrices)| {
        let mut matrices = matrices();
        change(&mut matrices);
        fluid(matrices)
    };
    assert!(changed(&|_| ()).is_ok());
    let misfits: [&dyn Fn(&mut FluidMatrices); 8] = [
        &|m| m.stiffness = identity(4, 5),
        &|m| m.stiffness = identity(5, 4),
        &|m| m.divergence = Csr3::zero((2, 3)),
        &|m| m.pressure_mass = identity(3, 3),
        &|m| m.interpolation = identity(3, 2),
        &|m| m.interpolation = identity(4, 3),
        &|m| m.vertex_stiffness = identity(2, 3),
        &|m| {
            m.interpolation = identity(4, 5);
            m.vertex_stiffness = identity(5, 5);
        },
    ];
    for (number, misfit) in misfits.iter().enumerate() {
        let refused = changed(misfit);
        assert!(
            matches!(refused, Err(RigidError::Length { .. })),
            "misfit {number} was accepted"
        );
    }
}

#[test]
fn arrays_and_gap_matrices_that_do_not_fit_are_refused() {
    let short = FluidNodes::new(&POINTS, &ROLES[..3]);
    let refused = RigidFluid::new(matrices(), short, &[]).err();
    assert!(matches!(refused, Some(RigidError::Length { .. })));
    let walls = FluidNodes::new(&POINTS, &ROLES).with_wall_velocity(&POINTS[..2]);
    let refused = RigidFluid::new(matrices(), walls, &[]).err();
    assert!(matches!(refused, Some(RigidError::Length { .. })));
    let gaps = fluid(matrices())
        .unwrap()
        .with_pressure_stiffness(identity(3, 3));
    assert!(matches!(gaps.err(), Some(RigidError::Length { .. })));
}

#[test]
fn matrices_compressed_by_columns_are_accepted() {
    let by_rows = fluid(matrices()).unwrap().blocks;
    let mut by_columns = matrices();
    by_columns.interpolation = by_columns.interpolation.to_csc();
    by_columns.stiffness = by_columns.stiffness.to_csc();
    let by_columns = fluid(by_columns).unwrap().blocks;
    assert_eq!(by_rows.interpolation, by_columns.interpolation);
    assert_eq!(by_rows.stiffness, by_columns.stiffness);
}

fn to_dense(matrix: &Csr) -> DMatrix<f64> {
    let mut dense = DMatrix::zeros(matrix.rows(), matrix.cols());
    for (i, row) in matrix.outer_iterator().enumerate() {
        for (j, &v) in row.iter() {
            dense[(i, j)] += v;
        }
    }
    dense
}

/// Ten nodes with random roles, six of them vertices, and random matrices.
struct Random {
    stiffness: DMatrix<f64>,
    interpolation: DMatrix<f64>,
    /// One matrix per axis.
    divergence: [DMatrix<f64>; 3],
    points: Vec<Vector3<f64>>,
    roles: Vec<NodeRole>,
    wall_velocity: Vec<Vector3<f64>>,
}

const NODES: usize = 10;
const VERTICES: usize = 6;
const BODIES: [SurfaceBody; 2] = [
    SurfaceBody {
        centre: Vector3::new(0.1, 0.2, 0.3),
        volume: 0.7,
    },
    SurfaceBody {
        centre: Vector3::new(-0.4, 0.0, 0.5),
        volume: 1.1,
    },
];

impl Random {
    fn new(seed: &[f64], roles: &[u8]) -> Self {
        let role = |(i, role): (usize, &u8)| match role {
            _ if i == 0 => NodeRole::Free,
            0 | 1 => NodeRole::Free,
            2 => NodeRole::Fixed,
            r => NodeRole::Body(u32::from(r - 3)),
        };
        let half = DMatrix::from_fn(NODES, NODES, |i, j| match (i * 7 + j * 3) % 4 {
            0 => seed[(i * 11 + j * 5) % 200],
            _ => 0.0,
        });
        let interpolation = DMatrix::from_fn(NODES, VERTICES, |i, j| {
            if i == j {
                1.0
            } else if i >= VERTICES && (i + j) % 3 == 0 {
                0.5
            } else {
                0.0
            }
        });
        let divergence = |axis: usize| {
            DMatrix::from_fn(VERTICES, NODES, |i, j| {
                seed[(i * 13 + j * 7 + 31 * axis) % 200]
            })
        };
        let vector = |i: usize| Vector3::new(seed[i], seed[i + 10], seed[i + 20]);
        Self {
            stiffness: &half + half.transpose(),
            interpolation,
            divergence: std::array::from_fn(divergence),
            points: (0..NODES).map(vector).collect(),
            roles: roles.iter().enumerate().map(role).collect(),
            wall_velocity: (0..NODES).map(|i| vector(i + 40)).collect(),
        }
    }

    fn fluid(&self) -> RigidFluid {
        let entries = (0..VERTICES).flat_map(|i| (0..NODES).map(move |j| (i, j)));
        let matrices = FluidMatrices {
            stiffness: to_csr(&self.stiffness),
            divergence: Csr3::new(
                (VERTICES, NODES),
                (0..=VERTICES).map(|row| row * NODES).collect(),
                (0..VERTICES).flat_map(|_| 0..NODES as u32).collect(),
                entries
                    .map(|place| std::array::from_fn(|axis| self.divergence[axis][place]))
                    .collect(),
            ),
            pressure_mass: to_csr(&DMatrix::identity(VERTICES, VERTICES)),
            interpolation: to_csr(&self.interpolation),
            vertex_stiffness: to_csr(&DMatrix::identity(VERTICES, VERTICES)),
        };
        let nodes = FluidNodes::new(&self.points, &self.roles);
        RigidFluid::new(
            matrices,
            nodes.with_wall_velocity(&self.wall_velocity),
            &BODIES,
        )
        .unwrap()
    }

    /// The dense rigid map `P`: three rows per node, six columns per body.
    fn rigid_map(&self) -> DMatrix<f64> {
        let mut p = DMatrix::zeros(3 * NODES, 6 * BODIES.len());
        for (node, role) in self.roles.iter().enumerate() {
            if let NodeRole::Body(body) = role {
                let body = *body as usize;
                let arm = self.points[node] - BODIES[body].centre;
                p.fixed_view_mut::<3, 3>(3 * node, 6 * body)
                    .fill_with_identity();
                p.fixed_view_mut::<3, 3>(3 * node, 6 * body + 3)
                    .copy_from(&-arm.cross_matrix());
            }
        }
        p
    }

    fn check(&self) {
        let RigidFluid { blocks, surfaces } = self.fluid();
        let p = self.rigid_map();
        let k3 = self.stiffness.kronecker(&DMatrix::identity(3, 3));
        let b = DMatrix::from_fn(VERTICES, 3 * NODES, |i, j| {
            self.divergence[j % 3][(i, j / 3)]
        });
        let is_free = |&node: &usize| self.roles[node] == NodeRole::Free;
        // The order of the dofs is chosen by the fluid.
        let free: Vec<usize> = surfaces.free_nodes.iter().map(|&n| n as usize).collect();
        let mut ascending = free.clone();
        ascending.sort_unstable();
        assert!(ascending.into_iter().eq((0..NODES).filter(is_free)));
        let free_rows: Vec<usize> = free.iter().flat_map(|i| 3 * i..3 * i + 3).collect();
        let kp = &k3 * &p;
        // Sums of at most 10 terms of size 1: a few rounding errors.
        let close = |a: &DMatrix<f64>, b: &DMatrix<f64>| (a - b).amax() < 1e-13;
        assert!(close(
            &to_dense(&surfaces.border),
            &kp.select_rows(&free_rows)
        ));
        let mut corner = p.transpose() * &kp;
        for (i, body) in BODIES.iter().enumerate() {
            for a in 3..6 {
                corner[(6 * i + a, 6 * i + a)] += 2.0 * body.volume;
            }
        }
        assert!(close(&surfaces.corner, &corner));
        assert!(close(&to_dense(&surfaces.rigid_divergence), &(&b * &p)));
        assert!(close(
            &to_dense(&blocks.stiffness),
            &self.stiffness.select_rows(&free).select_columns(&free)
        ));
        let j3 = self.interpolation.kronecker(&DMatrix::identity(3, 3));
        let p_vertices = p.rows(0, 3 * VERTICES).into_owned();
        assert!(close(
            &to_dense(&blocks.interpolation_border),
            &(j3 * p_vertices).select_rows(&free_rows)
        ));
        let free_vertices: Vec<usize> = (0..VERTICES).filter(is_free).collect();
        assert!(close(
            &to_dense(&blocks.interpolation),
            &self
                .interpolation
                .select_rows(&free)
                .select_columns(&free_vertices),
        ));
        // the terms of moving walls
        let mut u = DVector::zeros(3 * NODES);
        for node in (0..NODES).filter(|&node| self.roles[node] == NodeRole::Fixed) {
            u.fixed_rows_mut::<3>(3 * node)
                .copy_from(&self.wall_velocity[node]);
        }
        let walls = surfaces.prescribed.unwrap();
        let ku = &k3 * &u;
        let momentum = DVector::from_vec(walls.momentum);
        assert!((momentum - ku.select_rows(&free_rows)).amax() < 1e-13);
        // torques: up to 7 nodes, 10 terms each
        assert!((walls.loads - p.transpose() * &ku).amax() < 1e-12);
        assert!((DVector::from_vec(walls.flux) - b * u).amax() < 1e-13);
    }
}

proptest! {
    #[test]
    fn blocks_equal_dense_products(
        seed in prop::collection::vec(-1.0..1.0f64, 200),
        roles in prop::collection::vec(0u8..5, NODES),
    ) {
        Random::new(&seed, &roles).check();
    }
}
