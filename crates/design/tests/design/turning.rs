//! Strokes of swimmers that turn.

use design::design_stroke;
use swimmer::Scene;
use swimmer::scene::Document;

/// Two spheres that a slide connects, and a third one on a hinge.
const HINGED: &str = r#"
    model = { kind = "multipole", tolerance = 1e-4 }
    bodies = [
        { name = "tail", radius = 1, position = [-5, 0, 0] },
        { name = "middle", radius = 1, position = [0, 0, 0] },
        { name = "head", radius = 1.3, position = [4.5, 0, 0] },
    ]
    links = [
        { name = "arm", body = "tail", to = "middle" },
        { name = "neck", body = "head", to = "middle", joint = "hinge", axis = [0, 0, 1], pivot = [0, 0, 0] },
    ]
    [optimise]
    objective = "rotation"
    rotation = 0.05
    lower = { arm = 4, neck = -0.8 }
    upper = { arm = 7, neck = 0.8 }
    terms = 8
    tolerance = 1e-3
"#;

/// The stroke turns by the asked angle, by the table and by the model, and the motion of the root
/// body is the same in both.
#[test]
fn a_hinged_swimmer_turns_by_the_asked_angle() {
    let folder = tempfile::tempdir().unwrap();
    let scene = Scene::parse(HINGED).unwrap();
    let found = design_stroke(&scene, folder.path(), &mut ()).unwrap();
    assert!((found.optimum.totals.rotation.z - 0.05).abs() < 1e-5);
    let bars = found.table_error + found.outcome.error_estimate.total();
    // Bars are of displacements; the arms are about 5 long.
    assert!((found.outcome.rotation.z - 0.05).abs() < 1e-5 + bars);
    let error = (found.run_displacement - found.optimum.totals.displacement.norm()).abs();
    assert!(error <= bars, "{error:e} {bars:e}");
    // The other way round costs the same energy: the stroke is passed in the opposite direction.
    let mut document = Document::parse(&scene.to_toml().unwrap(), "scene.toml".as_ref()).unwrap();
    document.set("optimise.rotation=-0.05").unwrap();
    let back = Scene::from_document(document).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let back = design_stroke(&back, folder.path(), &mut ()).unwrap();
    let ratio = back.optimum.period_energy_product / found.optimum.period_energy_product;
    assert!((ratio - 1.0).abs() < 2e-3, "{ratio}");
}
