//! Several rates of the links at one shape: one system with several right-hand sides.

use nalgebra::Vector3;
use swimmer::Scene;
use swimmer::choose;
use swimmer::models::ShapeSpace;
use swimmer::models::{
    Configuration, Cost, Hydrodynamics, InstantaneousSolution, ModelError, Query,
};

/// Three spheres of two sizes, linked by two arms, the right one on a line with the left one or off it.
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
const QUESTIONS: [[f64; 2]; 4] = [[1.0, 0.0], [0.3, -0.7], [0.0, 1.0], [0.0, 0.0]];

fn rates(count: usize) -> Vec<Vec<f64>> {
    QUESTIONS[..count].iter().map(Vec::from).collect()
}

/// That answers to so many questions at once are those of models that were asked one thing each.
fn check_last_bits(scene: &Scene, count: usize) {
    let model = || choose(scene).unwrap().model;
    let (state, lengths) = (
        scene.initial_state(),
        scene.articulation().initial_lengths(),
    );
    let rates = rates(count);
    let configuration = Configuration {
        state: &state,
        lengths,
    };
    let at_once = model().solve(&Query::new(configuration, &rates)).unwrap();
    assert_eq!(at_once.len(), rates.len());
    for (number, (answer, rates)) in at_once.iter().zip(&rates).enumerate() {
        let alone = model().solve_one(configuration, rates).unwrap();
        assert_eq!(answer.bodies, alone.bodies);
        assert_eq!(answer.link_forces, alone.link_forces);
        assert_eq!(answer.motion, alone.motion);
        assert_eq!(answer.solver, alone.solver);
        assert_eq!(answer.error_estimate, alone.error_estimate);
        assert_eq!(answer.mesh_error, alone.mesh_error);
        assert_eq!(answer.checks, alone.checks);
        // what all of them share was done for the first
        let seconds = &answer.seconds;
        let is_shared = [seconds.mesh, seconds.assembly, seconds.setup] == [0.0; 3];
        assert!(number == 0 || is_shared && answer.remeshed.is_none());
    }
}

#[test]
fn elements_in_unbounded_fluid_answer_to_the_last_bit_as_one_by_one() {
    let model = "{ kind = \"fem\" }\nfem = { size_factor = 4 }";
    check_last_bits(&swimmer(UNBOUNDED, model, ON_LINE), 2);
}

#[test]
fn every_formulation_answers_to_the_last_bit_as_one_by_one() {
    // four go through the matrices in two groups
    for (formulation, count) in [("p-tilde", 4), ("lagrange", 2), ("direct-row", 2)] {
        let model = format!(
            "{{ kind = \"fem\" }}\nfem = {{ surface_size = 2, formulation = \"{formulation}\" }}"
        );
        check_last_bits(&swimmer(BALL, &model, OFF_LINE), count);
    }
}

#[test]
fn other_solvers_answer_to_the_last_bit_as_one_by_one() {
    for solver in ["direct", "minres"] {
        let model = format!(
            "{{ kind = \"fem\" }}\nfem = {{ surface_size = 2, estimates = \"off\", solver = \"{solver}\" }}"
        );
        check_last_bits(&swimmer(BALL, &model, ON_LINE), 2);
    }
}

#[test]
fn the_meridian_plane_answers_to_the_last_bit_as_one_by_one() {
    let model = "{ kind = \"axisymmetric\", tolerance = 1e-2 }";
    check_last_bits(&swimmer(UNBOUNDED, model, ON_LINE), 2);
}

#[test]
fn elements_go_on_after_no_question_and_after_several() {
    let scene = swimmer(
        BALL,
        "{ kind = \"fem\" }\nfem = { surface_size = 2 }",
        ON_LINE,
    );
    let mut model = choose(&scene).unwrap().model;
    let (state, lengths) = (
        scene.initial_state(),
        scene.articulation().initial_lengths(),
    );
    let configuration = Configuration {
        state: &state,
        lengths,
    };
    let mut solve = |rates: &[Vec<f64>]| model.solve(&Query::new(configuration, rates));
    assert!(solve(&[]).unwrap().is_empty());
    let first = solve(&rates(4)).unwrap();
    // starts from what is remembered, and takes one of its combinations
    let again = solve(&rates(2)[1..]).unwrap();
    assert!(again[0].solver.iterations <= 1);
    for (a, b) in first[1].bodies.iter().zip(&again[0].bodies) {
        // both are solved to a residual of 1e-8, which errors of velocities exceed by a small factor
        assert!((a.velocity - b.velocity).norm() <= 1e-6);
    }
    // one rate too few is refused, whichever it is
    let short = [vec![1.0, 0.0], vec![1.0]];
    assert!(solve(&short).is_err());
}

/// Counts how a model is asked.
struct Counted {
    model: Box<dyn Hydrodynamics>,
    at_once: Vec<usize>,
}

impl Hydrodynamics for Counted {
    fn name(&self) -> &'static str {
        self.model.name()
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        self.at_once.push(query.rates.len());
        self.model.solve(query)
    }

    fn cost(&mut self, configuration: Configuration<'_>) -> Result<Cost, ModelError> {
        self.model.cost(configuration)
    }
}

#[test]
fn tables_ask_once_a_shape() {
    let scene = swimmer(UNBOUNDED, "{ kind = \"multipole\" }", ON_LINE);
    let mut model = Counted {
        model: choose(&scene).unwrap().model,
        at_once: Vec::new(),
    };
    let ranges = [(3.5, 5.0), (4.0, 6.0)];
    let space = ShapeSpace::tabulate(&scene, &mut model, &ranges, 1e-4).unwrap();
    assert_eq!(model.at_once, vec![2; space.points()]);
    assert!(space.connection(&[4.0, 5.0])[0].linear != Vector3::zeros());
}
