//! How tables are computed: in parallel, after interruptions, and up to the noise of a model.

use models::{
    Hydrodynamics, InstantaneousSolution, ModelError, Query, ShapeSpace, SolvedShapes, SphereModel,
    SpheresModel, TablePart,
};
use scene::Scene;

use crate::scenes::three_spheres;

const RANGES: [(f64, f64); 2] = [(6.0, 10.0), (6.0, 10.0)];

/// A model that is not solved in parallel, with errors that differ from shape to shape.
struct Rough {
    model: SpheresModel,
    /// Size of the errors, and their error bar.
    noise: f64,
    solves: usize,
}

impl Rough {
    fn new(scene: &Scene, noise: f64) -> Self {
        Self {
            model: SpheresModel::new(scene, SphereModel::Multipole(1e-8)).unwrap(),
            noise,
            solves: 0,
        }
    }
}

impl Hydrodynamics for Rough {
    fn name(&self) -> &'static str {
        "rough"
    }

    fn scene(&self) -> &Scene {
        self.model.scene()
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        self.solves += 1;
        let shape = query.configuration.shape;
        let mut solutions = self.model.solve(query)?;
        for solution in &mut solutions {
            // Between -1 and 1, without a pattern.
            let error = (1e4 * (shape[0] + 1.7 * shape[1])).sin();
            solution.motion.frames[0].linear.x += self.noise * error;
            solution.error_estimate.mesh = Some(self.noise);
        }
        Ok(solutions)
    }
}

/// All digits of a table.
fn digits(space: &ShapeSpace) -> String {
    serde_json::to_string(&space.geometry().unwrap()).unwrap()
}

#[test]
fn tables_in_parallel_are_bitwise_those_of_one_model() {
    let scene = three_spheres("");
    let mut model = SpheresModel::new(&scene, SphereModel::Multipole(1e-8)).unwrap();
    let parallel = ShapeSpace::tabulate(&scene, &mut model, &RANGES, 1e-6).unwrap();
    let mut rough = Rough::new(&scene, 0.0);
    let sequential = ShapeSpace::tabulate(&scene, &mut rough, &RANGES, 1e-6).unwrap();
    assert_eq!(rough.solves, sequential.points());
    assert_eq!(digits(&parallel), digits(&sequential));
}

#[test]
fn interrupted_tables_continue_with_the_same_digits() {
    let scene = three_spheres("");
    let whole = ShapeSpace::tabulate(&scene, &mut Rough::new(&scene, 0.0), &RANGES, 1e-4).unwrap();
    let mut saved = String::new();
    let mut stop = |solved: &SolvedShapes| {
        saved = serde_json::to_string(solved).unwrap();
        match solved.len() {
            30 => Err(ModelError::NoMesh),
            _ => Ok(()),
        }
    };
    let mut model = Rough::new(&scene, 0.0);
    let start = (SolvedShapes::default(), TablePart::Whole);
    let stopped = ShapeSpace::tabulate_from(&scene, &mut model, &RANGES, 1e-4, start, &mut stop);
    assert!(matches!(stopped, Err(ModelError::NoMesh)));
    let mut model = Rough::new(&scene, 0.0);
    let solved = (serde_json::from_str(&saved).unwrap(), TablePart::Whole);
    let space =
        ShapeSpace::tabulate_from(&scene, &mut model, &RANGES, 1e-4, solved, &mut |_| Ok(()))
            .unwrap();
    assert_eq!(model.solves, space.points() - 30);
    assert_eq!(digits(&space), digits(&whole));

    // Shapes of a scene with other numbers of joints.
    let solved = (serde_json::from_str(&saved).unwrap(), TablePart::Whole);
    let line = [(6.0, 10.0), (10.0, 10.0)];
    let refused =
        ShapeSpace::tabulate_from(&scene, &mut model, &line, 1e-4, solved, &mut |_| Ok(()));
    assert!(matches!(refused, Err(ModelError::ShapeSpace { .. })));
}

