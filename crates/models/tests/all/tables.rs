//! How tables are computed: in parallel, after interruptions, and up to the noise of a model.

use models::{
    Hydrodynamics, ModelError, ShapeSpace, SolvedShapes, SphereModel, SpheresModel, TablePart,
};
use scene::Scene;
use testkit::{Recording, SceneText, within};

use crate::scenes::three_spheres;

const RANGES: [(f64, f64); 2] = [(6.0, 10.0), (6.0, 10.0)];

/// A model that is not solved in parallel, with errors of this size, which is also their error bar;
/// they differ from shape to shape.
fn rough(scene: &Scene, noise: f64) -> Recording<'static> {
    let model = SpheresModel::new(scene, SphereModel::Multipole(1e-8)).unwrap();
    Recording::changing(model, move |query, solutions| {
        let shape = query.configuration.shape;
        for solution in solutions {
            // Between -1 and 1, without a pattern.
            let error = (1e4 * (shape[0] + 1.7 * shape[1])).sin();
            solution.motion.frames[0].linear.x += noise * error;
            solution.error_estimate.mesh = Some(noise);
        }
    })
}

fn tabulate(scene: &Scene, model: &mut dyn Hydrodynamics, tolerance: f64) -> ShapeSpace {
    ShapeSpace::tabulate(scene, model, &RANGES, tolerance).unwrap()
}

/// A table from shapes that are known, with what is called after each shape.
fn continued(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    start: (SolvedShapes, TablePart),
    keep: &mut dyn FnMut(&SolvedShapes) -> Result<(), ModelError>,
) -> Result<ShapeSpace, ModelError> {
    ShapeSpace::tabulate_from(scene, model, &RANGES, 1e-4, start, &mut |all| keep(all))
}

/// All digits of a table.
fn digits(space: &ShapeSpace) -> String {
    serde_json::to_string(&space.geometry().unwrap()).unwrap()
}

#[test]
fn tables_in_parallel_are_bitwise_those_of_one_model() {
    let scene = three_spheres().scene();
    let mut model = SpheresModel::new(&scene, SphereModel::Multipole(1e-8)).unwrap();
    let parallel = tabulate(&scene, &mut model, 1e-6);
    let mut rough = rough(&scene, 0.0);
    let sequential = tabulate(&scene, &mut rough, 1e-6);
    assert_eq!(rough.queries().len(), sequential.points());
    assert_eq!(digits(&parallel), digits(&sequential));
}

#[test]
fn interrupted_tables_continue_with_the_same_digits() {
    let scene = three_spheres().scene();
    let whole = tabulate(&scene, &mut rough(&scene, 0.0), 1e-4);
    let mut saved = String::new();
    let mut stop = |solved: &SolvedShapes| {
        saved = serde_json::to_string(solved).unwrap();
        match solved.len() {
            30 => Err(ModelError::NoMesh),
            _ => Ok(()),
        }
    };
    let mut model = rough(&scene, 0.0);
    let start = (SolvedShapes::default(), TablePart::Whole);
    let stopped = continued(&scene, &mut model, start, &mut stop);
    assert!(matches!(stopped, Err(ModelError::NoMesh)));
    let mut model = rough(&scene, 0.0);
    let solved = (serde_json::from_str(&saved).unwrap(), TablePart::Whole);
    let space = continued(&scene, &mut model, solved, &mut |_| Ok(())).unwrap();
    assert_eq!(model.queries().len(), space.points() - 30);
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
    let scene = three_spheres().scene();
    let whole = tabulate(&scene, &mut rough(&scene, 0.0), 1e-4);
    let mut known = SolvedShapes::default();
    let mut solves = 0;
    let space = loop {
        // The shares of one grid, as if at the same time: none knows what the others solve.
        let before = known.clone();
        for number in 1..=3 {
            let mut model = rough(&scene, 0.0);
            let share = (before.clone(), TablePart::Share { number, count: 3 });
            let mut solved = SolvedShapes::default();
            let mut keep = |all: &SolvedShapes| {
                solved = all.clone();
                Ok(())
            };
            let space = continued(&scene, &mut model, share, &mut keep);
            assert!(matches!(space, Err(ModelError::MissingShapes { .. })));
            solves += model.queries().len();
            known.merge(solved);
        }
        let mut model = rough(&scene, 0.0);
        let all = (known.clone(), TablePart::Known);
        match continued(&scene, &mut model, all, &mut |_| Ok(())) {
            Ok(space) => break space,
            Err(ModelError::MissingShapes { missing, points }) => {
                assert_eq!(missing + known.len(), points.iter().product::<usize>());
            }
            Err(other) => panic!("{other}"),
        }
        assert_eq!(model.queries().len(), 0);
    };
    assert_eq!(solves, whole.points());
    assert_eq!(digits(&space), digits(&whole));
}

