//! All formulations have the same solution on random scenes: any tree of joints, order of bodies,
//! root, kind of arms, loads, units.

use linalg::{KrylovParams, SaddleLdlt, fgmres};
use nalgebra::DVector;
use proptest::prelude::*;
use rigid::{Constrained, DirectRows, Eliminated, FlowSolution, Formulation, Lagrange};
use swimmer::Scene;
use swimmer::models::FemModel;
use testkit::SceneText;

const FORMULATIONS: [&dyn Formulation; 3] = [&Eliminated, &Lagrange, &DirectRows];

/// Positions far enough from each other and from the wall for spheres of radius 1.4.
const POSITIONS: [[f64; 3]; 4] = [
    [-4.5, 0.0, 1.0],
    [0.0, -4.0, 0.0],
    [4.5, 1.0, -1.0],
    [0.0, 4.5, 2.0],
];

#[derive(Clone, Debug)]
struct Case {
    /// Radius of each body and its offset from its position.
    bodies: Vec<(f64, [f64; 3])>,
    /// Parent of each body except the root `order[0]`, as an index into `order`.
    parents: Vec<usize>,
    /// The bodies from the root outwards, in another order than in the scene.
    order: Vec<usize>,
    arms: &'static str,
    rates: Vec<f64>,
    pull: [f64; 3],
    viscosity: f64,
    length: f64,
}

fn case() -> impl Strategy<Value = Case> {
    (1usize..=4).prop_flat_map(|n| {
        (
            prop::collection::vec((0.6..1.4, prop::array::uniform3(-0.4..0.4)), n),
            (1..n).map(|child| 0..child).collect::<Vec<_>>(),
            Just((0..n).collect::<Vec<_>>()).prop_shuffle(),
            prop::sample::select(vec!["clamped", "free", "lab"]),
            prop::collection::vec(-1.0..1.0, n - 1),
            prop::array::uniform3(-2.0..2.0),
            -9.0..9.0,
            -6.0..6.0,
        )
            .prop_map(
                |(bodies, parents, order, arms, rates, pull, viscosity, length)| Case {
                    bodies,
                    parents,
                    order,
                    arms,
                    rates,
                    pull,
                    viscosity: 10f64.powf(viscosity),
                    length: 10f64.powf(length),
                },
            )
    })
}

impl Case {
    fn scene(&self) -> Scene {
        let length = self.length;
        let mut text = SceneText::new();
        for (number, (radius, offset)) in self.bodies.iter().enumerate() {
            let x = [0, 1, 2].map(|axis| length * (POSITIONS[number][axis] + offset[axis]));
            text = text.sphere(&format!("b{number}"), length * radius, x);
        }
        for (child, &parent) in self.parents.iter().enumerate() {
            let [body, to] = [child + 1, parent].map(|k| format!("b{}", self.order[k]));
            text = text.slide(&format!("l{child}"), &body, &to);
        }
        let pull = self.pull.map(|f| f * self.viscosity * length * length);
        // The largest sphere has radius 1.4: one element size for all keeps the meshes small.
        text.ball(11.0 * length)
            .elements(length)
            .with("fluid.viscosity", format!("{:e}", self.viscosity))
            .with("bodies[0].force", format!("{pull:?}"))
            .with("gait.arms", self.arms)
            .scene()
    }
}

fn direct(system: &Constrained) -> Vec<f64> {
    let mut x = vec![0.0; system.rhs.len()];
    SaddleLdlt::factor(&system.system, &Default::default())
        .unwrap()
        .solve(&system.rhs, &mut x)
        .unwrap();
    x
}

/// Block-preconditioned FGMRES to a true residual of 1e-10.
fn block(system: &Constrained) -> Vec<f64> {
    let mut x = vec![0.0; system.rhs.len()];
    let mut preconditioner = system.preconditioner().unwrap();
    let params = KrylovParams::default().with_rel_tol(1e-10);
    fgmres(
        &system.system,
        &mut preconditioner,
        &system.rhs,
        &mut x,
        &params,
    )
    .unwrap();
    x
}

/// Relative differences: velocities, pressures, motions of bodies, forces, loads of joints.
fn difference(a: &FlowSolution, b: &FlowSolution) -> [f64; 5] {
    let of = |x: &[f64], y: &[f64]| -> f64 {
        let largest = x.iter().fold(0.0, |m: f64, e| m.max(e.abs()));
        let differences = x.iter().zip(y).map(|(x, y)| (x - y).abs());
        let worst = differences.fold(0.0, f64::max);
        // If all values are zero, such as the loads without joints, they must be equal.
        if worst == 0.0 { 0.0 } else { worst / largest }
    };
    let velocities = |flow: &FlowSolution| -> Vec<f64> {
        flow.velocity.iter().flat_map(|u| [u.x, u.y, u.z]).collect()
    };
    let mean_free = |p: &[f64]| -> Vec<f64> {
        let mean = p.iter().sum::<f64>() / p.len() as f64;
        p.iter().map(|p| p - mean).collect()
    };
    let list = |v: &DVector<f64>| v.as_slice().to_vec();
    [
        of(&velocities(a), &velocities(b)),
        of(&mean_free(&a.pressure), &mean_free(&b.pressure)),
        of(&list(&a.bodies), &list(&b.bodies)),
        of(&list(&a.forces), &list(&b.forces)),
        of(&list(&a.joint_loads), &list(&b.joint_loads)),
    ]
}

proptest! {
    // Each case solves a system of about ten thousand degrees of freedom six times.
    #![proptest_config(ProptestConfig { cases: 2, max_shrink_iters: 4, ..ProptestConfig::default() })]

    #[test]
    fn formulations_have_the_same_solution(case in case()) {
        let scene = case.scene();
        let mut model = FemModel::new(&scene).unwrap();
        let state = scene.initial_state();
        let rates: Vec<f64> = case.rates.iter().map(|r| r * case.length).collect();
        let configuration = testkit::at(&state, scene.articulation().initial_shape());
        let mut reference: Option<FlowSolution> = None;
        for formulation in FORMULATIONS {
            let system = model.system(configuration, &rates, formulation).unwrap();
            let exact = system.flow(&direct(&system), scene.articulation()).unwrap();
            let reference = reference.get_or_insert_with(|| exact.clone());
            for (quantity, error) in difference(reference, &exact).into_iter().enumerate() {
                // The direct solver refines to 1e-12; resistances differ by a factor of a few tens
                // at most.
                prop_assert!(error < 1e-9, "{}, quantity {quantity}: {error:e}", formulation.name());
            }
            let iterated = system.flow(&block(&system), scene.articulation()).unwrap();
            for (quantity, error) in difference(reference, &iterated).into_iter().enumerate() {
                // A residual of 1e-10 and the same factor; pressures and forces depend on the
                // residual, not on the energy.
                prop_assert!(error < 1e-7, "{} iterated, quantity {quantity}: {error:e}", formulation.name());
            }
        }
    }
}
