//! Designs that need motions linear in the rates refuse a fluid whose viscosity depends on the
//! shear rate.

use design::learn::rewards;
use design::{DesignError, best_sizes, connection, design_stroke};
use scene::Scene;
use testkit::contains;

fn thinning() -> Scene {
    crate::two_arms(1e-3)
        .with("model.kind", "fem")
        .with("fluid.law", "carreau")
        .with("fluid.zero_shear_viscosity", 1)
        .with("fluid.relaxation_time", 1)
        .with("fluid.index", 0.5)
        .with("learn.contracted", 6)
        .scene()
}

#[test]
fn designs_refuse_a_viscosity_law_with_its_key() {
    let scene = thinning();
    let mut model = models::FemModel::new(&scene).unwrap();
    let folder = std::env::temp_dir().join("microswim-design-rheology");
    let refusals: [Option<DesignError>; 4] = [
        connection(&scene, &mut model, &[10.0, 10.0]).err(),
        rewards(&scene, &mut ()).err(),
        best_sizes(&scene, &mut ()).err(),
        design_stroke(&scene, &folder, &mut ()).err(),
    ];
    for (number, refusal) in refusals.into_iter().enumerate() {
        let error = refusal.expect("a refusal");
        contains(number, &error.to_string(), &["fluid.law", "shear rate"]);
    }
}