#[test]
fn shares_of_a_table_are_solved_apart_and_complete_it() {
    let scene = three_spheres("");
    let whole = ShapeSpace::tabulate(&scene, &mut Rough::new(&scene, 0.0), &RANGES, 1e-4).unwrap();
    let mut known = SolvedShapes::default();
    let mut solves = 0;
    let space = loop {
        // The shares of one grid, as if at the same time: none knows what the others solve.
        let before = known.clone();
        for number in 1..=3 {
            let mut model = Rough::new(&scene, 0.0);
            let share = (before.clone(), TablePart::Share { number, count: 3 });
            let mut solved = SolvedShapes::default();
            let mut keep = |all: &SolvedShapes| {
                solved = all.clone();
                Ok(())
            };
            let space =
                ShapeSpace::tabulate_from(&scene, &mut model, &RANGES, 1e-4, share, &mut keep);
            assert!(matches!(space, Err(ModelError::MissingShapes { .. })));
            solves += model.solves;
            known.merge(solved);
        }
        let mut model = Rough::new(&scene, 0.0);
        let all = (known.clone(), TablePart::Known);
        match ShapeSpace::tabulate_from(&scene, &mut model, &RANGES, 1e-4, all, &mut |_| Ok(())) {
            Ok(space) => break space,
            Err(ModelError::MissingShapes { missing, points }) => {
                assert_eq!(missing + known.len(), points.iter().product::<usize>());
            }
            Err(other) => panic!("{other}"),
        }
        assert_eq!(model.solves, 0);
    };
    assert_eq!(solves, whole.points());
    assert_eq!(digits(&space), digits(&whole));
}

/// Grids were refined until the table became too large: polynomials cannot follow the errors of a
/// mesh.
#[test]
fn bug_tables_were_refined_below_the_errors_of_the_mesh() {
    let scene = three_spheres("");
    let noise = 3e-4;
    let space = ShapeSpace::tabulate(&scene, &mut Rough::new(&scene, noise), &RANGES, 1e-9);
    let space = space.unwrap();
    assert!(space.points() <= 81, "{}", space.points());
    // Both are parts of the error bar.
    assert!(
        space.errors().0 > 0.0 && space.errors().1 >= noise,
        "{:?}",
        space.errors()
    );
    let exact = ShapeSpace::tabulate(&scene, &mut Rough::new(&scene, 0.0), &RANGES, 1e-7).unwrap();
    for shape in [[6.1, 9.7], [7.3, 8.1], [10.0, 6.0]] {
        let [found, exact] = [&space, &exact].map(|s| s.connection(&shape).unwrap());
        for (a, b) in found.iter().zip(&exact) {
            let error = (a.linear - b.linear).norm();
            assert!(error <= space.errors().0 + space.errors().1, "{error:e}");
        }
    }
}

/// A model whose frame moves by the inverse of the sum of all joint values, at no cost.
struct Formula {
    model: SpheresModel,
    solutions: Vec<InstantaneousSolution>,
}

impl Hydrodynamics for Formula {
    fn name(&self) -> &'static str {
        "formula"
    }

    fn scene(&self) -> &Scene {
        self.model.scene()
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        if self.solutions.is_empty() {
            self.solutions = self.model.solve(query)?;
        }
        let mut solutions = self.solutions.clone();
        for solution in &mut solutions {
            let sum: f64 = query.configuration.shape.iter().sum();
            solution.motion.frames[0].linear.x = 1.0 / sum;
        }
        Ok(solutions)
    }
}

/// Tables of many joints were refused when their second grid was too large.
#[test]
fn bug_tables_of_five_joints_were_refused() {
    let spheres = 6;
    let mut text = "model.kind = \"oseen\"\n".to_owned();
    for k in 0..spheres {
        let x = 10 * k;
        text += &format!("[[bodies]]\nname = \"s{k}\"\nradius = 1\nposition = [{x}, 0, 0]\n");
    }
    for k in 1..spheres {
        let to = k - 1;
        text += &format!("[[links]]\nname = \"a{k}\"\nbody = \"s{to}\"\nto = \"s{k}\"\n");
    }
    let scene = Scene::parse(&text).unwrap();
    let ranges = vec![(6.0, 10.0); spheres - 1];
    let mut model = Formula {
        model: SpheresModel::new(&scene, SphereModel::Oseen).unwrap(),
        solutions: Vec::new(),
    };
    let whole = (SolvedShapes::default(), TablePart::Whole);
    let found =
        ShapeSpace::tabulate_from(&scene, &mut model, &ranges, 1e-9, whole, &mut |_| Ok(()));
    let space = found.unwrap();
    assert!(space.is_coarse() && space.points() == 5_usize.pow(5));
    let shape = [6.4, 9.1, 7.3, 8.8, 6.9];
    let exact = 1.0 / shape.iter().sum::<f64>();
    for twist in space.connection(&shape).unwrap() {
        let error = (twist.linear.x - exact).abs();
        assert!(error <= space.errors().0, "{error:e}");
    }
    // A table that must keep its tolerance is still refused.
    let refused = ShapeSpace::tabulate(&scene, &mut model, &ranges, 1e-9);
    assert!(matches!(refused, Err(ModelError::ShapeSpace { .. })));
}