/// Grids were refined until the table became too large: polynomials cannot follow the errors of a
/// mesh.
#[test]
fn bug_tables_were_refined_below_the_errors_of_the_mesh() {
    let scene = three_spheres().scene();
    let noise = 3e-4;
    let space = tabulate(&scene, &mut rough(&scene, noise), 1e-9);
    assert!(space.points() <= 81, "{}", space.points());
    // Both are parts of the error bar.
    let errors = space.errors();
    assert!(errors.0 > 0.0 && errors.1 >= noise, "{errors:?}");
    let exact = tabulate(&scene, &mut rough(&scene, 0.0), 1e-7);
    for shape in [[6.1, 9.7], [7.3, 8.1], [10.0, 6.0]] {
        let [found, exact] = [&space, &exact].map(|s| s.connection(&shape).unwrap());
        for (a, b) in found.iter().zip(&exact) {
            within(
                (a.linear - b.linear).norm(),
                errors.0 + errors.1,
                "the error bar",
            );
        }
    }
}

/// Tables of many joints were refused when their second grid was too large.
#[test]
fn bug_tables_of_five_joints_were_refused() {
    let spheres = 6;
    let names: Vec<String> = (0..spheres).map(|k| format!("s{k}")).collect();
    let text = (0..spheres).fold(SceneText::new(), |text, k| {
        text.sphere(&names[k], 1.0, [10 * k, 0, 0])
    });
    let text = (1..spheres).fold(text, |text, k| {
        text.slide(&format!("a{k}"), &names[k - 1], &names[k])
    });
    let scene = text.with("model.kind", "oseen").scene();
    let ranges = vec![(6.0, 10.0); spheres - 1];
    // A model whose frame moves by the inverse of the sum of all joint values.
    let oseen = SpheresModel::new(&scene, SphereModel::Oseen).unwrap();
    let mut model = Recording::changing(oseen, |query, solutions| {
        for solution in solutions {
            let sum: f64 = query.configuration.shape.iter().sum();
            solution.motion.frames[0].linear.x = 1.0 / sum;
        }
    });
    let whole = (SolvedShapes::default(), TablePart::Whole);
    let found =
        ShapeSpace::tabulate_from(&scene, &mut model, &ranges, 1e-9, whole, &mut |_| Ok(()));
    let space = found.unwrap();
    assert!(space.is_coarse() && space.points() == 5_usize.pow(5));
    let shape = [6.4, 9.1, 7.3, 8.8, 6.9];
    let exact = 1.0 / shape.iter().sum::<f64>();
    for twist in space.connection(&shape).unwrap() {
        within(
            twist.linear.x - exact,
            space.errors().0,
            "the interpolation error",
        );
    }
    // A table that must keep its tolerance is still refused.
    let refused = ShapeSpace::tabulate(&scene, &mut model, &ranges, 1e-9);
    assert!(matches!(refused, Err(ModelError::ShapeSpace { .. })));
}
