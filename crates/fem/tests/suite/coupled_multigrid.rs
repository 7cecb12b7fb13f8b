//! Multigrid for linear elasticity with quadratic elements: the iterations that `linalg` states.

use fem::linalg::{
    Bordered, CoupledMultigrid, CoupledOperator, CsrOperator, KrylovParams, LinearOperator,
    Multigrid, MultigridParams, Preconditioner, cg,
};
use fem::mesh::{LinearTets, TetMesh};
use fem::nalgebra::Matrix3;
use fem::{DirichletCondition, TaylorHood, interleaved};

/// Iterations to 1e-8 for forces that are uniform, and random, with Poisson's ratio 0.3 in a cube
/// of `6 n^3` cells that is clamped on one side: translations, rigid motions, Laplacian.
fn iterations(n: u32) -> [[usize; 2]; 3] {
    let (mu, lambda) = (1.0 / 2.6, 0.3 / (1.3 * 0.4));
    let mesh = TetMesh::straight(LinearTets::cube(n)).unwrap();
    let space = TaylorHood::new(&mesh).unwrap();
    let blocks = space.assemble(&mesh, 2, |point, matrix: &mut [[Matrix3<f64>; 10]; 10]| {
        point.add(matrix, |v, u| {
            let (a, b) = (v.gradient, u.gradient);
            mu * (Matrix3::from_diagonal_element(a.dot(&b)) + b * a.transpose())
                + lambda * a * b.transpose()
        });
    });
    let clamped = mesh.tag("z0").unwrap();
    let condition = DirichletCondition::on_tags(&mesh, &[clamped]).unwrap();
    let whole = interleaved(&blocks.unwrap()).unwrap();
    let a = condition.restrict_matrix(&whole, 3).unwrap();
    let laplacian = space.stiffness(&mesh).unwrap();
    let laplacian = condition.restrict_matrix(&laplacian, 1).unwrap();
    let free = condition.free_nodes().iter();
    let positions: Vec<[f64; 3]> = free.map(|&i| mesh.points()[i as usize].into()).collect();

    let coupled = CoupledOperator::from_interleaved(&a).unwrap();
    let a = CsrOperator::new(a).unwrap();
    let params = MultigridParams::default();
    let mut cycles: [Box<dyn Preconditioner>; 3] = [
        Box::new(CoupledMultigrid::new(&coupled, &params).unwrap()),
        Box::new(CoupledMultigrid::with_rigid_motions(&coupled, &positions, &params).unwrap()),
        Box::new(Multigrid::new(&Bordered::scalar(laplacian).unwrap(), &params).unwrap()),
    ];
    let mut state = 1_u64;
    let mut random = || {
        // Knuth's linear congruential generator.
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let loads = [
        vec![1.0; a.rows()],
        (0..a.rows()).map(|_| random()).collect(),
    ];
    let mut found = [[0; 2]; 3];
    for (cycle, found) in cycles.iter_mut().zip(&mut found) {
        for (load, found) in loads.iter().zip(found) {
            let mut x = vec![0.0; a.rows()];
            let report = cg(&a, cycle.as_mut(), load, &mut x, &KrylovParams::default()).unwrap();
            *found = report.iterations;
        }
    }
    found
}

/// The documentation of `CoupledMultigrid` has these numbers; the rounding of another machine may
/// change a count by a few.
#[test]
fn quadratic_elements_take_the_iterations_that_the_documentation_states() {
    let stated = [
        (4, [[80, 75], [49, 43], [84, 77]]),
        (8, [[104, 92], [57, 49], [92, 82]]),
    ];
    for (n, stated) in stated {
        let found = iterations(n);
        for (found, stated) in found.iter().flatten().zip(stated.iter().flatten()) {
            assert!(found.abs_diff(*stated) <= 3, "{n}: {found} {stated}");
        }
    }
}
