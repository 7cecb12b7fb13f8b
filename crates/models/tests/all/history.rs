//! Histories of models: stored as JSON and restored bitwise.

use models::{FemModel, History, Hydrodynamics, ModelError};

use scene::Scene;
use testkit::{SceneText, solve_at};

use crate::scenes::three_spheres_in_ball;

fn through_json(history: &History) -> History {
    let text = serde_json::to_string(history).unwrap();
    serde_json::from_str(&text).unwrap()
}

#[test]
fn numbers_survive_storage_bitwise() {
    let numbers = vec![
        0.1 + 0.2,
        1.0 / 3.0,
        -5e-324,
        f64::MAX,
        f64::MIN_POSITIVE,
        1e300 / 7.0,
    ];
    let history = through_json(&History::new(&numbers).unwrap());
    let restored: Vec<f64> = history.contents().unwrap();
    let bits = |list: &[f64]| list.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&restored), bits(&numbers));
}

#[test]
fn contents_of_another_type_are_refused() {
    let history = History::new(&"text").unwrap();
    let error = history.contents::<Vec<f64>>().unwrap_err();
    assert!(matches!(error, ModelError::History(_)), "{error}");
}

#[test]
fn a_restored_model_continues_bitwise() {
    let scene = three_spheres_in_ball();
    check_restored(&scene, [&[10.0, 10.0], &[9.5, 10.0]], &[-1.0, 0.5]);
}

/// Two spheres in a ball that exchange volume.
fn exchanging_spheres() -> Scene {
    SceneText::new()
        .sphere("a", 1.0, [0; 3])
        .sphere("b", 0.8, [3, 0, 0])
        .joint("flow", "a", "b", "joint = \"exchange\"")
        .ball(6.0)
        .elements(1.2)
        .scene()
}

/// The history has the shapes of the bodies around which meshes were generated.
#[test]
fn a_restored_model_of_bodies_that_deform_continues_bitwise() {
    check_restored(&exchanging_spheres(), [&[5.0], &[4.2]], &[1.0]);
}

/// The volumes that a damaged history gives are positive, and of as many joints as there are.
#[test]
fn a_history_with_shapes_at_which_no_body_can_be_is_refused() {
    let scene = exchanging_spheres();
    let mut model = FemModel::new(&scene).unwrap();
    solve_at(&mut model, &[5.0], &[1.0]);
    let history = serde_json::to_value(model.history().unwrap()).unwrap();
    for (values, part) in [
        (vec![-5.0], "damaged"),
        (vec![f64::MAX], "damaged"),
        (vec![], "values"),
        (vec![5.0, 5.0], "values"),
    ] {
        let mut damaged = history.clone();
        assert_eq!(damaged["values"], serde_json::json!([5.0]));
        damaged["values"] = serde_json::json!(values);
        let damaged: History = serde_json::from_value(damaged).unwrap();
        let error = model.restore(&damaged).unwrap_err().to_string();
        assert!(error.contains(part), "{values:?}: {error}");
        // The model goes on with the history that it can have.
        let sound = serde_json::from_value(history.clone()).unwrap();
        model.restore(&sound).unwrap();
    }
}

fn check_restored(scene: &Scene, [first, second]: [&[f64]; 2], rates: &[f64]) {
    let mut model = FemModel::new(scene).unwrap();
    solve_at(&mut model, first, rates);
    let history = model.history().unwrap();

    // Both forget their initial guesses; the mesh is that of the first configuration, moved.
    model.restore(&history).unwrap();
    let mut other = FemModel::new(scene).unwrap();
    other.restore(&through_json(&history)).unwrap();
    let [expected, found] = [&mut model, &mut other].map(|m| solve_at(m, second, rates));
    assert_eq!(found.bodies, expected.bodies);
    assert_eq!(found.joint_loads, expected.joint_loads);
    assert_eq!(found.motion, expected.motion);
    assert_eq!(found.mesh_error, expected.mesh_error);
    assert_eq!(found.error_estimate, expected.error_estimate);
    assert!(found.remeshed.is_none());
    assert_eq!(other.history().unwrap(), history);
}
