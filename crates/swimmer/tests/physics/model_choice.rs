//! The choice of the model by `model.kind = "auto"`.

use swimmer::choose;
use testkit::exact::STROKE;
use testkit::{run, start_by, three_spheres, within};

#[test]
fn auto_chooses_three_models_for_three_tolerances_and_meets_each() {
    let mut chosen = Vec::new();
    for tolerance in [1e-2, 1e-4, 1e-8] {
        let scene = three_spheres().tolerance(tolerance).scene();
        let mut choice = choose(&scene).unwrap();
        assert_eq!(choice.reasons.len(), 3, "{:?}", choice.reasons);
        let net = run(&scene).displacement[1].x;
        within(net / STROKE.value - 1.0, tolerance, "the tolerance");
        let start = start_by(choice.model.as_mut());
        chosen.push((choice.model.name(), start.dofs.total));
    }
    chosen.dedup();
    assert_eq!(chosen.len(), 3, "{chosen:?}");
}

#[test]
fn auto_chooses_rpy_where_it_is_accurate_enough() {
    // RPY has an error of 3 % for this stroke.
    let choice = choose(&three_spheres().tolerance(0.1).scene()).unwrap();
    assert_eq!(choice.model.name(), "rpy");
}
