//! Several rates of the joints in one configuration: one system with several right-hand sides.

use nalgebra::Vector3;
use swimmer::Scene;
use swimmer::choose;
use swimmer::models::ShapeSpace;
use swimmer::models::{Configuration, Hydrodynamics, InstantaneousSolution, ModelError, Query};

/// Three spheres of two sizes with two arms, collinear or not.
fn swimmer(domain: &str, model: &str, right: [i32; 3]) -> Scene {
    let text = format!(
        r#"
        domain = {domain}
        model = {model}
        [[bodies]]
        name = "left"
        radius = 1
        position = [-4, 0, 0]
        [[bodies]]
        name = "centre"
        radius = 1.2
        position = [0, 0, 0]
        [[bodies]]
        name = "right"
        radius = 1
        position = {right:?}
        [[links]]
        name = "left arm"
        body = "left"
        to = "centre"
        [[links]]
        name = "right arm"
        body = "right"
        to = "centre"
        "#
    );
    Scene::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

const UNBOUNDED: &str = "{ kind = \"unbounded\" }";
const ON_LINE: [i32; 3] = [5, 0, 0];
const OFF_LINE: [i32; 3] = [3, 4, 0];
const BALL: &str = "{ kind = \"ball\", radius = 8 }";

/// Rates of both arms.
const RATES: [[f64; 2]; 4] = [[1.0, 0.0], [0.3, -0.7], [0.0, 1.0], [0.0, 0.0]];

fn rates(count: usize) -> Vec<Vec<f64>> {
    RATES[..count].iter().map(Vec::from).collect()
}

/// Asserts that the solutions of one query for `count` rates equal those of `count` single queries.
fn assert_bitwise_equal(scene: &Scene, count: usize) {
    let model = || choose(scene).unwrap().model;
    let (state, shape) = (scene.initial_state(), scene.articulation().initial_shape());
    let rates = rates(count);
    let configuration = Configuration {
        state: &state,
        shape,
    };
    let at_once = model().solve(&Query::new(configuration, &rates)).unwrap();
    assert_eq!(at_once.len(), rates.len());
    for (number, (answer, rates)) in at_once.iter().zip(&rates).enumerate() {
        let alone = model().solve_one(configuration, rates).unwrap();
        assert_eq!(answer.bodies, alone.bodies);
        assert_eq!(answer.joint_forces, alone.joint_forces);
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
    let model = "{ kind = \"fem\" }\nfem = { size_factor = 4 }";
    assert_bitwise_equal(&swimmer(UNBOUNDED, model, ON_LINE), 2);
}

#[test]
fn queries_of_every_formulation_are_bitwise_equal_to_single_ones() {
    // Four right-hand sides are solved in two groups.
    for (formulation, count) in [("p-tilde", 4), ("lagrange", 2), ("direct-row", 2)] {
        let model = format!(
            "{{ kind = \"fem\" }}\nfem = {{ surface_size = 2, formulation = \"{formulation}\" }}"
        );
        assert_bitwise_equal(&swimmer(BALL, &model, OFF_LINE), count);
    }
}

#[test]
fn queries_of_other_solvers_are_bitwise_equal_to_single_ones() {
    for solver in ["direct", "minres"] {
        let model = format!(
            "{{ kind = \"fem\" }}\nfem = {{ surface_size = 2, estimates = \"off\", solver = \"{solver}\" }}"
        );
        assert_bitwise_equal(&swimmer(BALL, &model, ON_LINE), 2);
    }
}

#[test]
fn axisymmetric_queries_are_bitwise_equal_to_single_ones() {
    let model = "{ kind = \"axisymmetric\", tolerance = 1e-2 }";
    assert_bitwise_equal(&swimmer(UNBOUNDED, model, ON_LINE), 2);
}

#[test]
fn the_finite_element_model_continues_after_empty_and_multiple_queries() {
    let scene = swimmer(
        BALL,
        "{ kind = \"fem\" }\nfem = { surface_size = 2 }",
        ON_LINE,
    );
    let mut model = choose(&scene).unwrap().model;
    let (state, shape) = (scene.initial_state(), scene.articulation().initial_shape());
    let configuration = Configuration {
        state: &state,
        shape,
    };
    let mut solve = |rates: &[Vec<f64>]| model.solve(&Query::new(configuration, rates));
    assert!(solve(&[]).unwrap().is_empty());
    let first = solve(&rates(4)).unwrap();
    // The initial guess is a combination of the previous solutions.
    let again = solve(&rates(2)[1..]).unwrap();
    assert!(again[0].solver.iterations <= 1);
    let [first, again] = [&first[1], &again[0]].map(|solution| solution.uncorrected());
    for (a, b) in first.bodies.iter().zip(&again.bodies) {
        // Both are solved to a residual of 1e-8; errors of velocities are larger by a small factor.
        assert!((a.velocity - b.velocity).norm() <= 1e-6);
    }
    // Too few rates are refused in any position.
    let short = [vec![1.0, 0.0], vec![1.0]];
    assert!(solve(&short).is_err());
}

/// Records the number of rates in each query.
struct Counted {
    model: Box<dyn Hydrodynamics>,
    queries: Vec<usize>,
}

impl Hydrodynamics for Counted {
    fn name(&self) -> &'static str {
        self.model.name()
    }

    fn scene(&self) -> &Scene {
        self.model.scene()
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        self.queries.push(query.rates.len());
        self.model.solve(query)
    }
}

#[test]
fn tables_need_one_query_per_shape() {
    let scene = swimmer(UNBOUNDED, "{ kind = \"multipole\" }", ON_LINE);
    let mut model = Counted {
        model: choose(&scene).unwrap().model,
        queries: Vec::new(),
    };
    let ranges = [(3.5, 5.0), (4.0, 6.0)];
    let space = ShapeSpace::tabulate(&scene, &mut model, &ranges, 1e-4).unwrap();
    assert_eq!(model.queries, vec![2; space.points()]);
    assert!(space.connection(&[4.0, 5.0]).unwrap()[0].linear != Vector3::zeros());
}
