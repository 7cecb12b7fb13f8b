//! Several rates of the joints in one configuration: one system with several right-hand sides.

use nalgebra::Vector3;
use swimmer::Scene;
use swimmer::models::{Query, ShapeSpace, SphereModel, SpheresModel};
use testkit::{Recording, SceneText, boxed, within};

/// Three spheres of two sizes with two arms, collinear or not.
fn swimmer(kind: &str, right: [i32; 3]) -> SceneText {
    SceneText::new()
        .sphere("left", 1.0, [-4, 0, 0])
        .sphere("centre", 1.2, [0; 3])
        .sphere("right", 1.0, right)
        .slide("left arm", "left", "centre")
        .slide("right arm", "right", "centre")
        .with("model.kind", kind)
}

const ON_LINE: [i32; 3] = [5, 0, 0];
const OFF_LINE: [i32; 3] = [3, 4, 0];

/// Rates of both arms.
const RATES: [[f64; 2]; 4] = [[1.0, 0.0], [0.3, -0.7], [0.0, 1.0], [0.0, 0.0]];

fn rates(count: usize) -> Vec<Vec<f64>> {
    RATES[..count].iter().map(Vec::from).collect()
}

/// Asserts that the solutions of one query for `count` rates equal those of `count` single queries.
fn assert_bitwise_equal(text: SceneText, count: usize) {
    let scene = &text.scene();
    let model = || boxed(scene);
    let (state, shape) = (scene.initial_state(), scene.articulation().initial_shape());
    let rates = rates(count);
    let configuration = testkit::at(&state, shape);
    let at_once = model().solve(&Query::new(configuration, &rates)).unwrap();
    assert_eq!(at_once.len(), rates.len());
    for (number, (answer, rates)) in at_once.iter().zip(&rates).enumerate() {
        let alone = model().solve_one(configuration, rates).unwrap();
        assert_eq!(answer.bodies, alone.bodies);
        assert_eq!(answer.joint_loads, alone.joint_loads);
        assert_eq!(answer.motion, alone.motion);
        assert_eq!(answer.solver, alone.solver);
        assert_eq!(answer.error_estimate, alone.error_estimate);
        assert_eq!(answer.mesh_error, alone.mesh_error);
        assert_eq!(answer.checks, alone.checks);
        // The first solution includes the time of the shared work.
        let seconds = &answer.seconds;
        let is_shared = [seconds.mesh, seconds.assembly, seconds.setup] == [0.0; 3];
        assert!(number == 0 || is_shared && answer.remeshed.is_none());
    }
}

#[test]
fn unbounded_fem_queries_are_bitwise_equal_to_single_ones() {
    assert_bitwise_equal(swimmer("fem", ON_LINE).with("fem.size_factor", 4), 2);
}

#[test]
fn queries_of_every_formulation_are_bitwise_equal_to_single_ones() {
    // Four right-hand sides are solved in two groups.
    for (formulation, count) in [("p-tilde", 4), ("lagrange", 2), ("direct-row", 2)] {
        let text = swimmer("fem", OFF_LINE).ball(8.0).elements(2.0);
        assert_bitwise_equal(text.with("fem.formulation", formulation), count);
    }
}

#[test]
fn queries_of_other_solvers_are_bitwise_equal_to_single_ones() {
    for solver in ["direct", "minres"] {
        let text = swimmer("fem", ON_LINE).ball(8.0).elements(2.0);
        assert_bitwise_equal(
            text.with("fem.estimates", "off").with("fem.solver", solver),
            2,
        );
    }
}

#[test]
fn axisymmetric_queries_are_bitwise_equal_to_single_ones() {
    assert_bitwise_equal(swimmer("axisymmetric", ON_LINE).tolerance(1e-2), 2);
}

#[test]
fn the_finite_element_model_continues_after_empty_and_multiple_queries() {
    let scene: Scene = swimmer("fem", ON_LINE).ball(8.0).elements(2.0).scene();
    let mut model = boxed(&scene);
    let (state, shape) = (scene.initial_state(), scene.articulation().initial_shape());
    let configuration = testkit::at(&state, shape);
    let mut solve = |rates: &[Vec<f64>]| model.solve(&Query::new(configuration, rates));
    assert!(solve(&[]).unwrap().is_empty());
    let first = solve(&rates(4)).unwrap();
    // The initial guess is a combination of the previous solutions.
    let again = solve(&rates(2)[1..]).unwrap();
    assert!(again[0].solver.iterations <= 1);
    let [first, again] = [&first[1], &again[0]].map(|solution| solution.uncorrected());
    for (a, b) in first.bodies.iter().zip(&again.bodies) {
        let why = "residuals of 1e-8; errors of velocities are larger by a small factor";
        within((a.velocity - b.velocity).norm(), 1e-6, why);
    }
    // Too few rates are refused in any position.
    let short = [vec![1.0, 0.0], vec![1.0]];
    assert!(solve(&short).is_err());
}

#[test]
fn tables_need_one_query_per_shape() {
    let scene = swimmer("multipole", ON_LINE).scene();
    let spheres = SpheresModel::new(&scene, SphereModel::Multipole(1e-6)).unwrap();
    let mut model = Recording::new(spheres);
    let ranges = [(3.5, 5.0), (4.0, 6.0)];
    let space = ShapeSpace::tabulate(&scene, &mut model, &ranges, 1e-4).unwrap();
    assert_eq!(model.queries(), vec![2; space.points()]);
    assert!(space.connection(&[4.0, 5.0]).unwrap()[0].linear != Vector3::zeros());
}
