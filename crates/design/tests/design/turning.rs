//! Strokes of swimmers that turn.

use design::{SampledPath, Stroke, StrokeLimits, design_stroke, tabulate};
use swimmer::models::TablePart;
use swimmer::spans;
use testkit::{SceneText, within};

/// Two spheres that a slide connects, and a third one on a hinge.
fn hinged() -> SceneText {
    let hinge = "joint = \"hinge\", axis = [0, 0, 1], pivot = [0, 0, 0]";
    SceneText::new()
        .sphere("tail", 1.0, [-5, 0, 0])
        .sphere("middle", 1.0, [0; 3])
        .sphere("head", 1.3, [4.5, 0.0, 0.0])
        .slide("arm", "tail", "middle")
        .joint("neck", "head", "middle", hinge)
        .model("multipole", 1e-4)
        .set(&["optimise.objective=rotation", "optimise.rotation=0.05"])
        .set(&["optimise.terms=8", "optimise.tolerance=1e-3"])
        .with("optimise.lower", "{ arm = 4, neck = -0.8 }")
        .with("optimise.upper", "{ arm = 7, neck = 0.8 }")
}

/// The stroke turns by the asked angle, by the table and by the model, and the motion of the root
/// body is the same in both.
#[test]
fn a_hinged_swimmer_turns_by_the_asked_angle() {
    let folder = tempfile::tempdir().unwrap();
    let found = design_stroke(&hinged().scene(), folder.path(), &mut ()).unwrap();
    within(
        found.optimum.totals.rotation.z - 0.05,
        1e-5,
        "the tolerance of the search",
    );
    let bars = found.table_error + found.outcome.error_estimate.total();
    // Bars are of displacements; the arms are about 5 long.
    within(
        found.outcome.rotation.z - 0.05,
        1e-5 + bars,
        "the search and both error bars",
    );
    let error = found.run_displacement - found.optimum.totals.displacement.norm();
    within(error, bars, "both error bars");
    // The other way round costs the same energy: the stroke is passed in the opposite direction.
    let back = hinged().with("optimise.rotation", -0.05).scene();
    let folder = tempfile::tempdir().unwrap();
    let back = design_stroke(&back, folder.path(), &mut ()).unwrap();
    let ratio = back.optimum.period_energy_product / found.optimum.period_energy_product;
    within(ratio - 1.0, 2e-3, "the tolerance of both searches");
}

/// Each cycle turns by the same angle, so many of them turn by a multiple of it.
#[test]
fn bug_the_rotation_of_a_stroke_was_wrapped_beyond_half_a_turn() {
    let corners = [
        ("arm", 4.2),
        ("neck", 0.7),
        ("arm", 6.5),
        ("neck", 0.0),
        ("arm", 5.0),
    ];
    let scene = hinged().phases(&corners).scene();
    let limits = StrokeLimits::from_scene(&scene).unwrap();
    let table = tabulate(&scene, &limits, 1e-4, (None, TablePart::Whole), &mut ()).unwrap();
    let start = scene.articulation().initial_shape();
    let cycle = SampledPath::from_spans(spans(scene.gait(), start).unwrap(), &limits.variables);
    let rotation = |cycles: usize| {
        let mut path = cycle.clone();
        path.widths = path.widths.repeat(cycles);
        path.shapes = vec![path.shapes; cycles].concat();
        path.rates = vec![path.rates; cycles].concat();
        Stroke::along(&table.geometry, &path)
            .unwrap()
            .totals
            .rotation
    };
    let once = rotation(1);
    let cycles = (8.0 / once.norm()).ceil() as usize;
    let error = rotation(cycles) - once * cycles as f64;
    within(error.norm(), 1e-10, "rounding of thousands of products");
}
