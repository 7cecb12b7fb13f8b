//! The choice of the model by `model.kind = "auto"`.

use swimmer::{choose, solve_start};

use crate::sphere_strokes::{UNBOUNDED, run, three_spheres};

#[test]
fn auto_chooses_three_models_for_three_tolerances_and_meets_each() {
    let exact = 0.1598053403881754;
    let mut chosen = Vec::new();
    for tolerance in [1e-2, 1e-4, 1e-8] {
        let scene = three_spheres(UNBOUNDED, "auto", tolerance);
        let mut choice = choose(&scene).unwrap();
        assert_eq!(choice.reasons.len(), 3, "{:?}", choice.reasons);
        let net = run(&scene).displacement[1].x;
        assert!(
            (net / exact - 1.0).abs() <= tolerance,
            "{tolerance:e}: {net}"
        );
        let start = solve_start(&scene, choice.model.as_mut()).unwrap();
        chosen.push((choice.model.name(), start.dofs.total));
    }
    chosen.dedup();
    assert_eq!(chosen.len(), 3, "{chosen:?}");
}

#[test]
fn auto_chooses_rpy_where_it_is_accurate_enough() {
    // RPY has an error of 3 % for this stroke.
    let choice = choose(&three_spheres(UNBOUNDED, "auto", 0.1)).unwrap();
    assert_eq!(choice.model.name(), "rpy");
}
